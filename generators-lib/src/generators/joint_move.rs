//! Moves all joints along a straight line in joint space, from rest to rest.

use mrroc::prelude::*;

use mrroc_generators::line::JointLine;
use mrroc_generators::profile::ProfileCursor;

/// Moves all joints to their goals together, by one trapezoidal profile.
///
/// Starts from the joint positions demanded last, at rest.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::JointMove;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::{Irp6, Six};
///
/// let goal = Irp6::READY + Six::new(0.2, 0.1, 0.0, 0.0, 0.0, 0.0);
/// let motion = JointMove::to(goal, Six::repeat(0.4), Six::repeat(0.8));
/// let demands = rehearse(motion, &Irp6::nominal(), Irp6::READY, 0.002)?;
/// // The first joint just reaches its velocity: 2 sqrt(0.2 / 0.8) = 1 s. The second one arrives with it.
/// assert_eq!((demands.len(), demands[499].as_joints()), (500, Some(goal)));
/// # Ok::<(), Fault>(())
/// ```
pub struct JointMove<R: Robot> {
    goal: R::Joints,
    velocity: R::Joints,
    acceleration: R::Joints,
    path: Option<(JointLine<R::Joints>, ProfileCursor)>,
}

impl<R: Robot> JointMove<R> {
    /// To `goal` \[rad or m\], within a velocity [rad/s or m/s] and an acceleration [rad/s² or m/s²] per joint,
    /// all > 0. Leave a tenth of the robot's limits to the operator's feed rate.
    #[must_use]
    pub fn to(goal: R::Joints, velocity: R::Joints, acceleration: R::Joints) -> Self {
        JointMove { goal, velocity, acceleration, path: None }
    }

    fn advance(&mut self, t: Tick) -> Step<R> {
        let Some((line, cursor)) = &mut self.path else { return Step::Done };
        match cursor.advance(t.dt) {
            Some(point) => Step::Next(Demand::joints(line.joints(point.s))),
            None => Step::Done,
        }
    }
}

#[generator(ecp)]
impl<R: Robot> JointMove<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        let line = JointLine::new(e.demanded().joints, self.goal);
        let profile = line.profile(&self.velocity, &self.acceleration);
        let profile = profile.map_err(|error| Fault::thrown(&error.to_string()))?;
        self.path = Some((line, ProfileCursor::new(profile)));
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
        let robot = RobotSetup::new("irp6", Irp6::nominal(), arm).program(move |ecp| {
            ecp.move_robot((), JointMove::to(goal, Six::repeat(0.4), Six::repeat(0.8))).map(drop)
        });
        let report = Cell::new(Duration::from_millis(2)).robot(robot).run().expect("within the limits");
        // T = D / V + V / A = 0.5 / 0.4 + 0.4 / 0.8 of joint 0.
        let duration = report.time.as_secs_f64();
        assert!((1.75..1.77).contains(&duration), "{duration} s");
        assert!((shaft.state().position - goal).amax() < 1e-3);
    }
}
