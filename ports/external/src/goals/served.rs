//! What a program of the MP does with goals.

use std::collections::VecDeque;

use mrroc::fault::FaultKind;
use mrroc::generator::SensorHandle;
use mrroc::prelude::*;
use mrroc_generators::generators::FollowTrajectory;
use mrroc_generators::trajectory::{Outcome, Quantity, TrajectoryError, TrajectoryGroup};

use super::{Goal, GoalFile, GoalNews, GoalState, Goals, MOST_ROBOTS, refusal};

/// How a goal has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoalEnd {
    /// The robots have been told to get to its last point.
    Done,
    /// It was cancelled, and the robots have come to rest on their path.
    Cancelled,
    /// It was refused, and has moved nothing.
    Refused,
    /// Another one has replaced it.
    Replaced,
}

/// Robots of a program of the MP, offered to whoever sends goals: one or several of them as one goal.
///
/// The robots follow goals in one Move in the background, by [`motion`](Self::motion); the program serves goals by [`next`](Self::next). A goal for robots that
/// move by one, the same robots, replaces it.
pub struct TrajectoryGoals {
    sensor: SensorHandle<Goals>,
    group: TrajectoryGroup,
    robots: Vec<String>,
    /// What is told of goals.
    state: GoalState,
    /// Goals that have ended and were not told yet.
    ended: VecDeque<GoalEnd>,
    /// Whether the sensor has said anything yet.
    has_begun: bool,
}

/// Something has changed: what the sensor says, or how many robots follow a goal.
struct Changed {
    group: TrajectoryGroup,
    at_work: [u64; MOST_ROBOTS],
    following: usize,
    /// `None` at first: whatever is there is news.
    taken: Option<u64>,
    news: GoalNews,
}

#[condition(mp)]
fn changed(c: &mut Changed, goals: &Reading<(Goals,)>) -> bool {
    let Some(news) = goals.0.reading() else { return false };
    c.news = news;
    let Some(taken) = c.taken else { return true };
    let is_new = news.newest != 0 && news.newest != taken;
    let cancels = c.at_work.iter().any(|number| *number != 0 && news.cancelled.contains(number));
    is_new || cancels || c.group.following() != c.following
}

impl TrajectoryGoals {
    /// Offers robots of the cell to the goals of a sensor.
    ///
    /// # Errors
    /// `Config`: the cell gives the MP no such sensor, or there are too many robots.
    pub fn new(mp: &mut Mp, sensor: &str, robots: &[&str]) -> Result<Self, Fault> {
        if robots.len() > MOST_ROBOTS {
            return Err(Fault::thrown(&format!("goals are for at most {MOST_ROBOTS} robots")));
        }
        Ok(TrajectoryGoals {
            sensor: mp.sensor::<Goals>(sensor)?,
            group: TrajectoryGroup::new(robots),
            robots: robots.iter().map(|&name| name.to_owned()).collect(),
            state: GoalState::default(),
            ended: VecDeque::new(),
            has_begun: false,
        })
    }

    /// The motion of the robot of this name, for `Each::of` all of them.
    ///
    /// # Errors
    /// The robot is not offered.
    pub fn motion<R: Robot>(&self, robot: &str) -> Result<FollowTrajectory<R>, Fault> {
        self.group.motion(robot).map_err(|why| Fault::thrown(&why.to_string()))
    }

    /// Serves goals until one has ended, and tells how. Their robots move in the background meanwhile.
    ///
    /// # Errors
    /// The [`Fault`] that ended it: `SensorStale` where the program that sends goals says nothing any more, for one.
    pub fn next(&mut self, mp: &mut Mp) -> Result<GoalEnd, Fault> {
        loop {
            // A motion of the robots may have ended otherwise since the last call.
            self.note_ends();
            if let Some(end) = self.ended.pop_front() {
                return Ok(end);
            }
            self.sensor.configure(self.state);
            let changed = Changed {
                group: self.group.clone(),
                at_work: self.state.at_work(),
                following: self.group.following(),
                taken: self.has_begun.then_some(self.state.taken),
                news: GoalNews::default(),
            };
            let news = mp.wait_until((), (&mut self.sensor,), changed)?.news;
            self.note_ends();
            self.cancel(&news);
            // What has ended is told first: a new goal takes its place.
            if self.ended.is_empty() && news.newest != self.state.taken && news.newest != 0 {
                self.take(mp, news.newest)?;
            }
            self.has_begun = true;
        }
    }

