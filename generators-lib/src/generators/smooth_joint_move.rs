//! Moves all joints to their goals with limited jerk, from rest to rest.

use mrroc::prelude::*;

use mrroc_generators::jerk::{JointLimits, JointState, JointTarget, MoveCursor, SynchronisedMove};

/// Moves all joints to their goals in the shortest time within limits of velocity, acceleration and jerk per joint.
///
/// The joints arrive together. They move along a straight line in joint space if the profile of the slowest joint is
/// within the limits of the others. Starts from the joint positions demanded last, at rest.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::SmoothJointMove;
/// use mrroc_generators::jerk::JointLimits;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::{Irp6, Six};
///
/// let limits = JointLimits { velocity: Six::repeat(0.5), acceleration: Six::repeat(1.0), jerk: Six::repeat(10.0) };
/// let goal = Irp6::READY + Six::new(0.5, 0.1, 0.0, 0.0, 0.0, 0.0);
/// let demands = rehearse(SmoothJointMove::to(goal, limits), &Irp6::nominal(), Irp6::READY, 0.002)?;
/// // The first joint has the largest displacement: D / V + V / A + A / J = 1.6 s.
/// assert_eq!((demands.len(), demands[799].as_joints()), (800, Some(goal)));
/// # Ok::<(), Fault>(())
/// ```
pub struct SmoothJointMove<R: Robot> {
    goal: R::Joints,
    limits: JointLimits<R::Joints>,
    motion: Option<MoveCursor<R::Joints>>,
}

impl<R: Robot> SmoothJointMove<R> {
    /// To `goal` \[rad or m\] within `limits`. Leave a tenth of the robot's limits to the operator's feed rate.
    #[must_use]
    pub fn to(goal: R::Joints, limits: JointLimits<R::Joints>) -> Self {
        SmoothJointMove { goal, limits, motion: None }
    }

    fn advance(&mut self, t: Tick) -> Step<R> {
        match self.motion.as_mut().and_then(|motion| motion.advance(t.dt)) {
            Some(point) => Step::Next(Demand::joints(point.position)),
            None => Step::Done,
        }
    }
}

#[generator(ecp)]
impl<R: Robot> SmoothJointMove<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        let start = JointState::rest(e.demanded().joints);
        let target = JointTarget::rest(self.goal);
        let motion = SynchronisedMove::new(&start, &target, &self.limits);
        let motion = motion.map_err(|error| Fault::thrown(&error.to_string()))?;
        self.motion = Some(MoveCursor::new(motion));
        Ok(self.advance(t).with_goal(Demand::joints(self.goal)))
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        self.advance(t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc_robots::{Irp6, SimulatedIrp6, Six};
    use std::time::Duration;

    #[test]
    fn the_slowest_joint_sets_the_pace_and_all_arrive() {
        let start = Irp6::READY;
        let goal = start + Six::new(0.5, 0.0, 0.0, 0.1, 0.0, -0.2);
        let arm = SimulatedIrp6::new(Irp6::nominal(), &start);
        let shaft = arm.shaft();
        let limits = JointLimits {
            velocity: Six::repeat(0.4),
            acceleration: Six::repeat(0.8),
            jerk: Six::repeat(8.0),
        };
        let robot = RobotSetup::new("irp6", Irp6::nominal(), arm)
            .program(move |ecp| ecp.move_robot((), SmoothJointMove::to(goal, limits)).map(drop));
        let report = Cell::new(Duration::from_millis(2)).robot(robot).run().expect("within the limits");
        // T = D / V + V / A + A / J = 0.5 / 0.4 + 0.4 / 0.8 + 0.8 / 8 of joint 0.
        let duration = report.time.as_secs_f64();
        assert!((1.85..1.87).contains(&duration), "{duration} s");
        assert!((shaft.state().position - goal).amax() < 1e-3);
    }
}
