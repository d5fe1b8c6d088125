//! Entries `[cells.NAME]`.

use super::super::lower::LowerEntry;
use super::{Entry, Reader};

pub(in super::super) const LOWER_KEYS: [&str; 1] = ["file"];

impl Reader {
    /// Reads a lower cell: where its own file is.
    pub(super) fn lower(
        &mut self,
        Entry { name, table }: Entry<'_>,
        robots: &[String],
    ) -> Option<LowerEntry> {
        self.known(table, &LOWER_KEYS, "a lower cell has");
        if robots.contains(&name.value) {
            let what = format!("`{}` is a robot already", name.value);
            self.complain(
                &name.span,
                what,
                "for the MP a cell is a robot: give it a name of its own".to_owned(),
            );
        }
        let Some(file) = table.get("file") else {
            let what = format!("cell `{}` has no `file`", name.value);
            self.complain(
                &name.span,
                what,
                format!("write file = \"{}.toml\", the file of that cell", name.value),
            );
            return None;
        };
        let file = self.text(file, "the file of the cell, in quotes")?;
        Some(LowerEntry { name: name.value, file: file.into() })
    }
}
