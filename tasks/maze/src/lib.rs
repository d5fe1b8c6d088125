//! A robot finds its way out of a maze by touch: the reactive task of the MRROC++ paper, whose world model grows by collisions.
//!
//! The task itself is small: [`mp`] plans by a map that grows, [`ecp`] is what the arm does, [`generators`] how it moves, [`orders`] what
//! it is told, [`found`] where the maze stands, [`feeling`] what is asked of a sensor. The rest surrounds it: [`places`] says where things are, [`plant`] what the simulated
//! arm and probe do, [`run`] is one run of one of the [`mazes`], [`summary`] many.

pub mod camera;
pub mod ecp;
pub mod feeling;
pub mod force;
pub mod found;
pub mod generators;
pub mod mazes;
pub mod mp;
pub mod options;
pub mod orders;
pub mod pictures;
pub mod places;
pub mod plant;
pub mod reactive;
pub mod run;
pub mod summary;
pub mod wheels;

use mrroc::cell_file::CellFileError;
use mrroc::prelude::*;

/// The cell of the task, `cell.toml`.
///
/// # Errors
/// None: the file is right.
pub fn file() -> Result<CellFile, CellFileError> {
    CellFile::parse("cell.toml", include_str!("../cell.toml"))
}

// The files in `tests/` use this crate by its name, as its users do.
#[cfg(test)]
extern crate self as maze;
#[cfg(test)]
#[path = "../tests/main.rs"]
mod usage;
