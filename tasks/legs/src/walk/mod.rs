//! How to walk, without a robot and a runtime: the gait, the support polygon, a footstep and whether it may be made.

mod foothold_plan;
mod footstep;
mod gait;
pub mod support;
mod swing;

pub use foothold_plan::{FootholdPlan, regular};
pub use footstep::{Footstep, LEAST, Refused, Stance};
pub use gait::{Gait, Part, soft};
pub use swing::Swing;
