//! Moves robots as a plan says, which may be changed while they move.

use core::cell::{Cell, RefCell};
use core::marker::PhantomData;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc::robot::JointVector;

use crate::error::PlanError;
use crate::plan::Plan;

/// How far a robot may be from where a plan says [rad or m]: what computing the same position twice may cost.
const SAME: f64 = 1e-9;
/// At how many instants it is looked at whether a new plan is the old one at first.
const INSTANTS: u32 = 8;

/// A plan that may be changed while robots follow it. Clones are the same: one stays with the program of the MP, whose robots follow it in one Move
/// in the background, by [`motion`](Self::motion) for each of them.
#[derive(Clone)]
pub struct Following(Rc<Followers>);

struct Followers {
    plan: RefCell<Plan>,
    /// The path time of the last demand \[s\].
    time: Cell<f64>,
    is_over: Cell<bool>,
}

impl Following {
    /// For robots that will follow `plan`, from its beginning.
    #[must_use]
    pub fn new(plan: &Plan) -> Self {
        let time = Cell::new(plan.motion.speed.begins);
        Following(Rc::new(Followers { plan: RefCell::new(plan.clone()), time, is_over: Cell::new(false) }))
    }

    /// The motion of the robot of this name.
    ///
    /// # Errors
    /// [`PlanError::NoRobot`], [`PlanError::Joints`] for a robot of another kind.
    pub fn motion<R: Robot>(&self, robot: &str) -> Result<FollowPlan<R>, PlanError> {
        let plan = self.0.plan.borrow();
        let joints = plan.motion.limits.robots[plan.place_of(robot)?].clone();
        if joints.len() != R::Joints::LEN {
            return Err(PlanError::Joints { expected: R::Joints::LEN, actual: joints.len() });
        }
        Ok(FollowPlan { following: self.clone(), first: joints.start, time: self.time(), of: PhantomData })
    }

    /// The plan that the robots follow now.
    #[must_use]
    pub fn plan(&self) -> Plan {
        self.0.plan.borrow().clone()
    }

    /// The path time that the robots have been told to get to \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.0.time.get()
    }

    /// Whether the motion has come to the end of its plan.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.0.is_over.get()
    }

    /// A condition of the MP that is met when the robots have been told to get to a path time \[s\], or the motion is over: at the latest in the step
    /// in which it ends.
    #[must_use]
    pub fn reached(&self, time: f64) -> Reached {
        Reached { following: self.clone(), time }
    }

    /// From now on the robots follow `plan`, which [`Planner::replan`](crate::Planner::replan) has made from the one that they follow. Call it between two
    /// instructions. Nothing changes before the path time from which the new plan was asked for.
    ///
    /// # Errors
    /// Then the robots follow the plan that they had. [`PlanError::TooLate`]: they have passed that path time, or have come to their end;
    /// [`PlanError::OtherPlan`]: the new plan was not made from this one.
    pub fn hand_over(&self, plan: &Plan) -> Result<(), PlanError> {
        let (now, at) = (self.time(), plan.motion.leaves);
        if now > at || self.is_over() {
            return Err(PlanError::TooLate { time: now, at });
        }
        let old = self.plan();
        let is_same = |time: f64| {
            let pairs = old.at(time).into_iter().zip(plan.at(time));
            pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) <= SAME
        };
        let mut instants = (0..=INSTANTS).map(|k| now + (at - now) * f64::from(k) / f64::from(INSTANTS));
        if old.robots != plan.robots || plan.motion.speed.begins > now || !instants.all(is_same) {
            return Err(PlanError::OtherPlan);
        }
        self.0.plan.replace(plan.clone());
        Ok(())
    }
}

/// Whether robots have been told to get to a path time of a plan: see [`Following::reached`].
pub struct Reached {
    following: Following,
    time: f64,
}

#[condition(mp)]
impl Reached {
    fn is_met(&mut self) -> bool {
        self.following.time() >= self.time || self.following.is_over()
    }
}

/// Moves the joints of one robot along a [`Plan`]. For several robots, `Each::of` takes one for each of them.
pub struct FollowPlan<R: Robot> {
    following: Following,
    /// The robot's first joint in the plan.
    first: usize,
    time: f64,
    of: PhantomData<fn() -> R>,
}

impl Plan {
    /// The motion of the robot of this name. For a plan that may be changed meanwhile there is [`Following`].
    ///
    /// # Errors
    /// [`PlanError::NoRobot`], [`PlanError::Joints`] for a robot of another kind.
    pub fn motion<R: Robot>(&self, robot: &str) -> Result<FollowPlan<R>, PlanError> {
        Following::new(self).motion(robot)
    }
}

impl<R: Robot> FollowPlan<R> {
    fn at(&self, plan: &Plan, time: f64) -> R::Joints {
        R::Joints::from_joints(|i| plan.motion.joint_at(time, self.first + i))
    }

    fn advance(&mut self, t: Tick) -> Step<R> {
        let followers = Rc::clone(&self.following.0);
        let plan = followers.plan.borrow();
        let duration = plan.duration();
        if self.time >= duration {
            followers.is_over.set(true);
            return Step::Done;
        }
        self.time += t.dt;
        // The sum of n increments may miss n * dt by rounding; that must not cost a step.
        if duration - self.time <= 1e-9 * t.dt {
            self.time = duration;
        }
        followers.time.set(self.time);
        Step::Next(Demand::joints(self.at(&plan, self.time)))
    }
}

#[generator(ecp)]
impl<R: Robot> FollowPlan<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        let (start, here) = (self.at(&self.following.0.plan.borrow(), self.time), e.demanded().joints);
        for i in 0..R::Joints::LEN {
            if (start[i] - here[i]).abs() > SAME {
                let text = format!(
                    "joint {} is at {:.6}, the plan begins at {:.6}: plan from where the robot is",
                    i + 1,
                    here[i],
                    start[i]
                );
                return Err(Fault::thrown(&text));
            }
        }
        Ok(self.advance(t))
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        self.advance(t)
    }
}
