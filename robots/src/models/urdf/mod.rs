//! Robots described by a URDF file.
//!
//! ```text
//! text -> document (XML, strictly) -> chain (base to tip) -> Serial<N>: Robot
//!                                                              |-- closed form, for three families of arms
//!                                                              |-- Newton iteration, for all others
//!                                                              |-- assumed motors, for simulation
//!                                                              |-- links, for dynamics; and back to a URDF (export)
//!                                                              '-- capsules of <collision> (SerialOutline); pairs of an SRDF
//! ```
//!
//! [`Serial`] says what is read of a URDF and what is not.

mod body;
mod branches;
mod chain;
mod closed;
mod collision;
mod description;
mod document;
mod drives;
mod error;
pub(crate) mod export;
mod links;
mod meshes;
mod motion;
mod newton;
mod outline;
mod places;
mod recognition;
mod rounded;
mod serial;
mod srdf;

pub use collision::{Meshes, Openings};
pub use description::UrdfText;
pub use error::UrdfError;
pub use outline::SerialOutline;
pub use serial::{Serial, SerialBuilder};
pub use srdf::DisabledPair;
