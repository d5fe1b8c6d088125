//! Progress on stderr: a bar that is drawn over itself on a terminal, a line now and then elsewhere.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

/// Where progress goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Display {
    /// A bar on a terminal.
    Bar,
    /// Plain lines.
    Lines,
    /// Nothing.
    Silent,
}

impl Display {
    /// What suits stderr.
    #[must_use]
    pub fn for_stderr() -> Self {
        if std::io::stderr().is_terminal() { Self::Bar } else { Self::Lines }
    }
}

/// The bar. Updating costs nanoseconds but for ten times a second: it looks at the clock every few hundred steps.
#[derive(Debug)]
pub struct Progress {
    display: Display,
    total_mm: f64,
    began: Instant,
    shown: Instant,
    every: Duration,
    until_look: u32,
}

/// Steps between looks at the clock.
const LOOK_EVERY: u32 = 512;

/// Cells of the bar.
const CELLS: usize = 28;

impl Progress {
    /// Progress of a job whose path, travel included, is `total_mm` long.
    #[must_use]
    pub fn new(display: Display, total_mm: f64) -> Self {
        let every = match display {
            Display::Bar => Duration::from_millis(100),
            Display::Lines | Display::Silent => Duration::from_secs(5),
        };
        let now = Instant::now();
        Self { display, total_mm, began: now, shown: now, every, until_look: LOOK_EVERY }
    }

    /// Tells the step and how much of the path \[mm\] is done.
    pub fn at(&mut self, step: u64, path_mm: f64) {
        if self.display == Display::Silent {
            return;
        }
        self.until_look -= 1;
        if self.until_look == 0 {
            self.until_look = LOOK_EVERY;
            let now = Instant::now();
            if now - self.shown >= self.every {
                self.shown = now;
                self.show(step, path_mm);
            }
        }
    }

    /// Shows the end and goes to the next line.
    pub fn finish(mut self, step: u64) {
        if self.display == Display::Bar {
            self.show(step, self.total_mm);
            let _ = writeln!(std::io::stderr());
        }
    }

    fn show(&mut self, step: u64, path_mm: f64) {
        let line = line(step, path_mm, self.total_mm, self.began.elapsed());
        let mut stderr = std::io::stderr().lock();
        // A terminal that is gone is no reason to stop.
        let _ = match self.display {
            Display::Bar => write!(stderr, "\r{line}\x1b[K").and_then(|()| stderr.flush()),
            Display::Lines => writeln!(stderr, "{line}"),
            Display::Silent => Ok(()),
        };
    }
}

/// `[####----] 42 %  step 12345  1234 of 2950 mm  3 s left`
fn line(step: u64, path_mm: f64, total_mm: f64, elapsed: Duration) -> String {
    let share = if total_mm > 0.0 { (path_mm / total_mm).clamp(0.0, 1.0) } else { 0.0 };
    let full = (share * CELLS as f64).round() as usize;
    let bar: String = (0..CELLS).map(|i| if i < full { '#' } else { '-' }).collect();
    let left = if share > 0.01 {
        format!("{:.0} s left", elapsed.as_secs_f64() * (1.0 - share) / share)
    } else {
        "-- s left".to_owned()
    };
    format!("[{bar}] {:3.0} %  step {step}  {path_mm:.0} of {total_mm:.0} mm  {left}", share * 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_tells_step_path_and_time_left() {
        let text = line(4000, 250.0, 1000.0, Duration::from_secs(10));
        assert!(text.contains("[#######-"), "{text}");
        assert!(text.contains(" 25 %  step 4000  250 of 1000 mm  30 s left"), "{text}");
    }

    #[test]
    fn a_path_of_no_length_and_one_too_long_are_shown() {
        assert!(line(0, 0.0, 0.0, Duration::ZERO).contains("  0 %"));
        assert!(line(9, 12.0, 10.0, Duration::from_secs(1)).contains("100 %"));
    }
}
