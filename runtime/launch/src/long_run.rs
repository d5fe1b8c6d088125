//! Notes to a user who waits for a run that may never end.
//!
//! In: the steps of a run and the wall clock. Out: notes at growing intervals.

#![expect(clippy::disallowed_methods, reason = "it tells a user how long a run has taken")]

use std::time::{Duration, Instant};

use super::outcome::note;
use mrroc_core::operator::{CellState, Operator};

/// What is waited for.
#[derive(Clone, Copy)]
enum Awaited {
    /// The end of a run.
    Run,
    /// The end of a run in real time, which takes as long as its motions do, and which an operator sees and stops from another
    /// terminal: its length is no news.
    OperatedRun,
    /// The end of a dry run, in which nothing moves.
    DryRun,
}

/// Prints notes about a run that may never end, at growing intervals.
pub struct LongRunNotes {
    awaited: Awaited,
    since: Instant,
    next: Duration,
    /// Whether a cell that has stopped for a fault awaits its reset, and whether that was told.
    awaits_reset: bool,
    is_latch_told: bool,
}

impl LongRunNotes {
    /// Begins to wait; the first note is due after 10 s.
    pub fn begin() -> LongRunNotes {
        LongRunNotes::of(Awaited::Run)
    }

    /// The same for a run in real time with consoles: notes about faults alone.
    pub fn begin_operated() -> LongRunNotes {
        LongRunNotes::of(Awaited::OperatedRun)
    }

    /// The same for a dry run.
    pub(super) fn begin_dry() -> LongRunNotes {
        LongRunNotes::of(Awaited::DryRun)
    }

    fn of(awaited: Awaited) -> LongRunNotes {
        let next = Duration::from_secs(10);
        LongRunNotes { awaited, since: Instant::now(), next, awaits_reset: false, is_latch_told: false }
    }

    /// The same for a cell that may await its reset after a fault.
    #[must_use]
    pub const fn with_reset(self, awaits_reset: bool) -> LongRunNotes {
        LongRunNotes { awaits_reset, ..self }
    }

    /// The hook for every step, which looks at the wall clock from time to time and prints the notes.
    pub fn hook(mut self) -> impl FnMut(u64, &Operator) {
        move |step, operator| {
            let suspended = operator.is_suspended();
            if step % 1024 == 0
                && let Some(text) = self.after_stop(operator)
            {
                note(&text);
            }
            if step % 1024 == 0
                && !waits_for_something_else(operator)
                && let Some(text) = self.after(self.since.elapsed(), step, suspended)
            {
                note(&text);
            }
        }
    }

    /// The note about a cell that has stopped for a fault, once: it awaits its reset.
    fn after_stop(&mut self, operator: &Operator) -> Option<String> {
        let is_latched = matches!(operator.state(), CellState::Latched | CellState::Acknowledged);
        let was_told = core::mem::replace(&mut self.is_latch_told, is_latched);
        if was_told || !is_latched || !self.awaits_reset {
            return None;
        }
        let how = match self.awaited {
            Awaited::DryRun => return None,
            Awaited::OperatedRun => "press `acknowledge`, then `reset`, from another terminal, or `abort`",
            Awaited::Run => {
                "on the memory link only the program can press it; run it by --processes to reset it from another terminal; stop it by Ctrl-C"
            }
        };
        let cause = operator.fault().map_or_else(String::new, |fault| match fault.help() {
            Some(help) => format!(": {fault}\n help: {help}"),
            None => format!(": {fault}"),
        });
        Some(format!("the cell has stopped{cause}\n it awaits its reset: {how}"))
    }

    /// The note about a run that is in this step after this time, if one is due.
    fn after(&mut self, elapsed: Duration, step: u64, suspended: bool) -> Option<String> {
        if elapsed < self.next {
            return None;
        }
        self.next = elapsed * 2;
        let seconds = elapsed.as_secs();
        Some(match self.awaited {
            Awaited::OperatedRun => return None,
            Awaited::Run | Awaited::DryRun if suspended => format!(
                "still suspended after {seconds} s, in step {step}: on the memory link no console resumes it, only the program \
                 that has suspended it can; run it by --processes to resume it from another terminal; stop it by Ctrl-C"
            ),
            Awaited::Run => format!(
                "still running after {seconds} s, in step {step}: a motion ends where its step function returns `Step::Done`, a \
                 Wait where its condition holds; stop the program by Ctrl-C"
            ),
            Awaited::DryRun => format!("the dry run is in step {step} after {seconds} s; nothing moves"),
        })
    }
}

