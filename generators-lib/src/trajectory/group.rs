//! Robots that follow trajectories: alone, or several of them on one path time.

use core::cell::RefCell;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc::robot::JointVector;

use super::error::TrajectoryError;
use super::halt::Halt;
use super::path::{JointState, TimedPath};
use super::{JointTrajectory, MOST_JOINTS};
use crate::generators::FollowTrajectory;

/// How a trajectory has come to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The robots have been told to get to its last point.
    Done,
    /// They were brought to rest on their path before that.
    Halted,
    /// The Move ended.
    Ended,
}

/// Robots that follow trajectories in one Move, which is at work until [`finish`](Self::finish). Clones are the same: one stays with the program of the
/// MP, which begins trajectories between its instructions while the robots go on in the background.
///
/// A trajectory is for one robot or for several. Those of one trajectory are on one path time, so that they keep what it says of their relative poses, also
/// where it is cancelled. A robot without one stays where it is.
#[derive(Clone)]
pub struct TrajectoryGroup(Rc<RefCell<Vec<Member>>>);

/// One robot.
struct Member {
    name: String,
    /// Where it is told to be [rad or m]; nothing before its Move has begun.
    joints: Vec<f64>,
    /// What it follows, or has followed last: a step takes nothing away, which would cost it time.
    last: Option<Following>,
    /// How that has ended.
    outcome: Option<Outcome>,
    is_to_finish: bool,
    /// How many motions of it have begun.
    motions: u64,
}

/// A robot's part of a trajectory.
#[derive(Clone)]
struct Following {
    execution: Rc<RefCell<Execution>>,
    /// Its first joint in the trajectory.
    first: usize,
    /// Steps that it has taken.
    steps: u64,
}

/// A trajectory that robots follow.
struct Execution {
    path: TimedPath,
    /// How many robots follow it.
    robots: usize,
    /// Path time; below 0 while the robots wait for its beginning \[s\].
    time: f64,
    halt: Option<Halt>,
    /// Path time of its last step \[s\], and that over real time.
    dt: f64,
    share: f64,
    /// Steps that it has been advanced by.
    steps: u64,
    /// How it ended, in the step in which it did.
    ended: Option<Outcome>,
}

impl Execution {
    fn rate(&self) -> (f64, f64) {
        self.halt.map_or((1.0, 0.0), |halt| (halt.rate, halt.slope))
    }

    fn advance(&mut self, t: Tick) {
        let dt = t.dt;
        if let Some(halt) = &mut self.halt {
            halt.advance(&self.path, self.time, t, self.share);
        }
        if dt > 0.0 {
            (self.dt, self.share) = (dt, dt / t.duration);
        }
        let (rate, _) = self.rate();
        self.time += rate * dt;
        let duration = self.path.duration();
        // The sum of n increments may miss n * dt by rounding; that must not cost a step.
        if duration - self.time <= 1e-9 * dt {
            self.time = duration;
            self.ended = Some(Outcome::Done);
        } else if rate == 0.0 || (self.halt.is_some() && self.time <= 0.0) {
            self.ended = Some(Outcome::Halted);
        }
    }

    /// What is demanded of a joint, in the cell's path time.
    fn state(&self, joint: usize) -> JointState {
        let [position, velocity, acceleration] = self.path.at(self.time, joint);
        if self.time < 0.0 {
            return JointState::resting(position);
        }
        let (rate, slope) = self.rate();
        // The rate of a step is that of its middle.
        let rate = (rate + 0.5 * slope * self.dt).max(0.0);
        JointState {
            position,
            velocity: rate * velocity,
            acceleration: rate * rate * acceleration + slope * velocity,
        }
    }
}

impl TrajectoryGroup {
    /// Of robots with these names, which stay where they are at first.
    #[must_use]
    pub fn new(robots: &[&str]) -> Self {
        let member = |name: &&str| Member {
            name: (*name).to_owned(),
            joints: Vec::with_capacity(MOST_JOINTS),
            last: None,
            outcome: None,
            is_to_finish: false,
            motions: 0,
        };
        TrajectoryGroup(Rc::new(RefCell::new(robots.iter().map(member).collect())))
    }

    /// The motion of the robot of this name, for `Each::of` all of them.
    ///
    /// # Errors
    /// [`TrajectoryError::Robot`].
    pub fn motion<R: Robot>(&self, robot: &str) -> Result<FollowTrajectory<R>, TrajectoryError> {
        Ok(FollowTrajectory::in_group(self.clone(), self.place(robot)?))
    }

    fn place(&self, robot: &str) -> Result<usize, TrajectoryError> {
        let place = self.0.borrow().iter().position(|member| member.name == robot);
        place.ok_or_else(|| TrajectoryError::Robot(robot.to_owned()))
    }

    /// From their next step on these robots follow a trajectory, whose joints are theirs, one robot behind the other. If they move by one, this one replaces
    /// it, and begins with their velocities and accelerations. Call it between two instructions.
    ///
    /// # Errors
    /// Then nothing changes: [`TrajectoryError::Robot`], [`TrajectoryError::NotFollowing`], [`TrajectoryError::Shared`], and those of
    /// [`TimedPath::from`].
    pub fn begin(&self, robots: &[&str], trajectory: &JointTrajectory) -> Result<(), TrajectoryError> {
        self.begin_after(robots, trajectory, 0.0)
    }

