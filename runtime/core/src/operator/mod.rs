//! The operator: what a person may ask of a running cell, and what he is shown of it.
//!
//! [`Operator`] is the handle in the program, [`button`] what a console sends, [`state`] what an MP shows, [`console`] how
//! an MP meets either. At reduced speed robots move only while a [`hold`] lasts; [`jog`] is a hold that moves one robot.

pub mod button;
pub mod console;
mod handle;
pub mod hold;
pub mod jog;
mod no_button;
pub mod state;

pub use handle::{BadSpeed, Operator};
pub use hold::{LAPSE, Renewal};

pub use crate::safety::latch::{Latch, LatchRefusal};
pub use crate::safety::limits::REDUCED_SPEED;
