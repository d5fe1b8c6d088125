//! Why a drawing is refused: each variant is a cause, each message says where, what and what to do.

use std::fmt;

use mrroc::console::{excerpt, quoted};

/// The longest sentence of a message \[characters\], which only a quotation can make so long.
const LONGEST: usize = 300;

/// A place in a file, with the part of the line around it where that helps.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// The file, or what stands for it.
    pub file: Box<str>,
    /// Line, from 1.
    pub line: Option<u32>,
    /// Column in characters, from 1.
    pub column: Option<u32>,
    /// The line's text and a caret, ready to print.
    excerpt: Option<Box<str>>,
}

impl Place {
    /// The file as a whole.
    #[must_use]
    pub fn file(file: &str) -> Self {
        Self { file: file.into(), ..Self::default() }
    }

    /// A line of a file, whose text is not shown.
    #[must_use]
    pub fn bare_line(file: &str, line: usize) -> Self {
        Self { line: u32::try_from(line).ok(), ..Self::file(file) }
    }

    /// A line of a file.
    #[must_use]
    pub fn line(file: &str, line: usize, text: &str) -> Self {
        Self { excerpt: Some(excerpt(line, text, 0, 1).into()), ..Self::bare_line(file, line) }
    }

    /// A column of a line of a file, both from 1.
    #[must_use]
    pub fn column(file: &str, line: usize, column: usize, text: &str) -> Self {
        let excerpt = Some(excerpt(line, text, column, 1).into());
        Self { column: u32::try_from(column).ok(), excerpt, ..Self::bare_line(file, line) }
    }

    /// The line's text with a caret below the column, on lines of their own; empty without a text.
    #[must_use]
    pub fn caret(&self) -> &str {
        self.excerpt.as_deref().unwrap_or("")
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
            if let Some(column) = self.column {
                write!(f, ":{column}")?;
            }
        }
        Ok(())
    }
}

