//! The figures of a process in real time: how late it woke, how long it worked, which periods it left out.
//!
//! In: the samples of its steps, in a ring. Out: [`Figures`] to the launcher, once a second and at the end. A thread of
//! ordinary priority computes the figures; the step only puts samples into the ring.

use std::fmt::Write;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use hdrhistogram::Histogram;

use super::control::{Control, Frame};
use crate::iceoryx::Samples;
use mrroc_core::fault::ProcessId;
use mrroc_core::link::{Nanos, Sample};
use mrroc_launch::outcome_file::{Punctuality, Times};

/// The time between two emptyings of the ring.
const EMPTYING: Duration = Duration::from_millis(200);
/// After how many emptyings the figures are sent.
const TELLING: u32 = 5;

/// The longest time that is resolved \[ns\]: a minute.
const LONGEST: u64 = 60_000_000_000;

/// The distribution of a time \[ns\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spread {
    /// How many samples there are.
    pub count: u64,
    /// The median \[ns\].
    pub p50: Nanos,
    /// The 99th percentile \[ns\].
    pub p99: Nanos,
    /// The maximum \[ns\].
    pub max: Nanos,
}

/// The figures of a process since the cell began.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Figures {
    /// How late steps of the MP and servo periods of an EDP or of the plant began.
    pub late: Spread,
    /// How long the process itself worked on a step, a servo period, an order or a reading.
    pub worked: Spread,
    /// How many periods were left out.
    pub skipped: u64,
    /// How many steps took a period or more of the process's own time.
    pub overruns: u64,
    /// How many samples were dropped because the ring was full.
    pub dropped: u64,
}

/// Number of words in which figures are sent.
pub(super) const FIGURES_WORDS: usize = 11;

impl Spread {
    fn times(&self) -> Times {
        Times { p50: self.p50, p99: self.p99, max: self.max }
    }
}

impl Figures {
    /// Of this process, for the file of the outcome.
    pub(super) fn punctuality(&self, process: ProcessId) -> Punctuality {
        let Figures { late, worked, skipped, overruns, .. } = self;
        let (skipped, overruns) = (*skipped, *overruns);
        Punctuality {
            process,
            steps: worked.count,
            skipped,
            overruns,
            late: late.times(),
            worked: worked.times(),
        }
    }

    pub(super) fn put(&self, words: &mut [u64]) {
        let spread = |spread: &Spread| [spread.count, spread.p50, spread.p99, spread.max];
        words[..4].copy_from_slice(&spread(&self.late));
        words[4..8].copy_from_slice(&spread(&self.worked));
        words[8..FIGURES_WORDS].copy_from_slice(&[self.skipped, self.overruns, self.dropped]);
    }

    pub(super) fn get(words: &[u64; FIGURES_WORDS]) -> Figures {
        let [a, b, c, d, e, f, g, h, skipped, overruns, dropped] = *words;
        let spread = |count, p50, p99, max| Spread { count, p50, p99, max };
        Figures { late: spread(a, b, c, d), worked: spread(e, f, g, h), skipped, overruns, dropped }
    }
}

/// The samples of a process, counted so far.
struct Counts {
    late: Histogram<u32>,
    worked: Histogram<u32>,
    skipped: u64,
    overruns: u64,
    /// A step of the cell \[ns\].
    step: Nanos,
}

impl Counts {
    fn new(step: Nanos) -> Result<Counts, hdrhistogram::CreationError> {
        // Three digits: 0.1 % of every time.
        let histogram = || Histogram::new_with_max(LONGEST, 3);
        Ok(Counts { late: histogram()?, worked: histogram()?, skipped: 0, overruns: 0, step })
    }

    fn take(&mut self, samples: &Samples) {
        while let Some(sample) = samples.pop() {
            match sample {
                Sample::Late(time) => self.late.saturating_record(time),
                Sample::Worked(time) => {
                    self.worked.saturating_record(time);
                    self.overruns += u64::from(time >= self.step);
                }
                Sample::Skipped(periods) => self.skipped += periods,
            }
        }
    }

    fn figures(&self, dropped: u64) -> Figures {
        let spread = |histogram: &Histogram<u32>| Spread {
            count: histogram.len(),
            p50: histogram.value_at_quantile(0.5),
            p99: histogram.value_at_quantile(0.99),
            max: histogram.max(),
        };
        let (late, worked) = (spread(&self.late), spread(&self.worked));
        Figures { late, worked, skipped: self.skipped, overruns: self.overruns, dropped }
    }
}

/// The thread that counts the samples of this process.
pub(super) struct Gauge {
    samples: Arc<Samples>,
    over: Arc<AtomicBool>,
    thread: JoinHandle<()>,
}

