//! Sensors for `mrroc`: what they give, as physics says, and what a program makes of it.
//!
//! | module | in | out |
//! |---|---|---|
//! | [`scene`] | – | what sensors see of a world: convex solids that move |
//! | [`form`], [`view`], [`camera`] | – | what a camera sees: forms over a belt; how its pixels lie on that |
//! | [`ultrasound`] | – | what surfaces send back to a transducer, and what its detector makes of that |
//! | [`physics`] | a scene, a view | what a sensor gives: a switched output, a code, an image |
//! | [`aggregation`] | what a sensor gives, over time | the reading `f_v` makes of it: edges, passages, distances, parts |
//! | [`virtual_sensors`] | both | the virtual sensors of a cell, in any of the three modes of a VSP |
//! | `simulated` | a simulated world | its parts on a belt, as sensors see them (feature `simulation`) |
//!
//! Physics and aggregation know neither each other (but for its random numbers) nor a cell: a real input card feeds the same aggregation, and a test of one's own
//! reads the same physics.
//!
//! ```
//! use mrroc_sensors::aggregation::{Edge, Passages};
//!
//! // A part of 80 mm passes two light barriers 150 mm apart at 0.1 m/s: four edges.
//! let mut passages = Passages::new(0.15);
//! let edge = |time, covered| Edge { time, covered };
//! for (beam, edge) in [(0, edge(1.0, true)), (0, edge(1.8, false)), (1, edge(2.5, true)), (1, edge(3.3, false))] {
//!     passages.take(beam, edge);
//! }
//! let passage = passages.last().expect("one has passed");
//! assert_eq!(passages.count(), 1);
//! assert!((passage.speed - 0.1).abs() < 1e-12 && (passage.length - 0.08).abs() < 1e-12);
//! assert_eq!(passage.left, 3.3);
//! ```

pub mod aggregation;
pub mod camera;
pub mod form;
pub mod physics;
pub mod scene;
#[cfg(feature = "simulation")]
pub mod simulated;
pub mod ultrasound;
pub mod view;
pub mod virtual_sensors;

// The files in `tests/` use this crate by its name, as its users do.
#[cfg(test)]
extern crate self as mrroc_sensors;
#[cfg(test)]
#[path = "../tests/main.rs"]
mod usage;
