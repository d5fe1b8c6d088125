//! Four legs carry a trunk over steps: a claim of the MRROC++ paper, that legs may stand where arms stood in the same software.
//!
//! Four legs of three joints are four robots of one coordinator, and the trunk is what they carry. The task itself is small: [`mp`]
//! walks, [`generators`] has its motion, [`walk`] is how to walk: gait, footsteps, support. The rest surrounds it: [`leg`] is the robot,
//! [`places`] says where things are, [`ground`] is what it walks on, [`plant`] what the simulated machine does, [`run`] is one run and
//! [`seen`] what there was to see of it.

pub mod generators;
pub mod ground;
pub mod leg;
pub mod mp;
pub mod options;
pub mod pictures;
pub mod places;
pub mod plant;
pub mod run;
pub mod seen;
pub mod summary;
pub mod walk;

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
extern crate self as legs;
#[cfg(test)]
#[path = "../tests/main.rs"]
mod usage;