/// Whether no motion and no Wait of the program is at work: robots look for their reference marks, or the cell stands with a
/// fault until it is reset.
fn waits_for_something_else(operator: &Operator) -> bool {
    match operator.state() {
        CellState::Stopping | CellState::Latched | CellState::Acknowledged | CellState::Resetting => true,
        CellState::Idle | CellState::Running | CellState::Suspended | CellState::Aborting => {
            operator.is_homing()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::RefCell;
    use mrroc_core::cell::AfterFault;
    use mrroc_core::fault::Fault;
    use std::rc::Rc;

    #[test]
    fn a_cell_that_awaits_its_reset_under_the_virtual_clock_is_told_of_once() {
        let told = Rc::new(RefCell::new(Vec::new()));
        let keep = Rc::clone(&told);
        let mut notes = LongRunNotes::begin().with_reset(true);
        let (mut latched, mut is_first) = (0, true);
        let cell = mrroc_core::cell::Cell::new(Duration::from_millis(1))
            .after_fault(AfterFault::AwaitReset)
            .program(|_| Err(Fault::thrown("the tray is empty")))
            .on_step(move |_, operator| {
                keep.borrow_mut().extend(notes.after_stop(operator));
                latched += u32::from(operator.state() == CellState::Latched);
                match latched {
                    // It stops again: that is another stop.
                    5 if core::mem::take(&mut is_first) => {
                        operator.acknowledge().and_then(|()| operator.reset()).expect("nothing persists");
                    }
                    10 => operator.give_up(),
                    _ => {}
                }
            });
        assert!(cell.run().is_err());
        let told = told.borrow();
        assert!(told.len() == 2 && told[0].contains("the tray is empty"), "{told:?}");
        assert!(told[0].contains("--processes") && told[0].contains("Ctrl-C"), "{told:?}");
    }

    #[test]
    fn a_run_without_an_end_is_told_of_ever_more_seldom() {
        let mut notes = LongRunNotes::begin();
        let told: Vec<_> = (0..100)
            .filter(|&second| notes.after(Duration::from_secs(second), second * 500, false).is_some())
            .collect();
        assert_eq!(told, [10, 20, 40, 80]);
        let text = notes.after(Duration::from_secs(160), 80_000, false).expect("160 s is twice 80 s");
        assert!(text.contains("160 s, in step 80000") && text.contains("`Step::Done`"), "{text}");
    }

    #[test]
    fn a_run_in_real_time_is_not_told_of_however_long_it_takes() {
        let mut notes = LongRunNotes::begin_operated();
        let told = (0..10_000).filter_map(|second| notes.after(Duration::from_secs(second), second, false));
        assert_eq!(told.count(), 0);
    }

    #[test]
    fn a_dry_run_is_told_of_without_advice_to_stop_it() {
        let mut notes = LongRunNotes::begin_dry();
        let text = notes.after(Duration::from_secs(10), 80_000, false).expect("due");
        assert!(text.contains("dry run is in step 80000") && !text.contains("Ctrl-C"), "{text}");
    }

    #[test]
    fn a_run_that_its_own_program_has_suspended_is_told_who_can_resume_it() {
        let text = LongRunNotes::begin().after(Duration::from_secs(10), 1024, true).expect("due");
        assert!(text.contains("still suspended") && text.contains("--processes"), "{text}");
        assert!(!text.contains("`Step::Done`"), "{text}");
    }

    #[test]
    fn homing_is_waited_for_in_silence() {
        let operator = Operator::new();
        operator.begin();
        assert!(!waits_for_something_else(&operator), "a motion is at work");
        operator.show_homing(true);
        assert!(waits_for_something_else(&operator));
        operator.show_homing(false);
        assert!(!waits_for_something_else(&operator));
    }
}
