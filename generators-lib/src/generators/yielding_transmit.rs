//! Passes the coordinator's displacements on to a robot that yields in the free direction of its grasp.

use mrroc::prelude::*;

use mrroc_generators::cooperation::{Arm, ArmModel, Displacement, FreeDirection};

/// The ECP's half of tight cooperation by displacements for an arm with fewer joints than a pose has coordinates: the
/// tool turns or slides in the free direction of its grasp to where the joints can put it, and keeps to the pose in all
/// other directions.
///
/// A pose that the arm still cannot take is a fault that names the direction;
/// [`dry_run`](mrroc_generators::cooperation::dry_run) finds it before anything moves.
///
/// ```
/// use mrroc::generator::Generator;
/// use mrroc::prelude::*;
/// use mrroc_generators::cooperation::{Displacement, FreeDirection};
/// use mrroc_generators::generators::YieldingTransmit;
/// use mrroc_generators::rehearsal::at_rest;
/// use mrroc_robots::{Five, Irp6FiveDof};
/// use nalgebra::Vector3;
///
/// // An arm of five joints, whose grasp may turn about the x axis of the tool.
/// let arm = Irp6FiveDof::nominal();
/// let start = Five::new(0.0, -1.5, 0.1, -0.170_796_326_794_896_6, 0.0);
/// let mut transmit = YieldingTransmit::by(arm.clone(), FreeDirection::Turn(Vector3::x_axis()));
/// let pose = Pose::translation(0.0, 0.01, 0.0);
/// let (e, t) = (State::new(at_rest(&arm, start)), Tick { step: 0, dt: 0.002, duration: 0.002 });
/// let step = transmit.first_step(&Order::new(Displacement { pose }), &e, &Reading::new(()), t)?;
/// // It demands joints, which put the origin of the tool where it is ordered to be.
/// let Step::Next(demand) = step else { unreachable!() };
/// let reached = demand.as_joints().map(|q| (arm.forward(&start) * pose).inv_mul(&arm.forward(&q)));
/// assert!(reached.is_some_and(|off| off.translation.vector.norm() < 1e-6), "{reached:?}");
/// # Ok::<(), Fault>(())
/// ```
pub struct YieldingTransmit<R: Robot> {
    robot: R,
    free: FreeDirection,
    arm: Option<Arm<R>>,
}

impl<R: Robot> YieldingTransmit<R> {
    /// For a robot with these kinematics, whose grasp is free in a direction of the tool's frame.
    #[must_use]
    pub fn by(robot: R, free: FreeDirection) -> Self {
        YieldingTransmit { robot, free, arm: None }
    }
}

#[generator(ecp)]
impl<R: Robot> YieldingTransmit<R> {
    fn first_step(&mut self, order: &Order<Displacement>, e: &State<R>) -> Result<Step<R>, Fault> {
        self.arm = Some(Arm::new(self.robot.clone(), e.demanded()).free_in(self.free));
        self.next_step(order)
    }

    #[allow(non_snake_case)]
    fn next_step(&mut self, order: &Order<Displacement>) -> Result<Step<R>, Fault> {
        let Some(arm) = &mut self.arm else { return Ok(Step::Next(Demand::hold())) };
        let X_WE = arm.start() * order.value().pose;
        arm.follow(&X_WE).map_err(|refused| Fault::from(&*refused))?;
        Ok(Step::Next(Demand::joints(*arm.joints())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::pose::Pose;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc_robots::{Five, Irp6FiveDof};
    use nalgebra::Vector3;

    #[test]
    #[allow(non_snake_case)]
    fn an_arm_of_five_joints_goes_aside_and_turns_where_it_may() {
        // The tool is level; its x axis is upright.
        let robot = Irp6FiveDof::nominal();
        let q = Five::new(0.0, -1.5, 0.1, -0.170_796_326_794_896_6, 0.0);
        let X_WE = robot.forward(&q);
        let state = RobotState { joints: q, velocity: Five::zeros(), pose: X_WE };
        let aside = X_WE.inverse() * Pose::translation(0.0, 0.02, 0.0) * X_WE;
        let order = Order::new(Displacement { pose: aside });
        let mut generator = YieldingTransmit::by(robot.clone(), FreeDirection::Turn(Vector3::x_axis()));
        let step = generator.first_step(&order, &State::new(RobotImage::new(state, state)));
        let angle = (0.02 / X_WE.translation.x).atan();
        let arm = generator.arm.as_ref().expect("made in the first step");
        assert_eq!(step.expect("attainable"), Step::Next(Demand::joints(*arm.joints())));
        assert!((arm.joints()[0] - angle).abs() < 1e-9);
        let reached = robot.forward(arm.joints()).translation.vector - X_WE.translation.vector;
        assert!((reached - Vector3::y() * 0.02).norm() < 1e-9, "{reached}");
    }
}
