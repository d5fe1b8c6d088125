//! Drives in the world: of an arm whose gripper may hold the body, and of a conveyor whose belt carries bodies.
//!
//! ```text
//! world -> F_E on the gripper -> J^T F on the joints -> (dq/dm)^T on the motors -> Simulated -> q -> X_WE -> world
//! ```

use mrroc::pose::Pose;
use mrroc::robot::{Driver, Robot};

use super::belt::Belt;
use super::compliance::Grasp;
use super::error::WorldError;
use super::grip::Hand;
use super::world::World;
use crate::models::{Conveyor, Driven, Kinematics, One};
use crate::simulation::simulated::Simulated;
use crate::simulation::surroundings::{Surrounded, Surroundings};

/// A [`Simulated`] arm in a [`World`]: it moves its gripper there, and its motors bear the forces of the body.
///
/// The kinematics of the simulated arm are the true ones. If the cell's robot has another base, that is an error of
/// calibration, and programs are off by it.
pub type Grasping<R, const N: usize> = Surrounded<R, N, Gripped>;

/// What an arm's gripper holds, if anything.
#[derive(Debug)]
#[allow(non_snake_case)]
pub struct Gripped {
    hand: Hand,
    X_FE: Pose,
}

impl<const N: usize, R: Driven<N> + Kinematics<N>> Grasping<R, N> {
    /// Its gripper.
    #[must_use]
    pub fn hand(&self) -> Hand {
        self.around().hand.clone()
    }
}

impl<const N: usize, R: Driven<N> + Kinematics<N>> Surroundings<R, N> for Gripped {
    fn begin(&mut self, arm: &mut Simulated<R, N>) {
        arm.push_tool(&self.X_FE, &self.hand.begin());
    }

    fn end(&mut self, arm: &Simulated<R, N>) {
        self.hand.end(arm.robot().forward(&arm.state().position) * self.X_FE);
    }
}

/// The drive of a conveyor in a [`World`]: the belt moves as its true joint does, and its motor bears the friction of the bodies on it.
pub type Conveying = Surrounded<Conveyor, 1, Carried>;

/// The bodies on a belt.
#[derive(Debug)]
pub struct Carried {
    world: World,
    index: usize,
}

impl Surroundings<Conveyor, 1> for Carried {
    fn begin(&mut self, drive: &mut Simulated<Conveyor, 1>) {
        let force = self.world.begin_belt(self.index);
        let robot = drive.robot();
        let at_motor = robot.motor_torques(&robot.motors(&drive.state().position), &One::new(force));
        // A drive's load counts against its motion.
        drive.push(0, -at_motor[0]);
    }

    fn end(&mut self, drive: &Simulated<Conveyor, 1>) {
        self.world.end_belt(self.index, drive.robot().forward(&drive.state().position));
    }
}

impl World {
    /// The drives of an arm whose gripper, open, holds the body as `grasp` says when it is closed.
    ///
    /// The robot of the drives is the true one. The cell's robot is the one that programs compute with: its base may stand
    /// elsewhere, as after a wrong calibration.
    ///
    /// # Errors
    /// [`WorldError`] when a figure of the grasp is out of range.
    #[allow(non_snake_case)]
    pub fn arm<const N: usize, R: Driven<N> + Kinematics<N>>(
        &self,
        drives: Simulated<R, N>,
        grasp: Grasp,
    ) -> Result<Grasping<R, N>, WorldError> {
        let X_FE = grasp.X_FE;
        let X_WE = drives.robot().forward(&drives.state().position) * X_FE;
        let hand = self.add_hand(grasp, drives.period(), X_WE)?;
        Ok(Surrounded::by(drives, Gripped { hand, X_FE }))
    }

    /// The drive of a conveyor whose belt carries bodies by friction.
    ///
    /// # Errors
    /// [`WorldError`] when a figure of the belt is out of range or its base is not level.
    pub fn belt(&self, drive: Simulated<Conveyor, 1>, belt: Belt) -> Result<Conveying, WorldError> {
        let base = drive.robot().forward(&One::zeros());
        let at = drive.robot().forward(&drive.state().position);
        let index = self.add_belt(belt, drive.period(), base, at)?;
        Ok(Surrounded::by(drive, Carried { world: self.clone(), index }))
    }
}
