//! Reads the heights of a file: a row of numbers in each line.
//!
//! In: the text, numbers between spaces or commas; empty lines and those that begin with `#` are left out. Out: the heights
//! \[m\], or the line that is no row of them. The first line is the row at y = 0, and its first number is at x = 0.

use std::path::Path;

/// The heights of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    /// How many a row has, along x.
    pub columns: usize,
    /// The heights \[m\], row by row, the row at y = 0 first.
    pub heights: Vec<f64>,
}

/// The heights of a file.
pub(super) fn parse(_: &Path, text: &str) -> Result<Heights, String> {
    let mut columns = None;
    let mut heights = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let (number, line) = (index + 1, line.trim());
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let before = heights.len();
        for word in line.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty()) {
            let height = word.parse::<f64>().ok().filter(|height| height.is_finite());
            heights
                .push(height.ok_or_else(|| format!("line {number}: `{word}` is not a finite height [m]"))?);
        }
        let found = heights.len() - before;
        if found == 0 {
            return Err(format!("line {number} has no heights"));
        }
        let expected = *columns.get_or_insert(found);
        if found != expected {
            return Err(format!("line {number} has {found} heights, the lines before have {expected}"));
        }
    }
    match columns {
        Some(columns) => Ok(Heights { columns, heights }),
        None => Err("it has no heights".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_heights_are_read_and_what_is_no_row_is_refused_with_its_line() {
        let read = |text| parse(Path::new("ground.txt"), text);
        let heights = vec![0.0, 0.1, 0.2, 1.0, -1.0, 3.0];
        assert_eq!(read("# two rows\n0 0.1 0.2\n\n1, -1, 3\n"), Ok(Heights { columns: 3, heights }));
        let cases = [
            ("0 1\n2\n", "line 2 has 1 heights, the lines before have 2"),
            ("0 1\n2 NaN\n", "line 2: `NaN` is not a finite height [m]"),
            ("# nothing\n", "it has no heights"),
            (",\n", "line 1 has no heights"),
        ];
        for (text, expected) in cases {
            assert_eq!(read(text), Err(expected.to_owned()), "{text}");
        }
    }
}
