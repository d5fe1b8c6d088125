//! What a task program says on its standard output and error: `launch`'s, and a program's own.
//!
//! Messages quote texts from files, which may hold anything: [`quoted`] and [`excerpt`] make of them what a terminal can
//! show. They are cut where they are quoted; [`complain`] leaves out control characters of all that it prints, for names
//! of files and texts of programs may have them as well.

use core::fmt::Display;
use std::io::{self, ErrorKind, Write};
use std::process::ExitCode;

/// Prints a text. A reader that has had enough and closed the pipe is no failure.
#[must_use = "the exit status tells whether it could be written"]
pub fn say(text: &str) -> ExitCode {
    match io::stdout().write_all(text.as_bytes()).and_then(|()| io::stdout().flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            complain(&format!("error: the standard output cannot be written: {error}"));
            ExitCode::FAILURE
        }
        Ok(()) | Err(_) => ExitCode::SUCCESS,
    }
}

/// Prints a line, or several, on the standard error: without one the exit status alone must tell.
pub fn complain(line: &str) {
    let line: String = line.chars().map(|c| if c == '\n' { c } else { plain(c) }).collect();
    let _ = writeln!(io::stderr(), "{line}");
}

/// Characters of a line that an excerpt shows.
const WIDTH: usize = 76;

/// The beginning of a text from a file, as a message quotes it: at most `most` characters, on one line.
#[must_use]
pub fn quoted(text: &str, most: usize) -> String {
    let plain = |c: char| if c == '\t' { ' ' } else { plain(c) };
    let mut shown: String = text.chars().take(most).map(plain).collect();
    if text.chars().nth(most).is_some() {
        shown.push_str("..");
    }
    shown
}

/// Line `number` of a file around a place in it, with `width` carets below the characters from `column` on; both count
/// from 1. Column 0 shows the line's beginning without a caret. It begins with a line end and ends without one.
#[must_use]
pub fn excerpt(number: usize, line: &str, column: usize, width: usize) -> String {
    let is_long = line.chars().nth(WIDTH).is_some();
    let skip = if is_long { column.saturating_sub(WIDTH / 2) } else { 0 };
    let shown: String = line.chars().skip(skip).take(WIDTH).map(plain).collect();
    let gutter = number.to_string();
    if column == 0 {
        return format!("\n {gutter} | {shown}");
    }
    // The carets' line repeats the tabs of the line above, so that the carets stand below the right columns.
    let before = (column - 1).saturating_sub(skip);
    let tabs = shown.chars().map(|c| if c == '\t' { c } else { ' ' });
    let blank: String = tabs.chain(core::iter::repeat(' ')).take(before).collect();
    let room = shown.chars().count().saturating_sub(before).max(1);
    let carets = "^".repeat(width.clamp(1, room));
    format!("\n {gutter} | {shown}\n {} | {blank}{carets}", " ".repeat(gutter.len()))
}

/// What is shown of a character: a blank in place of one that would move the cursor, change colours, or reverse the order
/// of those round it.
fn plain(c: char) -> char {
    match c {
        '\t' => c,
        '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}' => ' ',
        c if c.is_control() => ' ',
        c => c,
    }
}

/// Tells of an error before anything has moved: exit status 2.
#[must_use = "the exit status tells that nothing has moved"]
pub fn refused(error: &dyn Display) -> ExitCode {
    complain(&format!("error: {error}"));
    ExitCode::from(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fault_79_a_text_from_a_file_is_cut_and_has_no_control_characters() {
        assert_eq!(quoted("an arm", 60), "an arm");
        assert_eq!(quoted("\u{1b}[2J\r\n\tarm\u{7}\u{202e}", 60), " [2J   arm  ");
        assert_eq!(quoted(&"x".repeat(61), 60), "x".repeat(60) + "..");
        assert_eq!(quoted("\u{85}\u{9b}31m", 3), "  3..");
    }

    #[test]
    fn an_excerpt_shows_a_long_line_around_its_column() {
        assert_eq!(excerpt(12, "G1 Q7", 4, 2), "\n 12 | G1 Q7\n    |    ^^");
        assert_eq!(excerpt(12, "G1\tQ7", 4, 20), "\n 12 | G1\tQ7\n    |   \t^^");
        assert_eq!(excerpt(3, "\u{1b}[2Jx", 0, 1), "\n 3 |  [2Jx");
        assert_eq!(excerpt(3, "", 1, 1), "\n 3 | \n   | ^");
        let long = excerpt(1, &"x".repeat(5000), 4000, 5000);
        assert!(long.lines().all(|line| line.len() < 90) && long.ends_with('^'), "{long}");
    }
}
