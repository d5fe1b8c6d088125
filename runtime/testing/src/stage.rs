//! The state that a trial's decorators share: the case, the time, and which processes stand still.

use core::cell::{Cell, RefCell};

use super::case::{Case, Channel, Injected, LinkFault};
use super::forks::{Forks, Lasting};
use super::random::Random;
use mrroc_core::fault::{ProcessId, Role};
use mrroc_core::link::Nanos;

/// A run of a cell with a fault.
pub(super) struct Stage {
    pub case: Cell<Option<Case>>,
    pub step: Nanos,
    pub lasting: Cell<Lasting>,
    /// The cases that go on from copies of this run.
    pub forks: RefCell<Forks>,
    /// The time when a process woke last, which is the present time, because the virtual clock stands between wake-ups
    /// \[ns\].
    pub now: Cell<Nanos>,
    /// The processes, by their places.
    pub processes: RefCell<Vec<ProcessId>>,
    pub channels: RefCell<Vec<Channel>>,
    /// When the next message that a channel delays is due, for each place \[ns\].
    pub due: RefCell<Vec<Nanos>>,
    /// How often the fault was applied.
    pub hits: Cell<u64>,
    /// How many messages a killed process still sends in its last step.
    last_words: Cell<u64>,
    /// When the MP's program was over \[ns\].
    pub over: Cell<Option<Nanos>>,
    pub given_up: Cell<bool>,
    /// Whether the run was cut before its end.
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

    /// Makes this run the run of `case`.
    fn begin(&self, case: Case) {
        let mut random = Random::new(case.seed);
        self.last_words.set(random.below(4));
        *self.random.borrow_mut() = random;
        self.case.set(Some(case));
    }

    /// Copies the run for each case that begins soon; a copy begins its case.
    pub fn fork(&self) {
        let begun = self.forks.borrow_mut().fork(self.now.get() / self.step);
        if let Some((case, lasting)) = begun {
            self.begin(case);
            self.lasting.set(lasting);
        }
    }

    /// What the case does to the messages of a channel, if anything.
    pub fn fault_of(&self, channel: Channel) -> Option<LinkFault> {
        match self.case.get()?.injected {
            Injected::Link(at, fault, _) if at == channel => Some(fault),
            Injected::Apart(whom, wire, _) => {
                let Channel { from, to } = channel;
                let is_apart = |a: ProcessId, b: ProcessId| {
                    a == ProcessId::MP && b.role == Role::Ecp && (whom.is_none() || b.name == whom)
                };
                (is_apart(from, to) || is_apart(to, from)).then_some(LinkFault::Wire(wire))
            }
            _ => None,
        }
    }

    /// Whether messages of a channel may be sent a second time.
    pub fn remembers(&self, channel: Channel) -> bool {
        self.fault_of(channel) == Some(LinkFault::Replay) || self.forks.borrow().replay()
    }

    /// Until when a process stands still \[ns\], if it stands still now.
    pub fn still_until(&self, process: ProcessId) -> Option<Nanos> {
        let case = self.case.get()?;
        let (Injected::Kill(who) | Injected::Stall(who, _)) = case.injected else { return None };
        let stands = who == process && case.is_at_work(self.now.get() / self.step);
        stands.then(|| {
            self.hits.set(self.hits.get() + 1);
            case.end().saturating_mul(self.step)
        })
    }

    /// Whether a process sends something now: a killed process may end between any two messages of a step.
    pub fn speaks(&self, process: ProcessId) -> bool {
        let Some(Case { injected: Injected::Kill(who), at, .. }) = self.case.get() else { return true };
        if who != process || self.now.get() / self.step < at {
            return true;
        }
        let left = self.last_words.get();
        self.last_words.set(left.saturating_sub(1));
        left > 0
    }

    /// Whether the case kills this process.
    pub fn kills(&self, process: ProcessId) -> bool {
        matches!(self.case.get(), Some(Case { injected: Injected::Kill(who), .. }) if who == process)
    }

    /// Notes that a message for a place is delayed until `time` \[ns\].
    pub fn wake_at(&self, place: usize, time: Nanos) {
        let due = &mut self.due.borrow_mut()[place];
        *due = time.min(*due);
    }
}
