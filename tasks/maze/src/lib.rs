//! A robot finds its way out of a maze by touch.

pub mod ecp;
pub mod found;
pub mod generators;
pub mod mp;
pub mod orders;
pub mod places;
pub mod plant;
pub mod run;

use mrroc::cell_file::CellFileError;
use mrroc::prelude::*;

/// The cell of the task, `cell.toml`.
///
/// # Errors
/// None: the file is right.
pub fn file() -> Result<CellFile, CellFileError> {
    CellFile::parse("cell.toml", include_str!("../cell.toml"))
}
