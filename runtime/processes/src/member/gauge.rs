//! The gauge of a process in real time: a thread that counts how late it woke, how long it worked, and which periods it left out.
//!
//! In: the samples of its steps, in a ring. Out: [`Figures`] to the launcher, once a second and at the end. A thread of
//! ordinary priority computes the figures; the step only puts samples into the ring.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use hdrhistogram::Histogram;

use crate::board::figures::{Figures, Spread};
use crate::control::{Control, Frame};
use crate::link::Samples;
use mrroc_core::link::{Nanos, Sample};

/// The time between two emptyings of the ring.
const EMPTYING: Duration = Duration::from_millis(200);
/// After how many emptyings the figures are sent.
const TELLING: u32 = 5;

/// The longest time that is resolved \[ns\]: a minute.
const LONGEST: u64 = 60_000_000_000;

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
            p99_9: histogram.value_at_quantile(0.999),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::figures::FIGURES_WORDS;

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
        near(figures.late.p99_9, 999_000);
        near(figures.late.max, 1_000_000);
        near(figures.worked.p50, 1_500_000);
        near(figures.worked.max, 1_999_000);
        assert_eq!((figures.late.count, figures.worked.count), (1000, 1000));
        assert_eq!((figures.skipped, figures.overruns, figures.dropped), (7, 500, 0));
        let mut words = [0; FIGURES_WORDS];
        figures.put(&mut words);
        assert_eq!(Figures::get(&words), figures);
    }
}
