//! What a run shows to those who watch it: recordings, pictures, panels, dry runs.
//!
//! In: steps, images, orders, readings and faults, from the process that has them. Out: the same to [`step_observer`]s; nothing that
//! a process acts on.

pub mod activity;
pub mod layout;
pub mod recording;
pub mod ring;
pub mod sample;
pub mod servo;
pub mod shown;
pub mod solid;
mod step_event;
pub mod step_observer;
pub mod subscription;

pub use activity::Activity;
pub use recording::{NotRecorded, Recording};
pub use servo::{Observation, ServoRecord};
pub use shown::Shown;
pub use subscription::Subscription;
