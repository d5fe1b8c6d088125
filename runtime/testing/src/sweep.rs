//! A sweep: each fault, in each step of a cell's program.
//!
//! In: what makes a cell, and which faults to inject. Out: a [`SweepReport`].

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};

use super::case::{Case, Injected, LinkFault, Press, Wire};
use super::check::check;
use super::forks::{Forks, Lasting, end_copy};
use super::report::SweepReport;
use super::trial::{Part, Trial, attempt};
use super::verdict::Verdict;
use mrroc_core::cell::{Cell, CellError};
use mrroc_core::fault::Name;

/// A kind of fault that a sweep injects into every process, into every link, or by the operator.
enum Deed<'c> {
    Kill,
    Stall(u32),
    Link(LinkFault, u32),
    Apart(Option<Name>, Wire, u32),
    Press(Press),
    Own(&'static str, Box<dyn Fn(u64) -> Cell + Sync + 'c>),
}

/// A run without a fault goes on to its end.
const UNDISTURBED: Lasting = Lasting { afterwards: 0, most: u64::MAX, watched: u64::MAX };

/// Runs a cell once for every fault in every step, and checks in each run what SAFETY.md promises.
///
/// The [module](super) has an example.
pub struct Sweep<'c> {
    cell: Box<dyn Fn() -> Cell + Sync + 'c>,
    deeds: Vec<Deed<'c>>,
    every: u64,
    seed: u64,
    threads: usize,
    end_tolerance: f64,
    watched: Option<u64>,
}

impl<'c> Sweep<'c> {
    /// A sweep of the cell that `cell` makes; each call must make the same cell.
    #[must_use]
    pub fn new(cell: impl Fn() -> Cell + Sync + 'c) -> Sweep<'c> {
        let cell = Box::new(cell);
        Sweep { cell, deeds: Vec::new(), every: 1, seed: 1, threads: 1, end_tolerance: 1e-6, watched: None }
    }

    /// Injects each fault in every `every`-th step only. Different faults begin in different steps, so that together
    /// they still cover all steps.
    #[must_use]
    pub fn every(mut self, every: u64) -> Self {
        self.every = every.max(1);
        self
    }

    /// Sets the seed of all that is random; 1 by default.
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Sets how many runs go on at a time; 1 by default.
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = threads.max(1);
        self
    }

    /// Goes through the program once and forks the process where each fault begins, so that a case costs only the steps
    /// after its fault. A copy that goes on after the fault is watched for `watched` steps, and at least as long as
    /// stops take; where it would end is not checked. As many copies run at a time as the sweep has
    /// [threads](Self::threads). Cells with
    /// [`own`](Self::own) faults are run from their beginning. On Unix only: elsewhere each case fails.
    #[must_use]
    pub fn forking(mut self, watched: u64) -> Self {
        self.watched = Some(watched);
        self
    }

    /// Sets how far from the end of the undisturbed run a run may end that was not stopped; 1e-6 in each joint by
    /// default [rad or m]. A program whose end depends on when it reads its sensors needs a value of its own.
    #[must_use]
    pub fn end_tolerance(mut self, tolerance: f64) -> Self {
        self.end_tolerance = tolerance;
        self
    }

    /// Kills each process.
    #[must_use]
    pub fn kills(self) -> Self {
        self.with(Deed::Kill)
    }

    /// Stalls each process for so many steps.
    #[must_use]
    pub fn stalls(self, steps: u32) -> Self {
        self.with(Deed::Stall(steps))
    }

    /// Injects this fault into each direction of each link, for so many steps.
    #[must_use]
    pub fn links(self, fault: LinkFault, steps: u32) -> Self {
        self.with(Deed::Link(fault, steps))
    }

    /// Puts the ECP of a robot, or every one, at the other end of a wire, seen from the MP, for so many steps.
    #[must_use]
    pub fn apart(self, whom: Option<Name>, wire: Wire, steps: u32) -> Self {
        self.with(Deed::Apart(whom, wire, steps))
    }

    /// Lets the operator press a button.
    #[must_use]
    pub fn presses(self, press: Press) -> Self {
        self.with(Deed::Press(press))
    }

    /// Runs the cell that `cell` makes for a step, in place of the sweep's cell: the same cell with a fault that begins
    /// in that step, or in that servo period. Each `name` is a row of the report and is used once.
    #[must_use]
    pub fn own(self, name: &'static str, cell: impl Fn(u64) -> Cell + Sync + 'c) -> Self {
        self.with(Deed::Own(name, Box::new(cell)))
    }

    fn with(mut self, deed: Deed<'c>) -> Self {
        self.deeds.push(deed);
        self
    }

