//! Moves a robot as a plan says.

use core::marker::PhantomData;

use mrroc::prelude::*;
use mrroc::robot::JointVector;

use crate::error::PlanError;
use crate::plan::Plan;

/// How far a robot may be from where a plan begins [rad or m]: what computing the same position twice may cost.
const SAME: f64 = 1e-9;

/// Moves the joints of one robot along a [`Plan`]. For several robots, `Each::of` takes one for each of them.
pub struct FollowPlan<R: Robot> {
    plan: Plan,
    /// The robot's first joint in the plan.
    first: usize,
    time: f64,
    of: PhantomData<fn() -> R>,
}

impl Plan {
    /// The motion of the robot of this name.
    ///
    /// # Errors
    /// [`PlanError::NoRobot`], [`PlanError::Joints`] for a robot of another kind.
    pub fn motion<R: Robot>(&self, robot: &str) -> Result<FollowPlan<R>, PlanError> {
        let joints = self.motion.limits.robots[self.place_of(robot)?].clone();
        if joints.len() != R::Joints::LEN {
            return Err(PlanError::Joints { expected: R::Joints::LEN, actual: joints.len() });
        }
        Ok(FollowPlan { plan: self.clone(), first: joints.start, time: 0.0, of: PhantomData })
    }
}

impl<R: Robot> FollowPlan<R> {
    fn at(&self, time: f64) -> R::Joints {
        R::Joints::from_joints(|i| self.plan.motion.joint_at(time, self.first + i))
    }

    fn advance(&mut self, t: Tick) -> Step<R> {
        let duration = self.plan.duration();
        if self.time >= duration {
            return Step::Done;
        }
        self.time += t.dt;
        // The sum of n increments may miss n * dt by rounding; that must not cost a step.
        if duration - self.time <= 1e-9 * t.dt {
            self.time = duration;
        }
        Step::Next(Demand::joints(self.at(self.time)))
    }
}

#[generator(ecp)]
impl<R: Robot> FollowPlan<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        let (start, here) = (self.at(0.0), e.demanded().joints);
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
