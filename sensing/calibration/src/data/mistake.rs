//! What is wrong with a file that a user wrote: where, what, and what to write.

use core::fmt;
use core::ops::Range;
use std::cell::RefCell;
use std::path::Path;

use mrroc::console::{excerpt, quoted};

use crate::text_file;

/// The longest sentence of a message \[characters\], which only a quotation can make so long.
const LONGEST: usize = 400;

/// The most mistakes that are told.
const TOLD: usize = 20;

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Mistake {
    offset: usize,
    at: String,
    what: String,
    excerpt: String,
    help: String,
}

/// Everything that is wrong with a file: a line for each mistake with file, line and column, the line itself, and what to write.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct Mistakes(Vec<Mistake>);

impl fmt::Display for Mistakes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, mistake) in self.0.iter().take(TOLD).enumerate() {
            let begin = if i == 0 { "" } else { "\nerror: " };
            let [what, help] = [&mistake.what, &mistake.help].map(|text| quoted(text, LONGEST));
            write!(f, "{begin}{}: {what}{}\n help: {help}", mistake.at, mistake.excerpt)?;
        }
        match self.0.len().saturating_sub(TOLD) {
            0 => Ok(()),
            more => write!(f, "\nand {more} further mistakes"),
        }
    }
}

/// A file's text, and the mistakes found in it so far.
#[derive(Debug)]
pub(super) struct Source {
    pub(super) file: String,
    pub(super) text: String,
    mistakes: RefCell<Vec<Mistake>>,
}

impl Source {
    pub(super) fn new(file: &str, text: &str) -> Self {
        Self { file: file.to_owned(), text: text.to_owned(), mistakes: RefCell::default() }
    }

    /// Reads a file.
    pub(super) fn read(path: &Path) -> Result<Self, Mistakes> {
        let file = path.display().to_string();
        let refused = |[what, help]: [String; 2]| {
            Mistakes(vec![Mistake { offset: 0, at: file.clone(), what, excerpt: String::new(), help }])
        };
        let text = text_file::read(path).map_err(refused)?;
        Ok(Self::new(&file, &text))
    }

    /// Notes a mistake at a place in the text \[bytes\].
    pub(super) fn complain(&self, at: &Range<usize>, what: impl Into<String>, help: impl Into<String>) {
        let start = self.text.floor_char_boundary(at.start.min(self.text.len()));
        let before = &self.text[..start];
        let line = before.matches('\n').count() + 1;
        let begin = before.rfind('\n').map_or(0, |newline| newline + 1);
        let column = self.text[begin..start].chars().count() + 1;
        let whole = self.text[begin..].lines().next().unwrap_or("");
        let width =
            self.text.get(at.clone()).map_or(1, |text| text.lines().next().unwrap_or("").chars().count());
        self.mistakes.borrow_mut().push(Mistake {
            offset: start,
            at: format!("{}:{line}:{column}", self.file),
            what: what.into(),
            excerpt: excerpt(line, whole, column, width),
            help: help.into(),
        });
    }

    /// Whether nothing was wrong so far.
    pub(super) fn is_good(&self) -> bool {
        self.mistakes.borrow().is_empty()
    }

    /// What was read, if nothing was wrong.
    pub(super) fn finish<T>(&self, read: Option<T>) -> Result<T, Mistakes> {
        self.done()?;
        // Whoever reads nothing says why.
        read.ok_or_else(|| {
            self.complain(&(0..0), "nothing in it could be read", "see the book, Calibration");
            Mistakes(self.mistakes.borrow().clone())
        })
    }

    /// All mistakes, in the order of the text.
    pub(super) fn done(&self) -> Result<(), Mistakes> {
        let mut mistakes = self.mistakes.borrow().clone();
        mistakes.sort_by_key(|mistake| mistake.offset);
        mistakes.dedup();
        if mistakes.is_empty() { Ok(()) } else { Err(Mistakes(mistakes)) }
    }
}
