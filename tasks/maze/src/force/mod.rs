//! A force sensor at the wrist instead of the probe's switch: it feels in which direction a wall lies, and so the ball can slide along it.
//!
//! ```text
//! forces of walls -> wrist (noise, bias) -> force, the ball's middle, stretches of walls (VSP) -> leg, slide (ECP) -> map, next leg (MP)
//! ```
//!
//! [`sensor`] is the virtual sensor, [`ecp`] what the arm does, [`slide`] how it slides. The coordinator, the map and the planner are those
//! of the probe.

pub mod ecp;
pub mod sensor;
pub mod slide;