    /// Goals whose robots have come to rest.
    fn note_ends(&mut self) {
        for place in 0..self.robots.len() {
            let at_work = self.state.at_work();
            let number = at_work[place];
            let outcome = self.group.outcome(&self.robots[place]).ok().flatten();
            let Some(outcome) = outcome.filter(|_| number != 0) else { continue };
            // All robots of a goal end in the same step.
            for (other, _) in at_work.iter().enumerate().filter(|(_, other)| **other == number) {
                self.state.over |= 1 << other;
                self.state.done |= u32::from(outcome == Outcome::Done) << other;
            }
            self.ended.push_back(match outcome {
                Outcome::Done => GoalEnd::Done,
                Outcome::Halted | Outcome::Ended => GoalEnd::Cancelled,
            });
        }
    }

    fn cancel(&mut self, news: &GoalNews) {
        for (name, number) in self.robots.iter().zip(self.state.at_work()) {
            if number != 0 && news.cancelled.contains(&number) {
                // It is one of the group.
                drop(self.group.halt(name));
            }
        }
    }

    /// Takes the newest goal, or refuses it.
    fn take(&mut self, mp: &mut Mp, number: u64) -> Result<(), Fault> {
        (self.state.taken, self.state.refusal, self.state.about) = (number, 0, [0.0; 4]);
        if !self.has_begun {
            self.state.refusal = refusal::OLD;
            return Ok(());
        }
        let goal = mp.recorded("goal", || GoalFile::read(number));
        let refused = match goal {
            Ok(goal) => self.begin(number, &goal),
            // A replay of another program.
            Err(fault) if fault.kind() == FaultKind::Config => return Err(fault),
            Err(_) => Err((refusal::UNREADABLE, [0.0; 4])),
        };
        if let Err((why, about)) = refused {
            (self.state.refusal, self.state.about) = (why, about);
            self.ended.push_back(GoalEnd::Refused);
        }
        Ok(())
    }

    fn begin(&mut self, number: u64, goal: &Goal) -> Result<(), (u32, [f64; 4])> {
        let names: Vec<&str> = goal.robots.iter().map(|name| name.as_str()).collect();
        self.group.begin_after(&names, &goal.trajectory, goal.delay).map_err(|why| told(&why))?;
        for name in names {
            let Some(place) = self.robots.iter().position(|robot| robot == name) else { continue };
            let before = self.state.at_work()[place];
            self.state.goals[place] = number;
            self.state.over &= !(1 << place);
            self.state.done &= !(1 << place);
            if before != 0 && !self.state.at_work().contains(&before) {
                self.ended.push_back(GoalEnd::Replaced);
            }
        }
        Ok(())
    }
}

/// A refusal in the words of [`GoalState`].
fn told(why: &TrajectoryError) -> (u32, [f64; 4]) {
    match *why {
        TrajectoryError::Robot(_) | TrajectoryError::NotFollowing(_) => (refusal::NOT_OFFERED, [0.0; 4]),
        TrajectoryError::Shared(_) => (refusal::SHARED, [0.0; 4]),
        TrajectoryError::Start { joint, position, start } => {
            (refusal::START, [joint as f64, 0.0, position, start])
        }
        TrajectoryError::Limit { quantity, joint, point, value, limit } => {
            let why = match quantity {
                Quantity::Position => refusal::POSITION,
                Quantity::Velocity => refusal::VELOCITY,
                Quantity::Acceleration | Quantity::StepOfAcceleration => refusal::ACCELERATION,
                Quantity::Jerk => refusal::JERK,
            };
            (why, [joint as f64, point as f64, value, limit])
        }
        TrajectoryError::Limits { .. }
        | TrajectoryError::Empty
        | TrajectoryError::Values { .. }
        | TrajectoryError::NotFinite { .. }
        | TrajectoryError::Mixed { .. }
        | TrajectoryError::Time { .. }
        | TrajectoryError::MovingEnd { .. }
        | TrajectoryError::Past { .. }
        | TrajectoryError::Spline(_)
        | TrajectoryError::Joints { .. } => (refusal::POINTS, [0.0; 4]),
    }
}
