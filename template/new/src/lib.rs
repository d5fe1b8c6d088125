//! Makes a new mrroc project out of the template, and copies generators of the library into it.
//!
//! - [`options`]: what was asked for;
//! - [`template`]: the template and the choices that it offers;
//! - [`choices`]: which of them are asked for, and what was chosen; [`source`]: the three about mrroc itself;
//! - [`urdf`]: an arm from a file of the user's;
//! - [`prompt`]: asking on the terminal;
//! - [`project`]: the project, made by cargo-generate;
//! - [`generator`]: the copy of a generator of the [`catalogue`].
#![warn(missing_docs)]

pub mod catalogue;
pub mod choices;
pub mod error;
pub mod external;
pub mod generator;
mod name;
pub mod options;
pub mod project;
pub mod prompt;
pub mod shell;
pub mod source;
mod suggestion;
pub mod template;
pub mod urdf;
