//! The simulated base: what its drives do, and what the floor and walls do to it.
//!
//! In: demanded wheel angles. Out: measured ones, and, for simulated sensors and to compare with, where the base truly is.

mod chassis;
mod drives;
mod floor;
mod ground;
mod motor;

pub use chassis::{Chassis, Motion};
pub use drives::Rolling;
pub use floor::{Floor, Touched};
pub use ground::Ground;
pub use motor::Motor;
