//! The same belt and the same programs with an ultrasonic matrix over it, in place of the camera.
//!
//! [`layout`] says where it is, [`studio`] makes reliefs to learn from, [`run`](mod@run) puts it into the cell, [`picture`] draws what it heard, and
//! [`command`] is what the command line asks for.

pub mod command;
pub mod layout;
pub mod picture;
pub mod run;
pub mod studio;
