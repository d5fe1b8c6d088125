//! How the run of a cell has ended.
//!
//! In: how each of its processes has ended. Out: the steps and the time of the run, and the first cause of a stop.

use std::time::Duration;

use super::process_set::{Member, ProcessSet};
use mrroc_core::cell::first_cause;
use mrroc_core::console::complain;
use mrroc_core::fault::{Fault, ProcessId};
use mrroc_core::link::Nanos;

/// The result of a run.
pub(super) struct Run {
    /// The first process that died.
    death: Option<Fault>,
    outcomes: Vec<(ProcessId, Result<(), Fault>)>,
    pub steps: u64,
    pub time: Duration,
}

impl Run {
    pub fn of(process_set: &ProcessSet, death: Option<Fault>, time: Option<Nanos>) -> Run {
        let overs: Vec<_> = process_set
            .members
            .iter()
            .filter_map(|member| Some((member.id, member.over.borrow().clone()?)))
            .collect();
        let mp = overs.iter().find(|(id, _)| *id == ProcessId::MP).map(|(_, over)| over);
        let time = time.or_else(|| mp.map(|over| over.time)).unwrap_or(0);
        Run {
            death,
            steps: mp.map_or(0, |over| over.steps),
            time: Duration::from_nanos(time),
            outcomes: overs.into_iter().filter_map(|(id, over)| Some((id, over.outcome?))).collect(),
        }
    }

    /// Its first cause, if it was stopped.
    pub fn outcome(self) -> Result<(), Fault> {
        match self.death {
            Some(death) => Err(death),
            None => first_cause(&self.outcomes),
        }
    }
}

/// Tells of a process whose end the cell survives.
pub(super) fn note(member: &Member, how: &str) {
    complain(&format!("note: {}: {how}", member.id));
}
