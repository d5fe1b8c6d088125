//! The motion of the task, as a step function.

mod step;

pub use step::{Legs, Stride};
