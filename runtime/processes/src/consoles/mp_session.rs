//! The console session of one MP: that of the cell, or that of a lower one.
//!
//! In: the processes of the launch. Out: for each MP among them what consoles ask of it, and which processes its picture shows.

use std::sync::Arc;
use std::time::Instant;

use mrroc_core::fault::{ProcessId, Role};
use mrroc_core::operator::button::Button;

/// A press that is under way.
#[derive(Clone, Copy)]
pub(super) struct Flight {
    pub number: u64,
    pub button: Button,
    pub since: Instant,
}

/// What consoles ask of one MP: that of the cell, or that of a lower one.
pub(super) struct MpSession {
    pub mp: ProcessId,
    /// The presses under way, by their kinds.
    pub flights: [Option<Flight>; Button::KINDS],
    pub presses_made: u64,
    /// The console that holds the control token.
    pub holder: Option<u64>,
    /// The picture of the present round, as text.
    pub drawn: Option<Arc<str>>,
}

impl MpSession {
    /// The sessions of the MPs among these processes.
    pub fn of(processes: impl Iterator<Item = ProcessId>) -> Vec<MpSession> {
        let mps = processes.filter(|id| id.role == Role::Mp);
        let session =
            |mp| MpSession { mp, flights: [None; Button::KINDS], presses_made: 0, holder: None, drawn: None };
        let mut sessions: Vec<_> = mps.map(session).collect();
        sessions.sort_by_key(|session| session.mp.name.is_some());
        sessions
    }

    /// Whether a process is one of its cell.
    pub fn has(&self, process: ProcessId) -> bool {
        let mut cell = process.cell();
        while let Some(name) = cell.filter(|_| cell != self.mp.name) {
            cell = name.cell();
        }
        cell == self.mp.name
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_core::fault::Name;

    #[test]
    fn the_uppermost_session_comes_first_and_a_session_has_the_processes_of_its_cell_and_of_those_in_it() {
        let id = |role, name: &str| ProcessId::new(role, Name::of_process(name).expect("a name"));
        let processes = [
            id(Role::Mp, "line"),
            id(Role::Mp, "line.press"),
            id(Role::Edp, "line.press.arm"),
            ProcessId::MP,
            ProcessId::PLANT,
            id(Role::Vsp, "camera"),
            id(Role::Ecp, "line.arm"),
        ];
        let sessions = MpSession::of(processes.into_iter());
        let has = |session: &MpSession| processes.map(|process| session.has(process));
        assert_eq!(
            sessions.iter().map(|session| session.mp).collect::<Vec<_>>(),
            [processes[3], processes[0], processes[1]]
        );
        assert_eq!(has(&sessions[0]), [true; 7]);
        assert_eq!(has(&sessions[1]), [true, true, true, false, false, false, true]);
        assert_eq!(has(&sessions[2]), [false, true, true, false, false, false, false]);
    }
}
