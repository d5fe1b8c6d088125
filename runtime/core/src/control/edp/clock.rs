//! When the steps and servo periods of an EDP begin, and how late it is for them.
//!
//! In: the time. Out: what begins next; the steps and servo periods that were missed.

use core::time::Duration;

use crate::control::overruns::Overruns;
use crate::model::fault::Fault;
use crate::model::time::Nanos;

/// The steps and servo periods of an EDP.
pub(super) struct ServoClock {
    /// Index of the first step that has not begun here.
    pub due: u64,
    /// When it begins \[ns\].
    pub next_step: Nanos,
    /// When the next servo period begins \[ns\].
    pub next_tick: Nanos,
    /// Length of a step \[ns\].
    step_period: Nanos,
    /// Length of a servo period \[ns\].
    servo_period: Nanos,
    overruns: Overruns,
    /// For how many periods the last step was late.
    behind: u64,
    /// Whether the last servo period was over before it could begin.
    pub left_out: bool,
}

impl ServoClock {
    /// From `now` on.
    pub fn new(now: Nanos, step_period: Duration, servo_period: Duration) -> Self {
        let overruns = Overruns::new(step_period);
        let step_period = step_period.as_nanos() as Nanos;
        let servo_period = servo_period.as_nanos() as Nanos;
        let shorter = servo_period.min(step_period);
        // Half a period after multiples of the period.
        let due = (now + step_period - shorter / 2).div_ceil(step_period.max(1)).saturating_sub(1);
        let tick = now.saturating_sub(servo_period / 2).div_ceil(servo_period.max(1));
        ServoClock {
            due,
            next_step: due * step_period + shorter / 2,
            next_tick: tick * servo_period + servo_period / 2,
            step_period,
            servo_period,
            overruns,
            behind: 0,
            left_out: false,
        }
    }

    /// When the next step or servo period begins \[ns\].
    pub fn next(&self) -> Nanos {
        self.next_step.min(self.next_tick)
    }

    /// Length of a servo period \[ns\].
    pub const fn servo_period(&self) -> Nanos {
        self.servo_period
    }

    /// The step at a time.
    pub fn step_at(&self, time: Nanos) -> u64 {
        time / self.step_period.max(1)
    }

    /// Counts how late the next step is, if that `counts`. To be late is one cause, however many steps are made up for at
    /// once.
    ///
    /// # Errors
    /// `Overrun` when too many steps were late.
    pub fn count_late_step(&mut self, now: Nanos, counts: bool) -> Result<(), Fault> {
        let missed = now.saturating_sub(self.next_step) / self.step_period.max(1);
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

    /// Whether the next servo period is over before it could begin.
    pub const fn misses_tick(&mut self, now: Nanos) -> bool {
        self.left_out = now >= self.next_tick + self.servo_period;
        self.left_out
    }

    /// The next servo period has begun, or was left out.
    pub const fn end_tick(&mut self) {
        self.next_tick += self.servo_period;
    }

    /// As if no step had been late: after a reset.
    pub fn forget_late_steps(&mut self) {
        self.overruns.forget();
    }
}
