//! What all that a trial surrounds a cell with has in common: the case, the time, who lives.

use core::cell::{Cell, RefCell};

use super::case::{Case, Channel, Injected, LinkFault};
use super::forks::Forks;
use super::random::Random;
use mrroc_core::fault::ProcessId;
use mrroc_core::link::Nanos;

/// How long a trial goes on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lasting {
    /// What the robots are watched for after the MP's program is over, or gone \[steps\].
    pub afterwards: u64,
    /// After so many steps a trial is given up: it does not end.
    pub most: u64,
    /// After so many steps a trial that goes on has been watched for long enough.
    pub watched: u64,
}

/// A run of a cell with a fault.
pub(super) struct Stage {
    pub case: Cell<Option<Case>>,
    pub step: Nanos,
    pub lasting: Cell<Lasting>,
    /// Cases that are to go on from copies of this run.
    pub forks: RefCell<Forks>,
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
    /// Whether it was not watched to its end.
    pub cut: Cell<bool>,
    pub random: RefCell<Random>,
}

pub(super) const NEVER: Nanos = Nanos::MAX;

impl Stage {
    pub fn new(case: Option<Case>, step: Nanos, lasting: Lasting) -> Stage {
        let stage = Stage {
            case: Cell::new(None),
            step: step.max(1),
            lasting: Cell::new(lasting),
            forks: RefCell::default(),
            now: Cell::new(0),
            processes: RefCell::default(),
            channels: RefCell::default(),
            due: RefCell::default(),
            hits: Cell::new(0),
            last_words: Cell::new(0),
            over: Cell::new(None),
            given_up: Cell::new(false),
            cut: Cell::new(false),
            random: RefCell::new(Random::new(0)),
        };
        if let Some(case) = case {
            stage.begin(case);
        }
        stage
    }

    /// From now on the run is this case's.
    fn begin(&self, case: Case) {
        let mut random = Random::new(case.seed);
        self.last_words.set(random.below(4));
        *self.random.borrow_mut() = random;
        self.case.set(Some(case));
    }

    /// Copies the run for each case that begins soon; in a copy, begins its case.
    pub fn fork(&self) {
        let begun = self.forks.borrow_mut().fork(self.now.get() / self.step);
        if let Some((case, lasting)) = begun {
            self.begin(case);
            self.lasting.set(lasting);
        }
    }

    /// What is done to the messages of a channel, if anything ever is.
    pub fn fault_of(&self, channel: Channel) -> Option<LinkFault> {
        match self.case.get() {
            Some(Case { injected: Injected::Link(at, fault, _), .. }) if at == channel => Some(fault),
            _ => None,
        }
    }

    /// Whether messages of a channel may be sent once more.
    pub fn remembers(&self, channel: Channel) -> bool {
        self.fault_of(channel) == Some(LinkFault::Replay) || self.forks.borrow().replay()
    }

    /// Until when a process stands still, if it does now.
    pub fn still_until(&self, process: ProcessId) -> Option<Nanos> {
        let case = self.case.get()?;
        let (Injected::Kill(who) | Injected::Stall(who, _)) = case.injected else { return None };
        let stands = who == process && case.is_at_work(self.now.get() / self.step);
        stands.then(|| {
            self.hits.set(self.hits.get() + 1);
            case.end().saturating_mul(self.step)
        })
    }

    /// Whether a process says something now: one that is killed falls silent between any two messages of a step.
    pub fn speaks(&self, process: ProcessId) -> bool {
        let Some(Case { injected: Injected::Kill(who), at, .. }) = self.case.get() else { return true };
        if who != process || self.now.get() / self.step < at {
            return true;
        }
        let left = self.last_words.get();
        self.last_words.set(left.saturating_sub(1));
        left > 0
    }

    /// Whether the trial's process is one that is killed.
    pub fn kills(&self, process: ProcessId) -> bool {
        matches!(self.case.get(), Some(Case { injected: Injected::Kill(who), .. }) if who == process)
    }

    /// Notes that a message for a place is kept back until then.
    pub fn wake_at(&self, place: usize, time: Nanos) {
        let due = &mut self.due.borrow_mut()[place];
        *due = time.min(*due);
    }
}
