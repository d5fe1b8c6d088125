//! Tags: a line with a group code, a line with a value.

use crate::error::{DrawingError, Place};

/// A group code and its value: without blanks around it, but for the texts of groups 1 and 3, whose blanks are letters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tag<'a> {
    pub code: i32,
    pub value: &'a str,
    /// Line of the value, from 1.
    pub line: usize,
}

/// The tags of a file, one after the other.
pub struct Tags<'a> {
    file: &'a str,
    lines: std::str::Lines<'a>,
    line: usize,
    back: Option<Tag<'a>>,
}

impl<'a> Tags<'a> {
    /// At the start of a file.
    pub fn new(file: &'a str, text: &'a str) -> Self {
        Self { file, lines: text.lines(), line: 0, back: None }
    }

    /// The file's name.
    pub fn file(&self) -> &'a str {
        self.file
    }

    /// The next tag that is no comment; `None` at the end of the file.
    pub fn next(&mut self) -> Result<Option<Tag<'a>>, DrawingError> {
        if let Some(tag) = self.back.take() {
            return Ok(Some(tag));
        }
        loop {
            let Some(code_line) = self.lines.next() else { return Ok(None) };
            self.line += 1;
            let code = code_line.trim();
            let Ok(code) = code.parse::<i32>() else {
                if code.is_empty() && self.lines.clone().all(|l| l.trim().is_empty()) {
                    return Ok(None);
                }
                return Err(DrawingError::Malformed {
                    at: Place::column(self.file, self.line, 1, code_line),
                    what: "no group code where one should be".to_owned(),
                    help: "the file is no DXF or lines were lost in it; export it again".to_owned(),
                });
            };
            let Some(value) = self.lines.next() else {
                return Err(self.truncated("after a group code"));
            };
            self.line += 1;
            if code != 999 {
                let value = if matches!(code, 1 | 3) { value } else { value.trim() };
                return Ok(Some(Tag { code, value, line: self.line }));
            }
        }
    }

    /// Gives the tag back, to be the next one again.
    pub fn give_back(&mut self, tag: Tag<'a>) {
        self.back = Some(tag);
    }

    /// Goes on after the section's ENDSEC.
    pub fn skip_section(&mut self) -> Result<(), DrawingError> {
        while let Some(tag) = self.next()? {
            if tag.code == 0 && tag.value == "ENDSEC" {
                return Ok(());
            }
        }
        Err(self.truncated("inside a section"))
    }

    /// The error of a file that ends here.
    pub fn truncated(&self, inside: &str) -> DrawingError {
        let at = Place::bare_line(self.file, self.line.max(1));
        DrawingError::Truncated { at, inside: inside.to_owned() }
    }
}