impl Gauge {
    /// Begins to count. Until [`end`](Self::end) is called, only its thread sends frames to the launcher.
    ///
    /// # Errors
    /// The thread cannot be started, or the socket cannot be duplicated.
    pub fn start(control: &Control, step: Nanos) -> io::Result<Gauge> {
        let (samples, over) = (Arc::new(Samples::new()), Arc::new(AtomicBool::new(false)));
        let mut counts = Counts::new(step).map_err(io::Error::other)?;
        let control = control.try_clone()?;
        let (from, ended) = (Arc::clone(&samples), Arc::clone(&over));
        let thread = std::thread::Builder::new().name("figures".to_owned()).spawn(move || {
            for round in 1.. {
                let last = ended.load(Ordering::Acquire);
                counts.take(&from);
                if last || round % TELLING == 0 {
                    // Sending fails only when the launcher is gone.
                    drop(control.send(&Frame::Figures(counts.figures(from.dropped()))));
                }
                if last {
                    return;
                }
                std::thread::park_timeout(EMPTYING);
            }
        })?;
        Ok(Gauge { samples, over, thread })
    }

    /// The ring into which the process puts its samples.
    pub fn samples(&self) -> Arc<Samples> {
        Arc::clone(&self.samples)
    }

    /// Ends the thread, which sends the last figures.
    pub fn end(self) {
        self.over.store(true, Ordering::Release);
        self.thread.thread().unpark();
        drop(self.thread.join());
    }
}

/// The figures of all processes as a table, times in microseconds.
pub(crate) fn table(rows: &[(ProcessId, Figures)]) -> String {
    let process = |id: &ProcessId| id.to_string();
    let width = rows.iter().map(|(id, _)| process(id).len()).max().unwrap_or(0).max("process".len());
    let mut text = format!(
        "{:width$} {:>8} {:>8} {:>8} {:>27} {:>27}\n{:width$} {:>8} {:>8} {:>8} {:>9}{:>9}{:>9} {:>9}{:>9}{:>9}\n",
        "",
        "",
        "",
        "",
        "late [us]",
        "worked [us]",
        "process",
        "steps",
        "skipped",
        "overruns",
        "p50",
        "p99",
        "max",
        "p50",
        "p99",
        "max",
    );
    for (id, figures) in rows {
        let Figures { late, worked, skipped, overruns, .. } = figures;
        let times = |spread: &Spread| match spread.count {
            0 => format!("{:>9}{:>9}{:>9}", "-", "-", "-"),
            _ => [spread.p50, spread.p99, spread.max]
                .map(|time| format!("{:>9.1}", time as f64 * 1e-3))
                .concat(),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:width$} {:>8} {skipped:>8} {overruns:>8} {} {}",
            process(id),
            worked.count,
            times(late),
            times(worked)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_those_of_the_samples() {
        let samples = Samples::new();
        for i in 1..=1000 {
            samples.push(Sample::Late(1000 * i));
            samples.push(Sample::Worked(2_000_000 - 1000 * i));
        }
        samples.push(Sample::Skipped(3));
        samples.push(Sample::Skipped(4));
        let mut counts = Counts::new(1_500_000).expect("histograms");
        counts.take(&samples);
        let figures = counts.figures(samples.dropped());
        // 1 to 1000 us; 1000 to 1999 us, of which 500 are 1.5 ms or more: to three digits.
        let near = |a: Nanos, b: Nanos| assert!(a.abs_diff(b) <= b / 1000 + 1000, "{a} {b}");
        near(figures.late.p50, 500_000);
        near(figures.late.p99, 990_000);
        near(figures.late.max, 1_000_000);
        near(figures.worked.p50, 1_500_000);
        near(figures.worked.max, 1_999_000);
        assert_eq!((figures.late.count, figures.worked.count), (1000, 1000));
        assert_eq!((figures.skipped, figures.overruns, figures.dropped), (7, 500, 0));
        let mut words = [0; FIGURES_WORDS];
        figures.put(&mut words);
        assert_eq!(Figures::get(&words), figures);
    }

    #[test]
    fn the_table_has_a_row_for_each_process_and_no_times_where_none_were_taken() {
        let spread = Spread { count: 1750, p50: 58_300, p99: 112_000, max: 3_001_000 };
        let figures = Figures {
            late: spread,
            worked: Spread { count: 1750, ..spread },
            skipped: 2,
            ..Figures::default()
        };
        let mute = Figures::default();
        let text = table(&[(ProcessId::MP, figures), (ProcessId::PLANT, mute)]);
        let rows: Vec<Vec<_>> = text.lines().map(|line| line.split_whitespace().collect()).collect();
        assert_eq!(rows[2], ["mp", "1750", "2", "0", "58.3", "112.0", "3001.0", "58.3", "112.0", "3001.0"]);
        assert_eq!(rows[3], ["plant", "0", "0", "0", "-", "-", "-", "-", "-", "-"]);
        let widths: Vec<_> = text.lines().map(str::len).collect();
        assert!(widths.iter().all(|&width| width == widths[0]), "{text}");
    }
}
