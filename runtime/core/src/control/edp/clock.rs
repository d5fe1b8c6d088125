//! When the steps and servo periods of an EDP begin, and how late it is for them.
//!
//! In: the time, and what a robot that paces itself says. Out: what begins next; the steps and servo periods that were missed.

use core::time::Duration;

use crate::control::overruns::{Overruns, periods_in};
use crate::model::fault::Fault;
use crate::model::pace::{Pace, Pulse};
use crate::model::time::Nanos;

use super::phase_lock::PhaseLock;

/// The steps and servo periods of an EDP.
pub(super) struct ServoClock {
    /// Index of the first step that has not begun here.
    pub due: u64,
    /// When it begins \[ns\].
    pub next_step: Nanos,
    /// When the next servo period begins, or when to ask the robot whether it has \[ns\].
    pub next_tick: Nanos,
    /// Length of a step \[ns\].
    step_period: Nanos,
    /// Length of a servo period \[ns\].
    servo_period: Nanos,
    /// Of a robot that says when its servo periods begin.
    lock: Option<PhaseLock>,
    overruns: Overruns,
    /// For how many periods the last step was late.
    behind: u64,
    /// Whether the last servo period was over before it could begin.
    pub left_out: bool,
}

/// A servo period.
#[derive(Clone, Copy)]
pub(super) struct Period {
    /// When it begins \[ns\].
    pub begins: Nanos,
    /// When it ends \[ns\].
    pub ends: Nanos,
    /// Periods of the robot before it that were not seen.
    pub lost: u64,
    /// How late its beginning was noticed \[ns\].
    pub late: Nanos,
}

impl ServoClock {
    /// From `now` on.
    pub fn new(now: Nanos, step_period: Duration, servo_period: Duration, pace: Pace) -> Self {
        let overruns = Overruns::new(step_period);
        let lock = match pace {
            Pace::Cell => None,
            Pace::Robot { timeout } => Some(PhaseLock::new(now, servo_period, timeout)),
        };
        let step_period = step_period.as_nanos() as Nanos;
        let servo_period = servo_period.as_nanos() as Nanos;
        let shorter = servo_period.min(step_period);
        // Half a period after multiples of the period.
        let due = (now + step_period - shorter / 2).div_ceil(step_period.max(1)).saturating_sub(1);
        let tick = now.saturating_sub(servo_period / 2).div_ceil(servo_period.max(1));
        let next_tick = tick * servo_period + servo_period / 2;
        ServoClock {
            due,
            next_step: due * step_period + shorter / 2,
            next_tick: lock.as_ref().map_or(next_tick, |lock| lock.next_look(now)),
            step_period,
            servo_period,
            lock,
            overruns,
            behind: 0,
            left_out: false,
        }
    }

    /// When the next step or servo period begins \[ns\].
    #[inline]
    pub fn next(&self) -> Nanos {
        self.next_step.min(self.next_tick)
    }

    /// Length of a servo period \[ns\].
    pub const fn servo_period(&self) -> Nanos {
        self.servo_period
    }

    /// The step at a time.
    #[inline]
    pub fn step_at(&self, time: Nanos) -> u64 {
        time / self.step_period.max(1)
    }

    /// Counts how late the next step is, if that `counts`. To be late is one cause, however many steps are made up for at
    /// once.
    ///
    /// # Errors
    /// `Overrun` when too many steps were late.
    #[inline]
    pub fn count_late_step(&mut self, now: Nanos, counts: bool) -> Result<(), Fault> {
        let missed = periods_in(now.saturating_sub(self.next_step), self.step_period);
        let goes_on = missed + 1 == core::mem::replace(&mut self.behind, missed);
        if goes_on || !counts {
            return Ok(());
        }
        self.overruns.note(missed)
    }

    /// The next step has begun.
    pub const fn end_step(&mut self) {
        self.next_step += self.step_period;
    }

    /// Whether the robot says when its servo periods begin.
    pub const fn is_paced_by_robot(&self) -> bool {
        self.lock.is_some()
    }

    /// The next servo period by the cell's clock; `None` if it is over before it could begin.
    #[inline]
    pub fn next_period(&mut self, now: Nanos) -> Option<Period> {
        let begins = self.next_tick;
        self.next_tick += self.servo_period;
        self.left_out = now >= self.next_tick;
        let late = now.saturating_sub(begins);
        (!self.left_out).then_some(Period { begins, ends: self.next_tick, lost: 0, late })
    }

    /// The servo period that the robot has told by `now`, if it has.
    pub fn told_period(&mut self, now: Nanos, pulse: Option<Pulse>) -> Option<Period> {
        let lock = self.lock.as_mut()?;
        let began = pulse.and_then(|pulse| lock.hear(now, pulse));
        self.next_tick = lock.next_look(now);
        self.left_out = began.is_none();
        let began = began?;
        Some(Period { begins: began.at, ends: began.end, lost: began.lost, late: began.age })
    }

    /// For how long the robot has said nothing, if that is too long \[ns\].
    pub fn silent_for(&self, now: Nanos) -> Option<Nanos> {
        self.lock.as_ref().and_then(|lock| lock.silent_for(now))
    }

    /// As if no step had been late, and no servo period told: after a reset.
    pub fn forget(&mut self, now: Nanos) {
        self.overruns.forget();
        if let Some(lock) = &mut self.lock {
            lock.forget(now);
            self.next_tick = lock.next_look(now);
        }
    }
}
