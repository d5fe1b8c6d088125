//! How a process waits.
//!
//! In: wake-ups, deadlines, and what the launcher says. Out: a wait that ends at the next of them: in real time a sleep
//! on the process's futex, in lock-step a wait for the launcher to resume the process.

use core::cell::Cell;
use core::num::NonZeroU64;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::mpsc::Receiver;

use rustix::thread::{ClockId, clock_nanosleep_absolute};

use super::samples::Samples;
use super::wake_futex::{NANOS, WakeFutex, timespec};
use mrroc_core::link::places::Places;
use mrroc_core::link::{Closed, Host, Meter, Nanos, News, Nothing, Notices, Sample, StopBoard, Waiter};
use mrroc_core::operator::button::Button;
use mrroc_core::operator::console::Console;
use mrroc_core::operator::state::{EcpState, EdpState, MpState, VspState};

/// The machine's monotonic time \[ns\].
pub(crate) fn monotonic() -> Nanos {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    // The clock counts from the start of the machine, so neither part is negative.
    now.tv_sec.cast_unsigned() * NANOS + now.tv_nsec.cast_unsigned()
}

/// The launcher, as a process in lock-step sees it: it decides when the process runs.
pub(crate) trait Launcher {
    /// Waits for what the launcher says.
    fn hear(&self) -> LauncherMessage;

    /// Tells the launcher that the process waits, at most until `deadline` \[ns\], and has sent messages to the places
    /// `woken`.
    fn yields(&self, deadline: Nanos, woken: Places);

    /// Asks the launcher to run the process at `place` before this process goes on; this process has sent messages to
    /// the places `woken`.
    fn calls(&self, place: usize, woken: Places);
}

/// What a launcher says to a process that runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LauncherMessage {
    /// Go on; the time is now this \[ns\].
    Resume(Nanos),
    /// A process is gone, or the operator aborts.
    News(News),
    /// The operator has pressed a button; the answer is shown under this number.
    Press(u64, Button),
    /// The cell closes, or the launcher is gone.
    Close,
}

/// Waits in real time: sleeps until it is woken, or until a deadline.
pub(crate) struct RealTime {
    wake_futex: WakeFutex,
    /// Number of wake-ups that the process has seen.
    wakes: Cell<u32>,
    /// What the launcher says. Each message comes with a wake-up.
    heard: Receiver<LauncherMessage>,
    /// When the cell's time began, on the machine's clock \[ns\].
    origin: Nanos,
    /// By how much that has moved since, on a node that follows another machine.
    slew: Option<Slew>,
    /// The newest time that was told: it never goes back.
    told: Cell<Nanos>,
    /// How long to poll before sleeping \[ns\].
    spin: Nanos,
    outside: Outside,
    samples: Arc<Samples>,
    supervised: Option<Supervised>,
}

/// What the launcher has said, until the process takes it; and who is shown what the process does.
#[derive(Default)]
struct Outside {
    closing: Cell<bool>,
    news: Cell<Option<News>>,
    /// The press of each kind that was not taken yet; a newer press replaces it.
    pressed: [Cell<Option<(u64, Button)>>; Button::KINDS],
    shows: Option<Shows>,
    /// The stops on the state board, in a process that looks at them.
    stops: Option<Rc<dyn StopBoard>>,
}

impl Outside {
    /// All of it: who is shown what the process does, and the stops on the state board.
    fn new(shows: Option<Shows>, stops: Option<Rc<dyn StopBoard>>) -> Outside {
        Outside { shows, stops, ..Outside::default() }
    }

    /// The stops on the state board; none in a process that does not look at them.
    fn stops(&self) -> &dyn StopBoard {
        self.stops.as_deref().unwrap_or(&Nothing)
    }

