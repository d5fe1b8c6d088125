//! What a task program says on its standard output and error: `launch`'s, and a program's own.
//!
//! In: texts. Out: the same on the terminal. A process that supervises or moves robots must not wait for a terminal that
//! nobody reads: while a [`Background`] lives, lines for the standard error are put into a queue, and a thread writes
//! them. Lines for which there is no room, or which cannot be written, are dropped and counted.
//!
//! Messages quote texts from files, which may hold anything: [`quoted`] and [`excerpt`] make of them what a terminal can
//! show. They are cut where they are quoted; [`complain`] leaves out control characters of all that it prints, for names
//! of files and texts of programs may have them as well.

use core::fmt::Display;
use core::time::Duration;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Write};
use std::process::ExitCode;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// How many lines may wait to be written.
const LINES: usize = 256;

/// How long the end of a [`Background`] waits until all lines are written.
const WRITING: Duration = Duration::from_secs(1);

/// Stack of the thread that writes \[bytes\], kept small because locked memory holds all of it.
const STACK: usize = 64 << 10;

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

/// Prints a line, or several, on the standard error: without one the exit status alone must tell. While a [`Background`]
/// lives, it does not wait.
pub fn complain(line: &str) {
    let line: String = line.chars().map(|c| if c == '\n' { c } else { plain(c) }).collect();
    if !QUEUE.put(&line) {
        let _ = write_line(&mut io::stderr(), &line);
    }
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

/// Waits for up to `time` until all lines that wait in the background are written.
pub fn wait_until_written(time: Duration) {
    QUEUE.wait(QUEUE.state(), time);
}

/// Writes a line in one piece, so that it is not mixed with lines of other processes.
fn write_line(to: &mut impl Write, line: &str) -> io::Result<()> {
    to.write_all(format!("{line}\n").as_bytes())
}

/// The lines of this process for the standard error.
static QUEUE: Queue = Queue::new();

/// While it lives, [`complain`] puts its lines into a queue and never waits for who reads them. Its end waits a second
/// for the lines to be written; those that are not written by then stay in the queue.
#[derive(Debug)]
#[must_use = "lines are written in the background only while it lives"]
pub struct Background(());

impl Background {
    /// Begins to write lines in the background.
    ///
    /// # Errors
    /// The thread that writes them cannot be started.
    pub fn begin() -> io::Result<Background> {
        let mut state = QUEUE.state();
        if !state.has_writer {
            let writer = std::thread::Builder::new().name("output".to_owned()).stack_size(STACK);
            writer.spawn(|| QUEUE.write_to(&mut io::stderr()))?;
            state.has_writer = true;
        }
        state.users += 1;
        Ok(Background(()))
    }
}

impl Drop for Background {
    fn drop(&mut self) {
        QUEUE.leave(WRITING);
    }
}

/// Lines that wait to be written.
struct Queue {
    state: Mutex<State>,
    changed: Condvar,
}

struct State {
    /// How many [`Background`]s live.
    users: usize,
    has_writer: bool,
    lines: VecDeque<String>,
    /// Whether the writer has taken a line that it has not written yet.
    is_writing: bool,
    /// Lines that were dropped and not told of yet.
    dropped: u64,
}

impl State {
    fn is_written(&self) -> bool {
        self.lines.is_empty() && !self.is_writing
    }
}

impl Queue {
    const fn new() -> Queue {
        let state =
            State { users: 0, has_writer: false, lines: VecDeque::new(), is_writing: false, dropped: 0 };
        Queue { state: Mutex::new(state), changed: Condvar::new() }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // The state is valid even if a thread panicked while it held the lock.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a line, or drops it if there is no room; `false` if the caller is to write it.
    fn put(&self, line: &str) -> bool {
        let mut state = self.state();
        if state.users == 0 && state.is_written() {
            return false;
        }
        if state.lines.len() < LINES {
            state.lines.push_back(line.to_owned());
        } else {
            state.dropped += 1;
        }
        self.changed.notify_all();
        true
    }

    /// Writes lines as they come. What was dropped is told as soon as something can be written again.
    fn write_to(&self, to: &mut impl Write) {
        let mut state = self.state();
        loop {
            let Some(line) = state.lines.pop_front() else {
                state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            state.is_writing = true;
            drop(state);
            let is_written = write_line(to, &line).is_ok();
            state = self.state();
            if !is_written {
                state.dropped += 1;
            } else if state.dropped > 0 {
                let dropped = core::mem::take(&mut state.dropped);
                state
                    .lines
                    .push_back(format!("note: {dropped} lines were dropped, because nobody read them"));
            }
            state.is_writing = false;
            self.changed.notify_all();
        }
    }

    /// One user less. The last one waits for up to `time` until all lines are written.
    fn leave(&self, time: Duration) {
        let mut state = self.state();
        state.users -= 1;
        if state.users == 0 {
            self.wait(state, time);
        }
    }

    /// Waits until all lines are written, or until `time` is over.
    fn wait(&self, state: MutexGuard<'_, State>, time: Duration) {
        drop(self.changed.wait_timeout_while(state, time, |state| !state.is_written()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::{Receiver, Sender, channel};

    /// A terminal that writes a line when it is told to.
    struct Terminal {
        may: Receiver<io::Result<()>>,
        written: Sender<String>,
    }

    impl Write for Terminal {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.may.recv().map_err(io::Error::other)??;
            self.written.send(String::from_utf8_lossy(bytes).into_owned()).map_err(io::Error::other)?;
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn nobody_waits_for_a_terminal_that_nobody_reads_and_dropped_lines_are_counted() {
        let queue: &'static Queue = Box::leak(Box::new(Queue::new()));
        assert!(!queue.put("written by the caller"));
        queue.state().users = 1;
        let ((allow, may), (written, lines)) = (channel(), channel());
        std::thread::spawn(move || queue.write_to(&mut Terminal { may, written }));
        assert!(queue.put("line 0"));
        while !queue.state().is_writing {
            std::thread::yield_now();
        }
        for line in 1..LINES + 10 {
            assert!(queue.put(&format!("line {line}")));
        }
        queue.leave(Duration::from_millis(1));
        // Nobody writes past what waits.
        assert!(queue.put("one more"));
        assert_eq!(queue.state().dropped, 10);
        // Line 0 cannot be written; then come all that found room, and the count of the others.
        allow.send(Err(io::ErrorKind::BrokenPipe.into())).expect("it waits");
        (0..=LINES).for_each(|_| allow.send(Ok(())).expect("it waits"));
        let said: Vec<_> = lines.iter().take(LINES + 1).collect();
        assert_eq!(said[0], "line 1\n");
        assert_eq!(said[LINES], "note: 11 lines were dropped, because nobody read them\n");
        while !queue.state().is_written() {
            std::thread::yield_now();
        }
        assert!(!queue.put("written by the caller again"));
    }

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
