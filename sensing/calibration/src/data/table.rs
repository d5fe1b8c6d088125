//! A table of numbers as text: rows, cells with their places, columns by name.

use core::ops::Range;

use super::mistake::Source;
use super::section::At;

/// How cells are separated, and numbers written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Form {
    /// `None`: any number of blanks and tabs.
    pub(super) separator: Option<char>,
    /// The decimal point.
    pub(super) point: char,
}

/// A cell's text without blanks around it, and where it stands.
pub(super) type Cell = At<String>;

/// A row, and where it stands.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub(super) cells: Vec<Cell>,
    pub(super) span: Range<usize>,
}

/// Splits the text from `from` on into rows; empty lines, and lines that begin with `#`, are none.
pub(super) fn rows(source: &Source, from: usize, form: Form) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut at = from;
    for line in source.text[from..].split_inclusive('\n') {
        let begin = at;
        at += line.len();
        let text = line.trim_end_matches(['\n', '\r']);
        if text.trim().is_empty() || text.trim_start().starts_with('#') {
            continue;
        }
        let span = begin..begin + text.len();
        rows.push(Row { cells: cells(text, begin, form), span });
    }
    rows
}

fn cells(line: &str, begin: usize, form: Form) -> Vec<Cell> {
    let mut pieces: Vec<Range<usize>> = Vec::new();
    match form.separator {
        Some(separator) => {
            let mut quoted = false;
            let mut from = 0;
            for (i, c) in line.char_indices() {
                match c {
                    '"' => quoted = !quoted,
                    c if c == separator && !quoted => {
                        pieces.push(from..i);
                        from = i + c.len_utf8();
                    }
                    _ => {}
                }
            }
            pieces.push(from..line.len());
        }
        None => {
            let mut from = None;
            for (i, c) in line.char_indices() {
                match (c.is_whitespace(), from) {
                    (false, None) => from = Some(i),
                    (true, Some(start)) => {
                        pieces.push(start..i);
                        from = None;
                    }
                    _ => {}
                }
            }
            pieces.extend(from.map(|start| start..line.len()));
        }
    }
    let cell = |piece: Range<usize>| {
        let text = &line[piece.clone()];
        let lead = text.len() - text.trim_start().len();
        let trimmed = text.trim();
        let start = begin + piece.start + lead;
        let span = start..start + trimmed.len();
        let value = trimmed.strip_prefix('"').and_then(|text| text.strip_suffix('"')).unwrap_or(trimmed);
        At { value: value.to_owned(), span }
    };
    pieces.into_iter().map(cell).collect()
}

/// The number in a cell; a mistake is noted.
pub(super) fn number(source: &Source, cell: &Cell, column: &str, form: Form) -> Option<f64> {
    let text = if form.point == '.' { cell.value.clone() } else { cell.value.replace(form.point, ".") };
    let read = text.parse().ok().filter(|number: &f64| number.is_finite());
    if read.is_none() {
        let what = format!("`{}` in column `{column}` is no number", cell.value);
        let help = match form.point {
            '.' if cell.value.contains(',') => {
                "write 1.5; or say in the header decimal = \",\", with a separator that is no comma"
            }
            _ => {
                "write a number, or say in the header which texts mean that nothing was measured: missing = [\"\", \"nan\"]"
            }
        };
        source.complain(&cell.span, what, help);
    }
    read
}
