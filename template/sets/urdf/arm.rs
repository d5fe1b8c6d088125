//! The kind of robot: an arm that the `file` in cell.toml describes, simulated with motors that are just large enough for it.
//! FILL IN: a function `kinds` of your own, which returns `simulated().with("urdf", ..)`, to drive a real one.

use mrroc_robots::Serial;

/// It has as many joints as move between its base and the `tip` in cell.toml.
pub type Arm = Serial<6>;

pub use mrroc_robots::simulated as kinds;
