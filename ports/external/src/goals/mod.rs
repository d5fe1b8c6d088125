//! Trajectories that a program of others has robots follow, such as the bridge to ROS 2.
//!
//! In: goals, each for one robot or several, and cancellations. Out: robots that follow them, each checked as a whole before it
//! begins; and what became of it. A goal's points are in a file of the folder of ports, whose number a virtual sensor tells the MP; the MP
//! reads it between two instructions and records it, so that a replay moves the robots as the run did.
//!
//! ```text
//!   bridge ── file with the points ──▶ folder of ports ──▶ MP, by `Mp::recorded`
//!          ── GoalNews: newest goal, cancelled goals ─────▶ MP, by the sensor's readings
//!          ◀── GoalState: what became of it ────────────── MP, by the sensor's orders
//! ```
//!
//! A program of the MP offers its robots in a few lines:
//!
//! ```
//! use mrroc::prelude::*;
//! use mrroc_external::TrajectoryGoals;
//!
//! fn program<R: Robot>(mp: &mut Mp) -> Result<(), Fault> {
//!     let (mut left, mut right) = (mp.robot::<R>("left")?, mp.robot::<R>("right")?);
//!     let mut goals = TrajectoryGoals::new(mp, "goals", &["left", "right"])?;
//!     let follow = Each::of((goals.motion::<R>("left")?, goals.motion::<R>("right")?));
//!     mp.start_robots((&mut left, &mut right), follow)?;
//!     loop {
//!         goals.next(mp)?;
//!     }
//! }
//! ```

mod goal;
mod served;
#[cfg(test)]
mod tests;

use mrroc::cell::{CellError, SensorSetup};
use mrroc::fault::Fault;
use mrroc::payload::Payload;
use mrroc::sensor::{ReadingOrder, Sensor, VirtualSensor};
use mrroc_launch::cell_file::CellFile;

pub use goal::{Goal, GoalFile, MOST_WORDS};
pub use served::{GoalEnd, TrajectoryGoals};

use crate::External;
use crate::numbers::Numbers;
use crate::port::port_of_cell;

/// The most robots whose goals one sensor tells.
pub const MOST_ROBOTS: usize = 8;

/// What the program that sends goals says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Payload)]
pub struct GoalNews {
    /// The number of the newest goal, 0 for none. No two goals have the same number, whoever sends them.
    pub newest: u64,
    /// Goals that are cancelled, 0 for none: a place for each robot that may follow one of its own.
    pub cancelled: [u64; MOST_ROBOTS],
}

/// What became of goals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct GoalState {
    /// The newest goal that was looked at, 0 before the first one.
    pub taken: u64,
    /// What became of that one: 0 where it was begun, otherwise why not.
    pub refusal: u32,
    /// What a refusal is about: joint and point, counted from 1, the value, and its limit.
    pub about: [f64; 4],
    /// The last goal of each robot that the program offers, 0 for none.
    pub goals: [u64; MOST_ROBOTS],
    /// Bits of the robots whose goal is over, the first robot's the lowest one.
    pub over: u32,
    /// Bits of those that were told to get to its last point.
    pub done: u32,
}

impl GoalState {
    /// The goals that are at work, a place for each robot, 0 for none.
    #[must_use]
    pub fn at_work(&self) -> [u64; MOST_ROBOTS] {
        core::array::from_fn(|place| if self.over >> place & 1 == 1 { 0 } else { self.goals[place] })
    }

    /// How a goal has ended: `None` while it is at work, `false` where its robots were brought to rest before its last point, or it is
    /// not there any more.
    #[must_use]
    pub fn ended(&self, goal: u64) -> Option<bool> {
        let Some(place) = self.goals.iter().position(|&number| number == goal) else { return Some(false) };
        let is_in = |bits: u32| bits >> place & 1 == 1;
        is_in(self.over).then(|| is_in(self.done))
    }
}

/// Why a goal was not begun, in [`GoalState::refusal`].
pub mod refusal {
    /// It was there before the program offered its robots.
    pub const OLD: u32 = 1;
    /// Its file cannot be read.
    pub const UNREADABLE: u32 = 2;
    /// The program does not offer a robot of it.
    pub const NOT_OFFERED: u32 = 3;
    /// A robot moves by a goal of other robots, too.
    pub const SHARED: u32 = 4;
    /// A robot is not where it begins.
    pub const START: u32 = 5;
    /// A joint would exceed its position limits, or those of velocity, acceleration and jerk.
    pub const POSITION: u32 = 6;
    /// See [`POSITION`].
    pub const VELOCITY: u32 = 7;
    /// See [`POSITION`].
    pub const ACCELERATION: u32 = 8;
    /// See [`POSITION`].
    pub const JERK: u32 = 9;
    /// Something else is wrong with its points.
    pub const POINTS: u32 = 10;
}

/// The virtual sensor that tells the MP of goals.
pub struct Goals;

impl Sensor for Goals {
    const KIND: &'static str = "goals";
    type Reading = GoalNews;
    type Configuration = GoalState;
}

/// In its place where no program is: under the virtual clock. There are no goals.
struct NoGoals;

impl VirtualSensor for NoGoals {
    type Kind = Goals;

    fn aggregate(&mut self, _: &ReadingOrder<GoalState>) -> Result<GoalNews, Fault> {
        Ok(GoalNews::default())
    }
}

impl Goals {
    /// The sensor `name` of the cell file, for its MP.
    ///
    /// # Errors
    /// The file has no such sensor, or says nothing of an external program for it.
    pub fn in_cell(file: &CellFile, name: &str) -> Result<SensorSetup<External<Goals>>, CellError> {
        // Its numbers are names of goals: a wrong one is a goal that is not there.
        let entry = file.external(name)?;
        let goals = External::<Goals>::of(entry, Numbers::unbounded()).at(port_of_cell(entry));
        Ok(file.sensor(name, goals)?.stand_in(NoGoals))
    }
}
