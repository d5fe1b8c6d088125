//! The IRp-6 family: the arm with six joints, the older one with five, and the one on a track.
//!
//! | file | concept |
//! |---|---|
//! | `arm.rs` | [`Irp6`]: frames, joints, limits and drives, which the variants share |
//! | `five.rs`, `track.rs` | [`Irp6FiveDof`], [`Irp6Track`] |
//! | `links.rs`, `wrist.rs` | kinematics of the planar arm on the column, and of the wrist |
//! | `transmission.rs` | [`Transmission`]: motor angles from joint angles and back |
//! | `masses.rs` | the links' masses, for dynamics |
//! | `outline.rs` | the shape of all three |

mod arm;
mod five;
mod links;
mod masses;
mod outline;
mod track;
mod transmission;
mod wrist;

pub use arm::Irp6;
pub use five::Irp6FiveDof;
pub use track::Irp6Track;
pub use transmission::{Linear, LinkState, Screw, Transmission};