    /// Keeps it. Returns the time at which the process is to go on, if that is what was said \[ns\].
    fn hear(&self, heard: LauncherMessage) -> Option<Nanos> {
        match heard {
            LauncherMessage::Resume(now) => return Some(now),
            LauncherMessage::Close => self.closing.set(true),
            // An abort must not replace the news that a process is gone.
            LauncherMessage::News(News::Abort) if self.news.get().is_some() => {}
            LauncherMessage::News(news) => self.news.set(Some(news)),
            LauncherMessage::Press(number, button) => self.pressed[button.kind()].set(Some((number, button))),
        }
        None
    }

    /// Whether the cell is still open.
    fn open(&self) -> Result<(), Closed> {
        if self.closing.get() { Err(Closed) } else { Ok(()) }
    }
}

impl Console for Outside {
    fn pressed(&self, kind: usize) -> Option<(u64, Button)> {
        self.pressed.get(kind)?.take()
    }

    fn show(&self, state: &MpState) {
        if let Some(Shows::Mp(shows)) = &self.shows {
            shows(state);
        }
    }

    fn show_ecp(&self, state: &EcpState) {
        if let Some(Shows::Ecp(shows)) = &self.shows {
            shows(state);
        }
    }

    fn show_edp(&self, state: &EdpState<'_>) {
        if let Some(Shows::Edp(shows)) = &self.shows {
            shows(state);
        }
    }

    fn show_vsp(&self, state: &VspState<'_>) {
        if let Some(Shows::Vsp(shows)) = &self.shows {
            shows(state);
        }
    }
}

