//! The figures of a process in real time: how late it woke, how long it worked, which periods it left out.
//!
//! In: what a process has counted. Out: its words in a frame, its row in the table at the end of a run and in the file of the
//! outcome.

use std::fmt::Write;

use mrroc_core::fault::ProcessId;
use mrroc_core::link::Nanos;
use mrroc_launch::outcome_file::{Punctuality, Times};
use serde::{Deserialize, Serialize};

/// The distribution of a time \[ns\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Spread {
    /// How many samples there are.
    pub count: u64,
    /// The median \[ns\].
    pub p50: Nanos,
    /// The 99th percentile \[ns\].
    pub p99: Nanos,
    /// The 99.9th percentile \[ns\].
    pub p99_9: Nanos,
    /// The maximum \[ns\].
    pub max: Nanos,
}

/// The figures of a process since the cell began.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
pub(crate) const FIGURES_WORDS: usize = 13;

impl Spread {
    fn times(&self) -> Times {
        Times { p50: self.p50, p99: self.p99, p99_9: self.p99_9, max: self.max }
    }
}

impl Figures {
    /// Of this process, for the file of the outcome.
    pub(crate) fn punctuality(&self, process: ProcessId) -> Punctuality {
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

    pub(crate) fn put(&self, words: &mut [u64]) {
        let spread = |spread: &Spread| [spread.count, spread.p50, spread.p99, spread.p99_9, spread.max];
        words[..5].copy_from_slice(&spread(&self.late));
        words[5..10].copy_from_slice(&spread(&self.worked));
        words[10..FIGURES_WORDS].copy_from_slice(&[self.skipped, self.overruns, self.dropped]);
    }

    pub(crate) fn get(words: &[u64; FIGURES_WORDS]) -> Figures {
        let [late @ .., _, _, _, _, _, _, _, _] = *words;
        let [_, _, _, _, _, worked @ .., skipped, overruns, dropped] = *words;
        let spread = |[count, p50, p99, p99_9, max]: [u64; 5]| Spread { count, p50, p99, p99_9, max };
        Figures { late: spread(late), worked: spread(worked), skipped, overruns, dropped }
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
    fn the_table_has_a_row_for_each_process_and_no_times_where_none_were_taken() {
        let spread = Spread { count: 1750, p50: 58_300, p99: 112_000, p99_9: 400_000, max: 3_001_000 };
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
