//! What is wrong with a cell file: where, what, and what to write.

use core::fmt;
use core::ops::Range;
use mrroc_core::cell::CellError;
use mrroc_core::console::{excerpt, quoted};
use mrroc_core::suggestion::nearest;
use std::io::ErrorKind;

/// The longest sentence of a message \[characters\], which only a quotation can make so long.
const LONGEST: usize = 400;

/// Everything that is wrong with a cell file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", .complaints.iter().map(ToString::to_string).collect::<Vec<_>>().join("\nerror: "))]
pub struct CellFileError {
    complaints: Vec<Complaint>,
}

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Complaint {
    /// The place in the text \[bytes\], by which errors are sorted.
    offset: usize,
    /// The file, and the line and column if they are known.
    at: String,
    what: String,
    /// The line with a caret below it; empty if the line is not known.
    excerpt: String,
    help: String,
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Both quote what stands in the file.
        let [what, help] = [&self.what, &self.help].map(|text| quoted(text, LONGEST));
        write!(f, "{}: {what}{}\n help: {help}", self.at, self.excerpt)
    }
}

impl CellFileError {
    pub(super) fn unreadable(name: &str, error: &std::io::Error) -> Self {
        let help = match error.kind() {
            ErrorKind::NotFound => {
                "a task project has its cell.toml beside its Cargo.toml: run it there, or give the file by --cell"
            }
            ErrorKind::InvalidData => "save it as plain text in UTF-8",
            _ => "see whether it is a file, and who may read it",
        };
        let what = format!("cannot be read: {error}");
        let (at, help) = (name.to_owned(), help.to_owned());
        CellFileError { complaints: vec![Complaint { offset: 0, at, what, excerpt: String::new(), help }] }
    }

    pub(super) fn too_long(name: &str, most: u64) -> Self {
        let what = format!("it has more than {most} bytes");
        let (at, help) = (name.to_owned(), "give a cell.toml; this is another file".to_owned());
        CellFileError { complaints: vec![Complaint { offset: 0, at, what, excerpt: String::new(), help }] }
    }

    /// Places and causes, in one line: for a sentence in the error of another file.
    pub(super) fn causes(&self) -> String {
        let causes: Vec<_> =
            self.complaints.iter().map(|complaint| format!("{}: {}", complaint.at, complaint.what)).collect();
        causes.join("; ")
    }

    /// Joins all errors to one, in the order of the file; `Ok` if there are none.
    pub(super) fn all(errors: Vec<CellFileError>) -> Result<(), CellFileError> {
        let mut complaints: Vec<_> = errors.into_iter().flat_map(|error| error.complaints).collect();
        complaints.sort_by_key(|complaint| complaint.offset);
        if complaints.is_empty() { Ok(()) } else { Err(CellFileError { complaints }) }
    }
}

/// A value and where it stands in the text.
#[derive(Clone, Debug)]
pub(super) struct At<T> {
    pub value: T,
    pub span: Range<usize>,
}

/// The file's name and text, kept for messages about errors that are found later.
#[derive(Debug)]
pub(super) struct Source {
    pub file: String,
    pub text: String,
}

impl Source {
    /// An error at a place in the text \[bytes\].
    pub fn complain(&self, at: &Range<usize>, what: String, help: String) -> CellFileError {
        let start = self.text.floor_char_boundary(at.start);
        let before = &self.text[..start];
        let line = before.matches('\n').count() + 1;
        let begin = before.rfind('\n').map_or(0, |newline| newline + 1);
        let column = self.text[begin..start].chars().count() + 1;
        let whole = self.text[begin..].lines().next().unwrap_or("");
        let width = self.text.get(at.clone()).map_or(1, |text| text.chars().count());
        let excerpt = excerpt(line, whole, column, width);
        let at = format!("{}:{line}:{column}", self.file);
        CellFileError { complaints: vec![Complaint { offset: start, at, what, excerpt, help }] }
    }

    /// The error that the file has no entry of this name in a table.
    pub fn missing<'a>(
        &self,
        table: &str,
        name: &str,
        there: impl IntoIterator<Item = &'a str>,
    ) -> CellFileError {
        let there: Vec<_> = there.into_iter().collect();
        let help = match (nearest(name, &there), there.as_slice()) {
            (Some(meant), _) => format!("did you mean `{meant}`?"),
            (None, []) => format!("write a table [{table}.{name}]"),
            (None, there) => {
                format!("write a table [{table}.{name}], or use one of those there: {}", there.join(", "))
            }
        };
        let what = format!("the program asks for [{table}.{name}], which is not there");
        let at = self.file.clone();
        CellFileError { complaints: vec![Complaint { offset: 0, at, what, excerpt: String::new(), help }] }
    }
}

impl From<CellFileError> for CellError {
    fn from(error: CellFileError) -> CellError {
        CellError::File(error.to_string())
    }
}
