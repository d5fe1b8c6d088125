//! The lower cells of a cell file: each is a file of its own.

use std::path::{Path, PathBuf};

use mrroc_core::cell::CellError;

use super::CellFile;

/// A lower cell as the file of the cell above it names it.
#[derive(Clone, Debug)]
pub(super) struct LowerEntry {
    pub name: String,
    /// Its own file, in the folder of the file that names it.
    pub file: PathBuf,
}

impl CellFile {
    /// Reads the file of the lower cell `name`, which the program makes a cell of and adds by
    /// [`Cell::cell`](mrroc_core::cell::Cell::cell): `[cells.press]` with `file = "press.toml"`. Its table `[realtime]` has no
    /// effect: that of this file is for all processes.
    ///
    /// # Errors
    /// The file names no such cell; or everything that is wrong with the file of the cell.
    pub fn lower(&self, name: &str) -> Result<CellFile, CellError> {
        let there = || self.cells.iter().map(|lower| &*lower.name);
        let found = self.cells.iter().find(|lower| lower.name == name);
        let lower = found.ok_or_else(|| self.source.missing("cells", name, there()))?;
        let folder = Path::new(&self.source.file).parent().unwrap_or(Path::new(""));
        Ok(CellFile::read(folder.join(&lower.file))?)
    }
}
