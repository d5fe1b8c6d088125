//! The kind of robot, and what drives it.

pub use mrroc_robots::Irp6 as Arm;

/// FILL IN: `.with("irp6", ..)` to drive a real arm where `cell.toml` says "irp6"; simulated down to its motors until then.
pub fn kinds() -> mrroc::Kinds {
    mrroc_robots::simulated()
}
