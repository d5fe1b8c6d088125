//! Parts on a moving belt are sensed, acquired and sorted: the reactive task of the MRROC++ paper, with infrared sensors.
//!
//! The task itself is small: [`mp`] coordinates, [`ecp`] is what each robot does, [`generators`] how they move, [`orders`] what the
//! coordinator tells them. The rest surrounds it: [`places`] says where things are, [`reach`] where the arm can go, [`parts`] what comes and when, [`plant`] what
//! simulated robots and sensors do, [`monitor`] measures, [`run`] is one run, [`summary`] many.

pub mod camera;
pub mod ecp;
pub mod generators;
pub mod left;
pub mod matrix;
pub mod monitor;
pub mod mp;
pub mod options;
pub mod orders;
pub mod parts;
pub mod pictures;
pub mod places;
pub mod plant;
pub mod progress;
pub mod reach;
pub mod run;
pub mod scene;
pub mod scopes;
pub mod summary;

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
extern crate self as sorting;
#[cfg(test)]
#[path = "../tests/main.rs"]
mod usage;
