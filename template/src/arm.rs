//! The kind of robot, and what drives it: simulated down to its motors.
//! FILL IN: a function `kinds` of your own, which returns `simulated().with("irp6", ..)`, to drive a real one.

pub use mrroc_robots::{Irp6 as Arm, simulated as kinds};
