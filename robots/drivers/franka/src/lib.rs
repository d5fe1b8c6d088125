//! Franka Research 3 arms for mrroc, by the Franka Control Interface (FCI): the robot sends a state every millisecond, and takes
//! joint positions in the answer.
//!
//! **Never run on a real robot.** It was run against franka-sim, which enforces the robot's limits and its 20 lost answers, and
//! franky-sim (`tests/peers/drives`), as both are moved by Franka's own client.
//!
//! The robot's own behaviour decides most of this crate. What it is told must go on from what its regulators follow, within its
//! speed, acceleration and jerk, or it stops by a reflex; an answer that does not come within the millisecond is replaced by one
//! of constant acceleration, and after 20 in a row the robot stops. So positions are told by a law that starts where
//! the robot is and ends on the demanded path (`rejoining.rs`), and what the robot would not take is refused before.
//!
//! What the robot does by itself, its reflexes, its user stop and hand guiding, is told as a
//! [`RobotStop`](mrroc::robot::RobotStop) with Franka's names. Torques are not told as currents: the robot measures them behind its
//! gears. From them it estimates the wrench at its tool, which a sensor reads
//! ([`RobotWrench`](mrroc_robots::sensors::RobotWrench)).
//!
//! The gripper that Franka sells for the arm is a robot of its own: [`hand`].
//!
//! ```no_run
//! use mrroc_franka::with_franka;
//!
//! // kind = "fr3" in cell.toml, with the robot's address.
//! let kinds = with_franka(mrroc_robots::simulated());
//! ```
//!
//! ```
//! use mrroc::robot::Robot;
//! use mrroc_franka::Fr3;
//! use nalgebra::SVector;
//!
//! let arm = Fr3::new();
//! let ready = SVector::from([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]);
//! let flange = arm.forward(&ready);
//! // The same pose with joint 7 turned by 0.1 rad: the elbow swings.
//! let other = arm.inverse_at(&flange, 0.885, &ready)?;
//! assert!((arm.forward(&other).translation.vector - flange.translation.vector).norm() < 1e-9);
//! assert!((other[2] - ready[2]).abs() > 0.01);
//! # Ok::<(), mrroc::robot::NoInverse>(())
//! ```

mod arm;
mod behaviour;
mod drives;
pub mod hand;
mod inverse;
mod limits;
mod link;
mod load;
mod message;
mod network;
mod opening;
mod rejoining;
mod requests;
mod settings;
mod stops;
mod wrench;

use std::net::IpAddr;

use mrroc::cell::RobotSetup;
use mrroc_launch::cell_file::{AnySetup, Kinds};
use mrroc_robots::Simulated;

pub use arm::Fr3;
pub use behaviour::SETS;
pub use drives::Fci;
pub use hand::with_franka_hand;
pub use limits::velocities;
pub use link::Answers;
pub use message::{Answer, Collision, JOINTS, Mode, State, Stiffness};
pub use mrroc_driver_kit::Arrived;
pub use network::{Network, Sockets};
pub use settings::FciSettings;
pub use wrench::External;

/// Adds the kind `fr3`: a Franka Research 3 at its `base`, moved through the control interface of the robot at `address`.
/// Simulated drives, from `start` on, stand in where nothing real may move.
#[must_use]
pub fn with_franka(kinds: Kinds) -> Kinds {
    with_franka_as(kinds, FciSettings::new)
}

/// The same with other settings for the robot at an address.
#[must_use]
pub fn with_franka_as(kinds: Kinds, settings: fn(IpAddr) -> FciSettings) -> Kinds {
    kinds.with_any("fr3", move |entry| {
        let arm = Fr3::new().with_base(entry.base());
        let start = entry.start(&arm)?;
        let drives = Fci::new(settings(entry.address()?));
        let setup = RobotSetup::new(entry.name(), arm.clone(), drives);
        Ok(AnySetup::from(setup.stand_in(Simulated::new(arm, &start))))
    })
}