    /// Runs all cases.
    #[must_use]
    pub fn run(self) -> SweepReport {
        let mut report = SweepReport::new(self.seed);
        let calm = match attempt((self.cell)(), Part::Calm, UNDISTURBED) {
            Ok(calm) if calm.outcome.is_ok() => calm,
            Ok(Trial { outcome: Err(error), .. }) | Err(error) => {
                report.undisturbed(format!("the undisturbed run ends with `{error}`"));
                return report;
            }
            Ok(_) => return report,
        };
        if let Some(wrong) = calm.robots.iter().find_map(|robot| robot.wrong.clone()) {
            report.undisturbed(format!("undisturbed: {wrong}"));
        }
        let mut cases = self.cases(&calm);
        if let Some(watched) = self.watched {
            let copied = cases.extract_if(.., |case| !matches!(case.injected, Injected::Own(_))).collect();
            self.try_copies(copied, watched, &calm, &mut report);
        }
        let next = AtomicUsize::new(0);
        let work = || {
            // Each thread has its own undisturbed run for the comparison, because cells do not cross threads.
            let mut report = SweepReport::new(self.seed);
            let Ok(calm) = attempt((self.cell)(), Part::Calm, UNDISTURBED) else { return report };
            while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
                report.add(case, self.try_one(case, &calm));
            }
            report
        };
        std::thread::scope(|scope| {
            let workers: Vec<_> = (0..self.threads.min(cases.len())).map(|_| scope.spawn(work)).collect();
            for worker in workers {
                match worker.join() {
                    Ok(part) => report.absorb(part),
                    Err(_) => report.undisturbed("a run panicked".to_owned()),
                }
            }
        });
        report
    }

    /// Runs each case in a copy of one run.
    fn try_copies(&self, cases: Vec<Case>, watched: u64, calm: &Trial, report: &mut SweepReport) {
        let lasting = self.lasting(calm);
        let watched = watched.max(2 * lasting.afterwards);
        let forks = Forks::new(cases, Lasting { watched, ..lasting }, self.threads);
        let run = std::process::id();
        let tried = catch_unwind(AssertUnwindSafe(|| {
            let trial = attempt((self.cell)(), Part::Copied(forks), UNDISTURBED)?;
            let verdict = trial.case.map(|case| check(&case, &trial, calm, self.end_tolerance));
            Ok::<_, CellError>((trial, verdict))
        }));
        if let Ok(Ok((trial, Some(verdict)))) = tried {
            trial.forks.tell(&verdict);
        } else if std::process::id() != run {
            end_copy();
        } else {
            match tried {
                Ok(Ok((trial, _))) => {
                    for (case, verdict) in trial.forks.verdicts() {
                        report.add(&case, verdict);
                    }
                }
                Ok(Err(error)) => report.undisturbed(error.to_string()),
                Err(_) => report.undisturbed("the run panicked".to_owned()),
            }
        }
    }

    /// Runs one case again, which a report has named, and reports its result.
    #[must_use]
    pub fn repeat(&self, case: &Case) -> SweepReport {
        let mut report = SweepReport::new(self.seed);
        match attempt((self.cell)(), Part::Calm, UNDISTURBED) {
            Ok(calm) => report.add(case, self.try_one(case, &calm)),
            Err(error) => report.undisturbed(error.to_string()),
        }
        report
    }

    fn try_one(&self, case: &Case, calm: &Trial) -> Verdict {
        let run = || attempt(self.cell_of(case), Part::One(*case), self.lasting(calm));
        match catch_unwind(AssertUnwindSafe(run)) {
            Ok(Ok(trial)) => check(case, &trial, calm, self.end_tolerance),
            Ok(Err(error)) => Verdict::Broken(error.to_string()),
            Err(_) => Verdict::Broken("the run panicked".to_owned()),
        }
    }

    fn lasting(&self, calm: &Trial) -> Lasting {
        let steps = calm.over / calm.step;
        // Longer than any stop, so that a motion after the stop is noticed.
        let afterwards = calm.stop_steps.max(calm.rate_steps) + 50;
        Lasting { afterwards, most: 3 * steps + 4 * afterwards + 5000, watched: u64::MAX }
    }

    /// The cell of a case.
    fn cell_of(&self, case: &Case) -> Cell {
        let own = self.deeds.iter().find_map(|deed| match deed {
            Deed::Own(name, cell) if case.injected == Injected::Own(name) => Some(cell(case.at)),
            Deed::Own(..)
            | Deed::Kill
            | Deed::Stall(_)
            | Deed::Link(..)
            | Deed::Apart(..)
            | Deed::Press(_) => None,
        });
        own.unwrap_or_else(|| (self.cell)())
    }

    fn cases(&self, calm: &Trial) -> Vec<Case> {
        let steps = calm.over / calm.step;
        let mut injected = Vec::new();
        for deed in &self.deeds {
            match deed {
                Deed::Kill => injected.extend(calm.processes.iter().map(|&who| Injected::Kill(who))),
                &Deed::Stall(steps) => {
                    injected.extend(calm.processes.iter().map(|&who| Injected::Stall(who, steps)));
                }
                &Deed::Link(fault, steps) => {
                    injected.extend(calm.channels.iter().map(|&at| Injected::Link(at, fault, steps)));
                }
                &Deed::Apart(whom, wire, steps) => injected.push(Injected::Apart(whom, wire, steps)),
                &Deed::Press(press) => injected.push(Injected::Press(press)),
                &Deed::Own(name, _) => injected.push(Injected::Own(name)),
            }
        }
        let mut cases = Vec::new();
        for (i, injected) in injected.into_iter().enumerate() {
            let first = 1 + i as u64 % self.every;
            for at in (first..=steps).step_by(self.every as usize) {
                let seed = self.seed.wrapping_mul(0x9e37_79b9).wrapping_add(cases.len() as u64);
                cases.push(Case { injected, at, seed });
            }
        }
        cases
    }
}
