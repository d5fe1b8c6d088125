//! The results of a sweep: figures of each fault, and the cases that failed.

use core::fmt;

use super::case::{Case, Injected};
use super::verdict::Verdict;

/// The figures of all cases of one fault.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Number of cases in which the fault was applied.
    pub cases: u64,
    /// Number of runs that ended without a fault, where the undisturbed run ends.
    pub survived: u64,
    /// Number of runs that stopped as promised and reported the cause.
    pub stopped: u64,
    /// The stop that used the largest share of its bound: its length from the cause, and its bound \[steps\].
    pub worst_stop: (u64, u64),
}

/// A case in which a promise was broken.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// The case, for [`Sweep::repeat`](super::Sweep::repeat); `None` if the undisturbed run failed.
    pub case: Option<Case>,
    /// The promise that was broken, and how.
    pub what: String,
}

/// The results of a sweep. Its display is a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SweepReport {
    rows: Vec<(String, Tally)>,
    failures: Vec<Failure>,
    seed: u64,
}

/// The largest number of failures that a report shows.
const SHOWN: usize = 20;

impl SweepReport {
    pub(super) fn new(seed: u64) -> SweepReport {
        SweepReport { seed, ..SweepReport::default() }
    }

    /// Whether all promises were kept in all cases.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        self.failures.is_empty()
    }

    /// The figures of each fault.
    #[must_use]
    pub fn rows(&self) -> &[(String, Tally)] {
        &self.rows
    }

    /// The cases in which a promise was broken.
    #[must_use]
    pub fn failures(&self) -> &[Failure] {
        &self.failures
    }

    /// The figures of all cases together.
    #[must_use]
    pub fn total(&self) -> Tally {
        self.rows.iter().fold(Tally::default(), |total, (_, tally)| total.and(tally))
    }

    /// Adds another sweep's figures.
    pub fn absorb(&mut self, other: SweepReport) {
        for (name, tally) in other.rows {
            let row = self.row(name);
            *row = row.and(&tally);
        }
        self.failures.extend(other.failures);
    }

    fn row(&mut self, name: String) -> &mut Tally {
        let place = self.rows.iter().position(|(known, _)| *known == name).unwrap_or_else(|| {
            self.rows.push((name, Tally::default()));
            self.rows.len() - 1
        });
        &mut self.rows[place].1
    }

    pub(super) fn undisturbed(&mut self, what: String) {
        self.failures.push(Failure { case: None, what });
    }

    pub(super) fn add(&mut self, case: &Case, verdict: Verdict) {
        let row = self.row(name(&case.injected));
        let one = Tally { cases: 1, ..Tally::default() };
        match verdict {
            Verdict::Void => {}
            Verdict::Survived => *row = row.and(&Tally { survived: 1, ..one }),
            Verdict::Stopped { steps, bound } => {
                *row = row.and(&Tally { stopped: 1, worst_stop: (steps, bound), ..one });
            }
            Verdict::Broken(what) => {
                *row = row.and(&one);
                self.failures.push(Failure { case: Some(*case), what });
            }
        }
    }
}

impl Tally {
    fn and(&self, other: &Tally) -> Tally {
        let (a, b) = (self.worst_stop, other.worst_stop);
        Tally {
            cases: self.cases + other.cases,
            survived: self.survived + other.survived,
            stopped: self.stopped + other.stopped,
            // Stops are compared by the share of their bounds.
            worst_stop: if a.0 * b.1.max(1) >= b.0 * a.1.max(1) && a.1 > 0 { a } else { b },
        }
    }
}

/// The name of a row: the fault, and the role of the process that has it.
fn name(injected: &Injected) -> String {
    match injected {
        Injected::Kill(process) => format!("kill {:?}", process.role).to_lowercase(),
        Injected::Stall(process, steps) => format!("stall {:?}, {steps} steps", process.role).to_lowercase(),
        Injected::Link(channel, fault, steps) => {
            let (from, to) = (channel.from.role, channel.to.role);
            let roles = format!("{from:?} → {to:?}").to_lowercase();
            format!("{fault}, {steps} steps of {roles}")
        }
        Injected::Apart(..) | Injected::Press(_) | Injected::Own(_) => injected.to_string(),
    }
}

impl fmt::Display for SweepReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<42}{:>9}{:>10}{:>9}  worst stop of bound [steps]",
            "fault", "cases", "survived", "stopped"
        )?;
        let total = ("all".to_owned(), self.total());
        for (name, tally) in self.rows.iter().chain([&total]) {
            let Tally { cases, survived, stopped, worst_stop: (worst, bound) } = tally;
            writeln!(f, "{name:<42}{cases:>9}{survived:>10}{stopped:>9}  {worst:>6} of {bound}")?;
        }
        for Failure { case, what } in self.failures.iter().take(SHOWN) {
            match case {
                Some(case) => writeln!(f, "BROKEN by {case}: {what}")?,
                None => writeln!(f, "BROKEN: {what}")?,
            }
        }
        let more = self.failures.len().saturating_sub(SHOWN);
        if more > 0 {
            writeln!(f, ".. and {more} more")?;
        }
        write!(f, "seed {}, {} broken", self.seed, self.failures.len())
    }
}
