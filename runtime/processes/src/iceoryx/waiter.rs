//! How a process waits: in real time on its futex, or in lock-step for the launcher to resume it.

use core::cell::Cell;
use core::num::NonZeroU64;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::mpsc::Receiver;

use rustix::thread::{ClockId, clock_nanosleep_absolute};
use rustix::time::Timespec;

use super::samples::Samples;
use super::wake_futex::WakeFutex;
use mrroc_core::link::{Closed, Host, Meter, Nanos, News, Notices, Sample, Waiter};
use mrroc_core::operator::button::Button;
use mrroc_core::operator::console::Console;
use mrroc_core::operator::state::MpState;

const NANOS: u64 = 1_000_000_000;

/// The machine's monotonic time \[ns\].
pub(crate) fn monotonic() -> Nanos {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    // The clock counts from the start of the machine: neither part is negative.
    now.tv_sec.cast_unsigned() * NANOS + now.tv_nsec.cast_unsigned()
}

pub(super) fn timespec(nanos: Nanos) -> Timespec {
    Timespec { tv_sec: (nanos / NANOS).cast_signed(), tv_nsec: (nanos % NANOS).cast_signed() }
}

/// The launcher's side of a process in lock-step: it says when the process runs.
pub(crate) trait Launcher {
    /// What it says; waits for it.
    fn hear(&self) -> Heard;

    /// In lock-step: the process waits, and sent messages to these places.
    fn yields(&self, deadline: Nanos, woken: u64);

    /// In lock-step: the process at a place is to run before this one goes on, which sent messages to these places.
    fn calls(&self, place: usize, woken: u64);
}

/// What a launcher says to a process that runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Heard {
    /// Run on; it is now this time \[ns\].
    Resume(Nanos),
    /// Something has happened.
    News(News),
    /// The operator has pressed a button, under this number.
    Press(u64, Button),
    /// The cell closes, or the launcher is gone.
    Close,
}

/// Waits in real time: sleeps until it is woken, or until a deadline.
pub(crate) struct RealTime {
    wake_futex: WakeFutex,
    /// Wake-ups that it has seen.
    wakes: Cell<u32>,
    /// What the launcher says. It comes with a wake-up.
    heard: Receiver<Heard>,
    /// When the cell's time began, on the machine's clock, and for how long to listen before sleeping \[ns\].
    origin: Nanos,
    spin: Nanos,
    closing: Cell<bool>,
    news: Cell<Option<News>>,
    samples: Arc<Samples>,
    /// One press of each kind: a newer one replaces it.
    pressed: [Cell<Option<(u64, Button)>>; Button::KINDS],
    shows: Option<Show>,
}

/// What shows the state of an MP.
pub(crate) type Show = Box<dyn Fn(&MpState)>;

impl RealTime {
    pub fn new(
        wake_futex: WakeFutex,
        heard: Receiver<Heard>,
        (origin, spin): (Nanos, Nanos),
        samples: Arc<Samples>,
    ) -> Self {
        // A sleep that ends 50 us late is a late step. Without it, it is only a little later.
        let _ = rustix::thread::set_current_timer_slack(NonZeroU64::new(1));
        RealTime {
            wake_futex,
            wakes: Cell::new(0),
            heard,
            origin,
            spin,
            closing: Cell::new(false),
            news: Cell::new(None),
            samples,
            pressed: Default::default(),
            shows: None,
        }
    }

    /// Shows what the MP does by this.
    pub fn showing(mut self, shows: Option<Show>) -> Self {
        self.shows = shows;
        self
    }

    /// All that a process has of the link.
    pub fn host(&self) -> Host<'_> {
        Host { waiter: self, meter: self, notices: self, console: self }
    }

    /// Whether the process was woken since this was asked last.
    fn was_woken(&self) -> bool {
        let wakes = self.wake_futex.wakes();
        self.wakes.replace(wakes) != wakes
    }

    /// Takes what the launcher has said.
    fn hear(&self) {
        while let Ok(heard) = self.heard.try_recv() {
            match heard {
                Heard::Close => self.closing.set(true),
                // An abort must not hide that a process is gone.
                Heard::News(News::Abort) if self.news.get().is_some() => {}
                Heard::News(news) => self.news.set(Some(news)),
                Heard::Press(number, button) => self.pressed[button.kind()].set(Some((number, button))),
                Heard::Resume(_) => {}
            }
        }
    }
}

impl Waiter for RealTime {
    fn now(&self) -> Nanos {
        monotonic().saturating_sub(self.origin)
    }

    fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
        if !self.closing.get() && !self.was_woken() {
            if self.spin > 0 {
                let until = deadline.unwrap_or(Nanos::MAX).min(self.now().saturating_add(self.spin));
                while self.now() < until && self.wake_futex.wakes() == self.wakes.get() {
                    core::hint::spin_loop();
                }
            }
            self.wake_futex
                .sleep(self.wakes.get(), deadline.map(|deadline| self.origin.saturating_add(deadline)));
            self.was_woken();
        }
        self.hear();
        if self.closing.get() { Err(Closed) } else { Ok(()) }
    }

    fn wait_closing(&self, until: Nanos) -> Result<(), Closed> {
        // The start of the cell's time and a time of it are both nanoseconds of this machine.
        let until = timespec(self.origin.saturating_add(until));
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
        self.news.take()
    }
}

impl Console for RealTime {
    fn pressed(&self, kind: usize) -> Option<(u64, Button)> {
        self.pressed.get(kind)?.take()
    }

    fn show(&self, state: &MpState) {
        if let Some(shows) = &self.shows {
            shows(state);
        }
    }
}

/// Waits in lock-step: the launcher resumes one process at a time, and says what time it is.
pub(crate) struct LockStep<'a, L: Launcher> {
    launcher: &'a L,
    woken: Rc<Cell<u64>>,
    now: Cell<Nanos>,
    closing: Cell<bool>,
}

impl<'a, L: Launcher> LockStep<'a, L> {
    /// Waits to be resumed for the first time.
    pub fn new(launcher: &'a L, woken: Rc<Cell<u64>>) -> Self {
        let waiter = LockStep { launcher, woken, now: Cell::new(0), closing: Cell::new(false) };
        waiter.be_resumed();
        waiter
    }

    fn be_resumed(&self) {
        match self.launcher.hear() {
            Heard::Resume(now) => self.now.set(now),
            // In lock-step nothing else is said.
            Heard::Close | Heard::News(_) | Heard::Press(..) => self.closing.set(true),
        }
    }
}

impl<L: Launcher> Waiter for LockStep<'_, L> {
    fn now(&self) -> Nanos {
        self.now.get()
    }

    fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
        let deadline = deadline.unwrap_or(Nanos::MAX);
        if deadline > self.now.get() && !self.closing.get() {
            self.launcher.yields(deadline, self.woken.take());
            self.be_resumed();
        }
        if self.closing.get() { Err(Closed) } else { Ok(()) }
    }

    fn call(&self, place: usize) -> Result<(), Closed> {
        if !self.closing.get() {
            self.launcher.calls(place, self.woken.take() & !(1 << place));
            self.be_resumed();
        }
        if self.closing.get() { Err(Closed) } else { Ok(()) }
    }
}
