//! The drives of an arm whose gripper may hold the world's body.
//!
//! ```text
//! world -> F_E on the gripper -> J^T F on the joints -> (dq/dm)^T on the motors -> Simulated -> q -> X_WE -> world
//! ```

use core::time::Duration;

use mrroc::pose::{Pose, Wrench};
use mrroc::robot::{DriveFault, Driver, Measured, Regulators, SimulatedDrives};
use nalgebra::{SVector, Vector6};

use super::compliance::Grasp;
use super::error::WorldError;
use super::grip::Hand;
use super::world::World;
use crate::models::{Driven, Kinematics};
use crate::simulation::simulated::{Shaft, Simulated};

/// A [`Simulated`] arm in a [`World`]: it moves its gripper there, and its motors bear the forces of the body.
///
/// The kinematics of the simulated arm are the true ones. If the cell's robot has another base, that is an error of
/// calibration, and programs are off by it.
#[derive(Debug)]
#[allow(non_snake_case)]
pub struct Grasping<R, const N: usize> {
    arm: Simulated<R, N>,
    shaft: Shaft<N>,
    hand: Hand,
    X_FE: Pose,
}

impl<const N: usize, R: Driven<N> + Kinematics<N>> Grasping<R, N> {
    #[allow(non_snake_case)]
    pub(super) fn new(world: &World, arm: Simulated<R, N>, grasp: Grasp) -> Result<Self, WorldError> {
        let shaft = arm.shaft();
        let X_FE = grasp.X_FE;
        let X_WE = arm.robot().forward(&shaft.state().position) * X_FE;
        let hand = world.add_hand(grasp, arm.period(), X_WE)?;
        Ok(Self { arm, shaft, hand, X_FE })
    }

    /// Loads the motors with the wrench of the body on the gripper: at E, along the world's axes.
    #[allow(non_snake_case)]
    fn load(&mut self, F_E: &Wrench) {
        if *F_E == Wrench::default() {
            (0..N).for_each(|i| self.arm.push(i, 0.0));
            return;
        }
        let q = self.shaft.state().position;
        let robot = self.arm.robot();
        // From the tool's origin to the flange's, where the Jacobian is taken.
        let lever = robot.forward(&q).rotation * self.X_FE.translation.vector;
        let f = F_E.force;
        let t = F_E.torque + lever.cross(&F_E.force);
        let torques = robot.jacobian(&q).tr_mul(&Vector6::new(f.x, f.y, f.z, t.x, t.y, t.z));
        let at_motors = robot.motor_torques(&robot.motors(&q), &torques);
        // A drive's load counts against its motion.
        (0..N).for_each(|i| self.arm.push(i, -at_motors[i]));
    }

    /// One servo period of the drives, in the world.
    fn in_world<T>(&mut self, period: impl FnOnce(&mut Simulated<R, N>) -> T) -> T {
        let reaction = self.hand.begin();
        self.load(&reaction);
        let outcome = period(&mut self.arm);
        self.hand.end(self.arm.robot().forward(&self.shaft.state().position) * self.X_FE);
        outcome
    }

    /// Its gripper.
    #[must_use]
    pub fn hand(&self) -> Hand {
        self.hand.clone()
    }

    /// The drives.
    #[must_use]
    pub fn drives(&self) -> &Simulated<R, N> {
        &self.arm
    }

    /// The drives, to jam one or to reset a trip.
    #[must_use]
    pub fn drives_mut(&mut self) -> &mut Simulated<R, N> {
        &mut self.arm
    }
}

impl<const N: usize, R: Driven<N> + Kinematics<N>> Driver<R> for Grasping<R, N> {
    fn period(&self) -> Duration {
        self.arm.period()
    }

    fn measured(&self) -> Result<Measured<SVector<f64, N>>, DriveFault> {
        self.arm.measured()
    }

    fn tick(&mut self, demanded: &SVector<f64, N>) -> Result<Measured<SVector<f64, N>>, DriveFault> {
        self.in_world(|arm| arm.tick(demanded))
    }

    fn motor_currents(&self) -> Option<SVector<f64, N>> {
        self.arm.motor_currents()
    }

    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<R>> {
        Some(self)
    }

    fn has_brakes(&self) -> bool {
        self.arm.has_brakes()
    }

    fn switch_off(&mut self) {
        self.arm.switch_off();
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.arm.switch_on()
    }

    fn has_regulator(&self, joint: usize, set: u8) -> bool {
        self.arm.has_regulator(joint, set)
    }

    fn choose_regulators(&mut self, sets: &Regulators) {
        self.arm.choose_regulators(sets);
    }
}

impl<const N: usize, R: Driven<N> + Kinematics<N>> SimulatedDrives<R> for Grasping<R, N> {
    fn brake(&mut self) -> Measured<SVector<f64, N>> {
        self.in_world(Simulated::brake)
    }
}