    /// The same of robots that wait for some path time first \[s\], unless they move.
    ///
    /// # Errors
    /// Those of [`begin`](Self::begin).
    pub fn begin_after(
        &self,
        robots: &[&str],
        trajectory: &JointTrajectory,
        delay: f64,
    ) -> Result<(), TrajectoryError> {
        let mut places = Vec::with_capacity(robots.len());
        for robot in robots {
            let place = self.place(robot)?;
            if places.contains(&place) {
                return Err(TrajectoryError::Robot((*robot).to_owned()));
            }
            places.push(place);
        }
        let states = self.states(&places)?;
        let path = TimedPath::from(trajectory, &states)?;
        let mut members = self.0.borrow_mut();
        let moves = states.iter().any(|state| state.velocity != 0.0 || state.acceleration != 0.0);
        let time = if moves { 0.0 } else { -delay.max(0.0) };
        let execution = Execution {
            path,
            robots: places.len(),
            time,
            halt: None,
            dt: 0.0,
            share: 1.0,
            steps: 0,
            ended: None,
        };
        let execution = Rc::new(RefCell::new(execution));
        let mut first = 0;
        for place in places {
            let member = &mut members[place];
            member.last = Some(Following { execution: Rc::clone(&execution), first, steps: 0 });
            member.outcome = None;
            first += member.joints.len();
        }
        Ok(())
    }

    /// What is demanded of these robots, which follow nothing or the same trajectory alone.
    fn states(&self, places: &[usize]) -> Result<Vec<JointState>, TrajectoryError> {
        let members = self.0.borrow();
        let mut states = Vec::new();
        for &place in places {
            let member = &members[place];
            if member.joints.is_empty() || member.is_to_finish {
                return Err(TrajectoryError::NotFollowing(member.name.clone()));
            }
            let Some(following) = member.following() else {
                states.extend(member.joints.iter().copied().map(JointState::resting));
                continue;
            };
            let same = |&&place: &&usize| {
                let other = members[place].following();
                other.is_some_and(|other| Rc::ptr_eq(&other.execution, &following.execution))
            };
            let execution = following.execution.borrow();
            if places.iter().filter(same).count() != execution.robots {
                return Err(TrajectoryError::Shared(member.name.clone()));
            }
            let joints = following.first..following.first + member.joints.len();
            states.extend(joints.map(|joint| execution.state(joint)));
        }
        Ok(states)
    }

    /// Brings a robot to rest on its path, with all that move by the same trajectory. Nothing happens to one that follows none.
    ///
    /// # Errors
    /// [`TrajectoryError::Robot`].
    pub fn halt(&self, robot: &str) -> Result<(), TrajectoryError> {
        let place = self.place(robot)?;
        if let Some(following) = self.0.borrow()[place].following() {
            let mut execution = following.execution.borrow_mut();
            if execution.halt.is_none() {
                execution.halt = Some(Halt::at(&execution.path, execution.time));
            }
        }
        Ok(())
    }

    /// How the last trajectory of a robot has ended; `None` while it follows one, or has followed none.
    ///
    /// # Errors
    /// [`TrajectoryError::Robot`].
    pub fn outcome(&self, robot: &str) -> Result<Option<Outcome>, TrajectoryError> {
        let place = self.place(robot)?;
        Ok(self.0.borrow()[place].outcome)
    }

    /// Robots that follow a trajectory now.
    #[must_use]
    pub fn following(&self) -> usize {
        self.0.borrow().iter().filter(|member| member.following().is_some()).count()
    }

    /// The motion of all robots ends where their trajectories do, or at once where they follow none; no other one is begun.
    pub fn finish(&self) {
        for member in self.0.borrow_mut().iter_mut() {
            member.is_to_finish = true;
        }
    }

    /// The motion of a robot begins, at these joint positions; its number among those of the robot.
    pub(crate) fn start(&self, place: usize, joints: &[f64]) -> u64 {
        let member = &mut self.0.borrow_mut()[place];
        member.end(Outcome::Ended);
        member.joints.clear();
        member.joints.extend_from_slice(joints);
        member.motions += 1;
        member.motions
    }

    /// A motion of a robot has ended, unless another one has begun.
    pub(crate) fn leave(&self, place: usize, motion: u64) {
        let member = &mut self.0.borrow_mut()[place];
        if member.motions == motion {
            member.end(Outcome::Ended);
            member.joints.clear();
        }
    }

    /// Goes on by a step; where the robot is to be, or `None` where its motion is over.
    pub(crate) fn advance<J: JointVector>(&self, place: usize, t: Tick) -> Option<J> {
        let member = &mut self.0.borrow_mut()[place];
        let follows = member.following().is_some();
        match &mut member.last {
            None | Some(_) if !follows && member.is_to_finish => return None,
            Some(following) if follows => {
                let mut execution = following.execution.borrow_mut();
                following.steps += 1;
                // The first one to come takes all of them a step further.
                if execution.steps < following.steps {
                    execution.steps = following.steps;
                    execution.advance(t);
                }
                for (joint, position) in member.joints.iter_mut().enumerate() {
                    *position = execution.state(following.first + joint).position;
                }
                member.outcome = execution.ended;
            }
            None | Some(_) => {}
        }
        Some(J::from_joints(|i| member.joints[i]))
    }
}

impl Member {
    /// What it follows now.
    fn following(&self) -> Option<&Following> {
        self.last.as_ref().filter(|_| self.outcome.is_none())
    }

    fn end(&mut self, outcome: Outcome) {
        if self.following().is_some() {
            self.outcome = Some(outcome);
        }
    }
}
