//! The operator: what a person may ask of a running cell, and what he is shown of it.
//!
//! [`Operator`] is the handle in the program, [`request`] what a console asks for and is answered, [`button`] what an MP is asked
//! for, [`state`] what it shows, [`console`] how it meets either. At reduced speed robots move only while a [`hold`] lasts; [`jog`] is a hold that moves one robot.

pub mod button;
pub mod cell_state;
pub mod console;
mod handle;
pub mod hold;
pub mod jog;
mod no_request;
pub mod request;
pub mod state;

pub use cell_state::CellState;
pub use handle::{BadSpeed, Operator};
pub use hold::{LAPSE, Renewal};
pub use no_request::NoRequest;
pub use request::{Answer, OnBehalf, Request};

pub use crate::safety::latch::{Latch, LatchRefusal};
pub use crate::safety::limits::REDUCED_SPEED;
