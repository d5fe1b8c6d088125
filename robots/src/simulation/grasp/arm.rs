//! The drives of an arm whose gripper may hold the world's body.
//!
//! ```text
//! world -> F_E on the gripper -> J^T F on the joints -> (dq/dm)^T on the motors -> Simulated -> q -> X_WE -> world
//! ```

use mrroc::pose::Pose;
use mrroc::robot::Driver;

use super::compliance::Grasp;
use super::error::WorldError;
use super::grip::Hand;
use super::world::World;
use crate::models::{Driven, Kinematics};
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
    #[allow(non_snake_case)]
    pub(super) fn new(world: &World, arm: Simulated<R, N>, grasp: Grasp) -> Result<Self, WorldError> {
        let X_FE = grasp.X_FE;
        let X_WE = arm.robot().forward(&arm.state().position) * X_FE;
        let hand = world.add_hand(grasp, arm.period(), X_WE)?;
        Ok(Surrounded::by(arm, Gripped { hand, X_FE }))
    }

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
