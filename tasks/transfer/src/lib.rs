//! Two arms carry a rigid body together: the example of the MRROC++ paper, section 8.
//!
//! The task itself is small: [`mp`] coordinates, [`ecp`] is what each robot does, [`generators`] how they move, [`orders`]
//! what the coordinator tells the robots. [`first`] is the same task as it was begun, with generators of the library alone;
//! [`sensed`] is the same with force sensors, [`clear`] keeps the arms apart. The rest surrounds it: [`places`] says where things are, [`plant`] what
//! simulated robots do, [`monitor`] measures, [`touching`] is how
//! the arms' bases are calibrated.

pub mod clear;
pub mod ecp;
pub mod first;
pub mod generators;
pub mod lines;
pub mod monitor;
pub mod mp;
pub mod options;
pub mod orders;
pub mod paths;
pub mod pictures;
pub mod places;
pub mod plant;
pub mod sensed;
pub mod slow_fingers;
pub mod summary;
pub mod touching;
pub mod variant;

use mrroc::cell_file::{CellFileError, Kinds};
use mrroc::prelude::*;

/// The cell of the task, `cell.toml`.
///
/// # Errors
/// None: the file is right.
pub fn file() -> Result<CellFile, CellFileError> {
    CellFile::parse("cell.toml", include_str!("../cell.toml"))
}

/// Puts the cell of a file together: its robots, of these kinds, their programs, and the guard that keeps them clear.
///
/// # Errors
/// What is wrong with the file.
pub fn cell(file: &CellFile, kinds: &Kinds) -> Result<Cell, CellError> {
    let clear = clear::guard(file, clear::MARGINS)?;
    Ok(file.cell(kinds).map(ecp::programs)?.guard(clear::EVERY, clear))
}