/// A drawing that will not be engraved, and why.
#[derive(Debug, thiserror::Error)]
pub enum DrawingError {
    /// The operating system would not give the file.
    #[error("{file}: cannot be read: {source}\n help: check the path and its permissions")]
    Unreadable {
        /// The path.
        file: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Longer than the limit on files.
    #[error(
        "{file}: {bytes} bytes, more than the limit of {limit}\n help: simplify the drawing or split it into several"
    )]
    FileTooLong {
        /// The path.
        file: String,
        /// Its length \[bytes\].
        bytes: u64,
        /// The limit \[bytes\].
        limit: u64,
    },
    /// A line longer than the limit.
    #[error(
        "{at}: a line of {bytes} bytes, more than the limit of {limit}\n help: this is no text file of the format that its name says; export it again"
    )]
    LineTooLong {
        /// Where.
        at: Place,
        /// Its length \[bytes\].
        bytes: usize,
        /// The limit \[bytes\].
        limit: usize,
    },
    /// Neither the name nor the content says what it is.
    #[error(
        "{file}: no format that can be engraved\n help: give .svg, .dxf, or G-code as .ngc, .nc, .gcode, .tap or .cnc"
    )]
    UnknownFormat {
        /// The path.
        file: String,
    },
    /// Bytes that are no text.
    #[error("{file}: not a text file (byte {at})\n help: {help}")]
    NotText {
        /// The path.
        file: String,
        /// The first byte that is no text.
        at: usize,
        /// What to do.
        help: &'static str,
    },
    /// The text breaks the rules of its format.
    #[error("{at}: {}{}\n help: {help}", quoted(what, LONGEST), at.caret())]
    Malformed {
        /// Where.
        at: Place,
        /// What is wrong.
        what: String,
        /// What to do.
        help: String,
    },
    /// The file ends in the middle of something.
    #[error("{at}: the file ends {inside}{}\n help: it was cut short; export or copy it again", at.caret())]
    Truncated {
        /// Where.
        at: Place,
        /// In what it ends.
        inside: String,
    },
    /// Well-formed, but nothing that can be engraved truly.
    #[error("{at}: {}{}\n help: {help}", quoted(what, LONGEST), at.caret())]
    Unsupported {
        /// Where.
        at: Place,
        /// What it is.
        what: String,
        /// What to do.
        help: String,
    },
    /// A number that no drawing holds.
    #[error("{at}: {} is {value}, not a number that a drawing can hold{}\n help: every coordinate must be finite and below 10 000 000 mm", quoted(what, LONGEST), at.caret())]
    OutOfRange {
        /// Where.
        at: Place,
        /// Which number.
        what: String,
        /// Its value.
        value: f64,
    },
    /// Start and end of an arc lie on different circles.
    #[error("{at}: arc radius mismatch: the start is {start_mm:.4} mm from the centre, the end {end_mm:.4} mm{}\n help: write I and J with more digits, or check G90.1/G91.1 (absolute or relative centres)", at.caret())]
    ArcMismatch {
        /// Where.
        at: Place,
        /// Distance of the start from the centre \[mm\].
        start_mm: f64,
        /// Distance of the end from the centre \[mm\].
        end_mm: f64,
    },
    /// A feed of zero or less: the move would never end.
    #[error("{at}: feed F{feed}: the tool would never arrive{}\n help: give a positive F word", at.caret())]
    FeedNotPositive {
        /// Where.
        at: Place,
        /// The feed as written.
        feed: f64,
    },
    /// More curve pieces than the limit.
    #[error(
        "{at}: more than {limit} curve pieces\n help: simplify the drawing (fewer nodes) or split it into several"
    )]
    TooManyPieces {
        /// Where the limit was passed.
        at: Place,
        /// The limit.
        limit: usize,
    },
    /// Nesting deeper than the limit, or without end.
    #[error("{at}: {what} nested more than {limit} deep{}\n help: flatten the nesting; an element that contains itself never ends", at.caret())]
    TooDeep {
        /// Where.
        at: Place,
        /// What is nested.
        what: &'static str,
        /// The limit.
        limit: usize,
    },
    /// More of something than any drawing program writes.
    #[error(
        "{at}: more than {limit} {what}\n help: open it in the drawing program and save it again as plain SVG"
    )]
    TooMany {
        /// Where.
        at: Place,
        /// Of what.
        what: &'static str,
        /// The limit.
        limit: usize,
    },
    /// Nothing to engrave.
    #[error("{file}: nothing to engrave: {}\n help: {help}", quoted(found, LONGEST))]
    Empty {
        /// The path.
        file: String,
        /// What was found instead.
        found: String,
        /// What to do.
        help: String,
    },
    /// A character that the font lacks.
    #[error("the text has the character {character:?} (U+{code:04X}) at place {place}, which the font {font} lacks\n help: use {coverage}, or another --font", code = u32::from(*character))]
    MissingGlyph {
        /// The character.
        character: char,
        /// Its place in the text, from 1.
        place: usize,
        /// The font's name.
        font: String,
        /// The characters that the font has.
        coverage: String,
    },
    /// No font of that name.
    #[error("no font {name:?}\n help: shipped are {shipped}; or give the path of a .jhf file")]
    UnknownFont {
        /// The name asked for.
        name: String,
        /// Names of the shipped fonts.
        shipped: String,
    },
    /// Larger than the plate leaves room for.
    #[error(
        "the drawing is {width:.1} x {height:.1} mm, the plate has room for {room_width:.1} x {room_height:.1} mm inside its margin of {margin} mm\n help: {help}"
    )]
    LargerThanPlate {
        /// Width of the drawing \[mm\].
        width: f64,
        /// Height of the drawing \[mm\].
        height: f64,
        /// Width inside the margins \[mm\].
        room_width: f64,
        /// Height inside the margins \[mm\].
        room_height: f64,
        /// Margin \[mm\].
        margin: f64,
        /// What to do.
        help: String,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_caret_points_at_the_column() {
        let at = Place::column("a.ngc", 12, 4, "G1 Q7");
        assert_eq!(at.to_string(), "a.ngc:12:4");
        assert_eq!(at.caret(), "\n 12 | G1 Q7\n    |    ^");
    }

    #[test]
    fn a_long_line_is_shown_around_its_column() {
        let text = "x".repeat(5000);
        let place = Place::column("a", 1, 4000, &text);
        let caret = place.caret();
        assert!(caret.lines().all(|line| line.len() < 90), "{caret}");
        let last = caret.lines().last().unwrap();
        assert!(last.ends_with('^'));
    }
}
