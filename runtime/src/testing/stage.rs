//! What all that a trial surrounds a cell with has in common: the case, the time, who lives.

use core::cell::{Cell, RefCell};

use super::case::{Case, Channel, Injected};
use super::random::Random;
use crate::fault::ProcessId;
use crate::link::Nanos;

/// How long a trial goes on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lasting {
    /// What the robots are watched for after the MP's program is over, or gone \[steps\].
    pub afterwards: u64,
    /// After so many steps a trial is given up: it does not end.
    pub most: u64,
}

/// A run of a cell with a fault.
pub(super) struct Stage {
    pub case: Option<Case>,
    pub step: Nanos,
    pub lasting: Lasting,
    /// Time when a process woke last: between wake-ups the virtual clock stands \[ns\].
    pub now: Cell<Nanos>,
    /// Processes by place, and until when each of them stands still \[ns\].
    pub processes: RefCell<Vec<ProcessId>>,
    pub channels: RefCell<Vec<Channel>>,
    /// When a message that a channel keeps back is due at a place \[ns\].
    pub due: RefCell<Vec<Nanos>>,
    /// How often the fault had something to be done to.
    pub hits: Cell<u64>,
    /// Messages that a process which is killed still sends in its last step.
    last_words: Cell<u64>,
    /// When the MP's program was over \[ns\].
    pub over: Cell<Option<Nanos>>,
    pub given_up: Cell<bool>,
    pub random: RefCell<Random>,
}

pub(super) const NEVER: Nanos = Nanos::MAX;

impl Stage {
    pub fn new(case: Option<Case>, step: Nanos, lasting: Lasting) -> Stage {
        let mut random = Random::new(case.map_or(0, |case| case.seed));
        Stage {
            case,
            step: step.max(1),
            lasting,
            now: Cell::new(0),
            processes: RefCell::default(),
            channels: RefCell::default(),
            due: RefCell::default(),
            hits: Cell::new(0),
            last_words: Cell::new(random.below(4)),
            over: Cell::new(None),
            given_up: Cell::new(false),
            random: RefCell::new(random),
        }
    }

    /// Until when a process stands still, if it does now.
    pub fn still_until(&self, process: ProcessId) -> Option<Nanos> {
        let case = self.case?;
        let (Injected::Kill(who) | Injected::Stall(who, _)) = case.injected else { return None };
        let stands = who == process && case.is_at_work(self.now.get() / self.step);
        stands.then(|| {
            self.hits.set(self.hits.get() + 1);
            case.end().saturating_mul(self.step)
        })
    }

    /// Whether a process says something now: one that is killed falls silent between any two messages of a step.
    pub fn speaks(&self, process: ProcessId) -> bool {
        let Some(Case { injected: Injected::Kill(who), at, .. }) = self.case else { return true };
        if who != process || self.now.get() / self.step < at {
            return true;
        }
        let left = self.last_words.get();
        self.last_words.set(left.saturating_sub(1));
        left > 0
    }

    /// Whether the trial's process is one that is killed.
    pub fn kills(&self, process: ProcessId) -> bool {
        matches!(self.case, Some(Case { injected: Injected::Kill(who), .. }) if who == process)
    }

    /// Notes that a message for a place is kept back until then.
    pub fn wake_at(&self, place: usize, time: Nanos) {
        let due = &mut self.due.borrow_mut()[place];
        *due = time.min(*due);
    }
}
