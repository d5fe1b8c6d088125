//! Passes the coordinator's displacements on to a robot that yields where its grasp transmits nothing.

use mrroc::{Demand, Fault, Order, Robot, State, Step, generator};

use mrroc_generators::cooperation::{Arm, ArmModel, Displacement, FreeDirection};

/// The ECP's half of tight cooperation by displacements for an arm with fewer joints than a pose has coordinates: the tool
/// turns or slides in the free direction of its grasp to where the joints can put it, and is on the pose else.
///
/// A pose that the arm cannot take even so is a fault that names the direction;
/// [`dry_run`](mrroc_generators::cooperation::dry_run) finds it before anything moves.
pub struct YieldingTransmit<R: Robot> {
    robot: R,
    free: FreeDirection,
    arm: Option<Arm<R>>,
}

impl<R: Robot> YieldingTransmit<R> {
    /// For a robot with these kinematics, whose grasp is free in a direction of the tool's frame.
    #[must_use]
    pub const fn by(robot: R, free: FreeDirection) -> Self {
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
        arm.follow(&X_WE).map_err(|refused| Fault::thrown(&refused.to_string()))?;
        Ok(Step::Next(Demand::joints(*arm.joints())))
    }
}