/// What shows the state of a process.
pub(crate) enum Shows {
    /// Of an MP.
    Mp(Box<dyn Fn(&MpState)>),
    /// Of an ECP.
    Ecp(Box<dyn Fn(&EcpState)>),
    /// Of an EDP.
    Edp(Box<dyn Fn(&EdpState<'_>)>),
    /// Of a VSP.
    Vsp(Box<dyn Fn(&VspState<'_>)>),
}

/// What tells an MP, at a time of the machine's clock \[ns\], whether its launcher supervises the cell.
pub(crate) type Supervised = Box<dyn Fn(Nanos) -> bool>;

/// What tells by how much the cell's time has moved \[ns\].
pub(crate) type Slew = Box<dyn Fn() -> i64>;

impl RealTime {
    pub fn new(
        wake_futex: WakeFutex,
        heard: Receiver<LauncherMessage>,
        (origin, spin): (Nanos, Nanos),
        samples: Arc<Samples>,
    ) -> Self {
        // The usual slack of 50 us would make steps late. If the slack cannot be changed, sleeps end only a little
        // later.
        let _ = rustix::thread::set_current_timer_slack(NonZeroU64::new(1));
        RealTime {
            wake_futex,
            wakes: Cell::new(0),
            heard,
            origin,
            slew: None,
            told: Cell::new(0),
            spin,
            outside: Outside::default(),
            samples,
            supervised: None,
        }
    }

    /// Lets the process show its state by `shows`, and see the stops on the state board.
    pub fn showing(mut self, shows: Option<Shows>, stops: Option<Rc<dyn StopBoard>>) -> Self {
        self.outside = Outside::new(shows, stops);
        self
    }

    /// Lets the MP know by `supervised` whether its launcher supervises the cell.
    pub fn supervised_by(mut self, supervised: Option<Supervised>) -> Self {
        self.supervised = supervised;
        self
    }

    /// Lets the cell's time move by `slew`.
    pub fn slewed_by(mut self, slew: Option<Slew>) -> Self {
        self.slew = slew;
        self
    }

    /// A time of the cell, on the machine's clock.
    fn on_clock(&self, time: Nanos) -> Nanos {
        self.origin.saturating_add(time).saturating_add_signed(self.slew.as_ref().map_or(0, |slew| slew()))
    }

    /// All that the link offers to a process.
    pub fn host(&self) -> Host<'_> {
        Host { waiter: self, meter: self, notices: self, stops: self.outside.stops(), console: &self.outside }
    }

    /// Whether the process was woken since the last call.
    fn was_woken(&self) -> bool {
        let wakes = self.wake_futex.wakes();
        self.wakes.replace(wakes) != wakes
    }

    /// Takes all that the launcher has said.
    fn hear(&self) {
        while let Ok(heard) = self.heard.try_recv() {
            self.outside.hear(heard);
        }
    }
}

impl Waiter for RealTime {
    fn now(&self) -> Nanos {
        let Some(slew) = &self.slew else { return monotonic().saturating_sub(self.origin) };
        let now = monotonic().saturating_sub(self.origin).saturating_add_signed(-slew());
        self.told.set(self.told.get().max(now));
        self.told.get()
    }

    fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
        if !self.outside.closing.get() && !self.was_woken() {
            if self.spin > 0 {
                let until = deadline.unwrap_or(Nanos::MAX).min(self.now().saturating_add(self.spin));
                while self.now() < until && self.wake_futex.wakes() == self.wakes.get() {
                    core::hint::spin_loop();
                }
            }
            self.wake_futex.sleep(self.wakes.get(), deadline.map(|deadline| self.on_clock(deadline)));
            self.was_woken();
        }
        self.hear();
        self.outside.open()
    }

    fn wait_closing(&self, until: Nanos) -> Result<(), Closed> {
        // The sum is a time of the machine's clock: `origin` is one, and `until` counts from it.
        let until = timespec(self.on_clock(until));
        let _ = clock_nanosleep_absolute(ClockId::Monotonic, &until);
        Ok(())
    }
}

impl Meter for RealTime {
    fn sample(&self, sample: Sample) {
        self.samples.push(sample);
    }
}

impl Notices for RealTime {
    fn news(&self) -> Option<News> {
        self.outside.news.take()
    }

    fn is_supervised(&self) -> bool {
        self.supervised.as_ref().is_none_or(|supervised| supervised(monotonic()))
    }
}

/// Waits in lock-step: the launcher resumes one process at a time and tells it the time.
pub(crate) struct LockStep<'a, L: Launcher> {
    launcher: &'a L,
    woken: Rc<Cell<Places>>,
    now: Cell<Nanos>,
    outside: Outside,
}

impl<'a, L: Launcher> LockStep<'a, L> {
    /// Waits to be resumed for the first time. The process shows its state by `shows`, and sees the stops on the state board.
    pub fn new(
        launcher: &'a L,
        woken: Rc<Cell<Places>>,
        shows: Option<Shows>,
        stops: Option<Rc<dyn StopBoard>>,
    ) -> Self {
        let outside = Outside::new(shows, stops);
        let waiter = LockStep { launcher, woken, now: Cell::new(0), outside };
        waiter.be_resumed();
        waiter
    }

    /// All that the link offers to a process. In lock-step nothing is late, so there is nothing to measure.
    pub fn host(&self) -> Host<'_> {
        Host { notices: self, stops: self.outside.stops(), console: &self.outside, ..Host::of(self) }
    }

    /// Waits until the launcher lets the process go on, and keeps what it says before that.
    fn be_resumed(&self) {
        while !self.outside.closing.get() {
            if let Some(now) = self.outside.hear(self.launcher.hear()) {
                return self.now.set(now);
            }
        }
    }
}

impl<L: Launcher> Waiter for LockStep<'_, L> {
    fn now(&self) -> Nanos {
        self.now.get()
    }

    fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
        let deadline = deadline.unwrap_or(Nanos::MAX);
        if deadline > self.now.get() && !self.outside.closing.get() {
            self.launcher.yields(deadline, self.woken.take());
            self.be_resumed();
        }
        self.outside.open()
    }

    fn call(&self, place: usize) -> Result<(), Closed> {
        if !self.outside.closing.get() {
            self.launcher.calls(place, self.woken.take().without(place));
            self.be_resumed();
        }
        self.outside.open()
    }
}

impl<L: Launcher> Notices for LockStep<'_, L> {
    fn news(&self) -> Option<News> {
        self.outside.news.take()
    }
}
