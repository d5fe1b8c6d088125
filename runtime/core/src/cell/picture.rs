//! A picture of a run, as a cell and its command line meet one. What draws it is a crate of its own.

use std::io;
use std::path::Path;

use super::Cell;

/// A picture of a run: watches its robots, and is saved when it is over.
pub trait RunPicture {
    /// Begins to watch every robot of the cell.
    fn watch(&mut self, cell: Cell) -> Cell;

    /// Writes what was seen to a file; after a fault, too.
    ///
    /// # Errors
    /// The file cannot be written.
    fn save(&mut self, file: &Path) -> io::Result<()>;
}
