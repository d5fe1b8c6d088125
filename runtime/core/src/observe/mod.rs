//! What a run shows to those who watch it: recordings, pictures, panels, dry runs.
//!
//! In: steps, images, orders, readings and faults, from the process that has them. Out: the same to [`witness`]es; nothing that
//! a process acts on.

pub mod activity;
pub mod layout;
pub mod onlooking;
pub mod recording;
pub mod ring;
pub mod servo;
pub mod shown;
pub mod witness;

pub use activity::Activity;
pub use onlooking::Onlooking;
pub use recording::{NotRecorded, Recording};
pub use servo::{Observation, ServoRecord};
pub use shown::Shown;
