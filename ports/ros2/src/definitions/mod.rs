//! Definitions of messages, in the `.msg` language of ROS 2.

mod common;
mod message;
mod whole;

pub use message::{Count, Definitions, Field, Item, MessageType, Number, Wrong};
pub use whole::with_named;
