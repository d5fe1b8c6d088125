//! What the launcher says of a cell that has stopped for a fault and awaits its reset.
//!
//! In: what the MP shows on the state board. Out: a text, once for each stop and for each reset that fails.

use crate::board::entry::MpPanel;
use mrroc_core::fault::{Fault, Name};
use mrroc_core::operator::CellState;
use mrroc_core::operator::button::Button;

/// What a person can do at a cell that awaits its reset.
const WAITS: &str = "nothing moves until it is reset. From another terminal: `acknowledge`, then `reset`, starts its programs again; \
     `abort`, or Ctrl-C here, ends it";

/// The same of a lower cell.
fn waits(cell: Option<Name>) -> String {
    let Some(cell) = cell else { return WAITS.to_owned() };
    format!(
        "nothing moves in it until it is reset. From another terminal: `acknowledge --of {cell}`, then `reset --of {cell}`, starts its \
         program again; one that was stopped from above is reset from there"
    )
}

/// What was told of a stop.
struct Told {
    /// The reset that was carried out last when it was told.
    reset: u64,
    /// What forbade a reset when that was told last.
    persisting: Option<Fault>,
}

/// What was told of the cell.
pub(super) struct LatchNotes {
    awaits_reset: bool,
    /// The lower cell that it is.
    cell: Option<Name>,
    /// The reset that was carried out last.
    reset: u64,
    told: Option<Told>,
}

impl LatchNotes {
    /// Of a cell that awaits a reset after a fault, or ends: then its end tells the fault.
    pub const fn new(awaits_reset: bool) -> LatchNotes {
        LatchNotes { awaits_reset, cell: None, reset: 0, told: None }
    }

    /// Of a lower cell that awaits a reset after a fault.
    pub const fn of_lower(cell: Name) -> LatchNotes {
        LatchNotes { awaits_reset: true, cell: Some(cell), reset: 0, told: None }
    }

    /// The lower cell that it is.
    pub const fn cell(&self) -> Option<Name> {
        self.cell
    }

    /// What is to be said now, if anything is.
    pub fn look(&mut self, mp: &MpPanel) -> Option<String> {
        let answer = &mp.answers[Button::Reset.kind()];
        if answer.done {
            self.reset = answer.number;
        }
        if !self.awaits_reset {
            return None;
        }
        match mp.state {
            CellState::Latched | CellState::Acknowledged => {}
            CellState::Stopping | CellState::Resetting => return None,
            CellState::Idle | CellState::Running | CellState::Suspended | CellState::Aborting => {
                self.told = None;
                return None;
            }
        }
        let reset = self.reset;
        // What comes and goes, as answers of a machine that is late, is told once.
        let told = self.told.take().filter(|told| mp.persisting.is_some() || told.reset == reset);
        let kept = told.as_ref().and_then(|told| told.persisting.clone());
        self.told = Some(Told { reset, persisting: mp.persisting.clone().or(kept) });
        match (told, &mp.persisting) {
            // The first time, or it was reset and has stopped again since the last look.
            (None, persisting) => {
                let why =
                    persisting.as_ref().map(|why| format!("\n a reset would be refused: {}", advised(why)));
                Some(self.stopped(mp, &why.unwrap_or_default()))
            }
            (Some(told), Some(why)) if told.reset != reset => {
                Some(format!("error: {}the reset failed: {}\n {}", self.of(), advised(why), waits(self.cell)))
            }
            (Some(told), Some(why)) if told.persisting.as_ref() != Some(why) => {
                Some(format!("note: {}a reset would be refused: {}", self.of(), advised(why)))
            }
            (Some(_), _) => None,
        }
    }

    fn stopped(&self, mp: &MpPanel, why: &str) -> String {
        let cause = mp.fault.as_ref().map_or_else(|| "it does not say for what".to_owned(), advised);
        format!("error: {}the cell has stopped: {cause}{why}\n {}", self.of(), waits(self.cell))
    }

    /// Whose it is, before other words.
    fn of(&self) -> String {
        self.cell.map_or_else(String::new, |cell| format!("{cell}: "))
    }
}

/// A fault and what to do about it.
fn advised(fault: &Fault) -> String {
    match fault.help() {
        Some(help) => format!("{fault}\n help: {help}"),
        None => fault.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_core::fault::{FaultKind, ProcessId};
    use mrroc_core::operator::button::Pressed;

    fn panel(state: CellState, persisting: Option<&str>, reset: u64) -> MpPanel {
        let fault = |text| Fault::new(FaultKind::DriveFault).in_process(ProcessId::MP).at_step(7).text(text);
        let mut panel = MpPanel { state, ..MpPanel::default() };
        panel.fault = Some(fault("the brake"));
        panel.persisting = persisting.map(fault);
        panel.answers[Button::Reset.kind()] =
            Pressed { number: reset, step: 9, state: CellState::Acknowledged, done: reset > 0, why: None };
        panel
    }

    #[test]
    fn a_stop_is_told_once_with_its_cause_and_what_to_do_and_so_is_a_reset_that_fails() {
        use CellState::{Acknowledged, Latched, Resetting, Running, Stopping};
        let mut notes = LatchNotes::new(true);
        let mut look =
            |state, persisting, reset| notes.look(&panel(state, persisting, reset)).unwrap_or_default();
        assert_eq!(look(Running, None, 0), "");
        assert_eq!(look(Stopping, None, 0), "");
        let told = look(Latched, None, 0);
        for words in [
            "drive fault: the brake",
            "step 7",
            "clear what tripped it",
            "`acknowledge`, then `reset`",
            "`abort`",
        ] {
            assert!(told.contains(words), "{words}: {told}");
        }
        for state in [Latched, Acknowledged, Resetting, Stopping] {
            assert_eq!(look(state, None, 0), "");
        }
        // A reset fails, seen or not while it was carried out; and again for the same reason.
        for reset in [3, 4] {
            let told = look(Latched, Some("no air"), reset);
            assert!(told.contains("the reset failed: mp: drive fault: no air"), "{told}");
            assert_eq!(look(Latched, Some("no air"), reset), "");
            assert_eq!(look(Acknowledged, Some("no air"), reset), "");
            assert_eq!(look(Acknowledged, None, reset), "");
        }
        let told = look(Acknowledged, Some("door"), 4);
        assert!(told.contains("a reset would be refused") && told.contains("door"), "{told}");
        // The reset succeeds, and the cell stops again before anybody looks; then with a look in between.
        assert!(look(Latched, None, 5).contains("has stopped"));
        assert_eq!(look(Running, None, 5), "");
        assert!(look(Latched, None, 5).contains("has stopped"));
    }

    #[test]
    fn a_cell_that_ends_after_a_fault_is_told_of_by_its_end() {
        assert_eq!(LatchNotes::new(false).look(&panel(CellState::Latched, None, 0)), None);
    }
}
