//! The clock of the steps: when a step begins, how many periods it stands for, and how much path time it has.
//!
//! In: the time, the operator's wish, the robots' rate margins. Out: the step's index, its real duration and its path
//! time `dt`, which every order carries. Steps begin at multiples of the period; a late one skips indices and is
//! never replayed: its `duration` is the number of periods since the step before it. `dt = rate * duration`.

use core::time::Duration;

use crate::control::overruns::{Overruns, periods_in};
use crate::link::{Closed, Meter, Sample, Waiter};
use crate::model::fault::Fault;
use crate::model::step::Tick;
use crate::model::time::Nanos;
use crate::safety::rate::Feed;
use crate::safety::stopping::together_budget;

/// The steps of a cell.
pub(super) struct StepClock {
    period: Nanos,
    /// Time into a step after which its demands would come too late for the EDPs' ticks \[ns\].
    grace: Nanos,
    /// Missed steps that robots which move together go on for.
    together: u64,
    /// Index of the step that has begun, and whether it has been used up.
    step: u64,
    used: bool,
    /// The first step that may begin next: in a replay those that were skipped are skipped again.
    earliest: u64,
    /// Real time and path time of the step \[s\].
    duration: f64,
    dt: f64,
    /// Whether the operator had suspended the cell when the step began.
    suspended: bool,
    /// The rate at which path time passes.
    pub feed: Feed,
    /// Steps that were late because of the MP itself.
    overruns: Overruns,
}

impl StepClock {
    pub fn new(period: Duration, grace: Nanos, feed: Feed) -> Self {
        let overruns = Overruns::new(period);
        let together = u64::from(together_budget(period));
        let period = period.as_nanos() as Nanos;
        let duration = period as f64 * 1e-9;
        StepClock {
            period,
            grace,
            together,
            step: 0,
            used: true,
            earliest: 0,
            duration,
            dt: duration,
            suspended: false,
            feed,
            overruns,
        }
    }

    /// Length of a step \[ns\].
    pub fn period(&self) -> Nanos {
        self.period.max(1)
    }

    /// Index of the step that has begun.
    pub const fn step(&self) -> u64 {
        self.step
    }

    /// When robots that move together and have missed their orders from this step on begin to brake.
    pub fn together_until(&self) -> Nanos {
        (self.step + self.together) * self.period()
    }

    /// Steps in a time.
    pub fn steps_of(&self, time: Duration) -> u64 {
        time.as_nanos() as Nanos / self.period
    }

    /// Real time of the step \[s\].
    pub const fn duration(&self) -> f64 {
        self.duration
    }

    /// Path time of the step \[s\].
    pub const fn dt(&self) -> f64 {
        self.dt
    }

    /// Whether the cell is suspended in this step: speed 0 is no suspension.
    pub const fn is_suspended(&self) -> bool {
        self.suspended
    }

    /// Whether path time stands still.
    pub fn is_standing(&self) -> bool {
        self.dt == 0.0
    }

    /// The time of a step function's step.
    pub const fn tick(&self, step: u64) -> Tick {
        Tick { step, dt: self.dt, duration: self.duration }
    }

    /// The time of the first step of a motion from a standstill: no period of it can have been skipped.
    pub fn first_tick(&self) -> Tick {
        let duration = self.period as f64 * 1e-9;
        let dt = if self.is_standing() { 0.0 } else { self.feed.rate() * duration };
        Tick { step: 0, dt, duration }
    }

    /// An exchange takes place in this step, or it passes without one.
    pub const fn spend(&mut self) {
        self.used = true;
    }

    /// Whether nothing more may take place in this step.
    pub const fn is_spent(&self) -> bool {
        self.used
    }

    /// No step before this one begins.
    pub const fn not_before(&mut self, step: u64) {
        self.earliest = step;
    }

    /// Nothing moved in this step: what comes next may take place in it as well.
    pub const fn keep(&mut self) {
        self.used = false;
    }

    /// The same, unless it is too late in the step for that.
    pub fn keep_unless_late(&mut self, waiter: &dyn Waiter) {
        let now = waiter.now();
        self.used = now % self.period >= self.grace || now >= (self.step + 1) * self.period;
    }

    /// Counts the time that the MP itself took for the step before \[ns\].
    ///
    /// # Errors
    /// `Overrun` when too many steps were late because of it.
    pub fn count_own_time(&mut self, own_time: Nanos) -> Result<(), Fault> {
        self.overruns.note(periods_in(own_time, self.period))
    }

    /// As if no step had been late: after a reset.
    pub fn forget_late_steps(&mut self) {
        self.overruns.forget();
    }

    /// Waits for the beginning of a step, unless one has begun that nothing has used; whether one begins. Whenever it wakes it
    /// calls `woken`, for messages of others.
    pub fn begin(
        &mut self,
        waiter: &dyn Waiter,
        meter: &dyn Meter,
        mut woken: impl FnMut(),
    ) -> Result<bool, Closed> {
        if !self.used {
            return Ok(false);
        }
        let mut now = waiter.now();
        let mut next = (self.step + 1).max(self.earliest) * self.period;
        if now >= next && now % self.period >= self.grace {
            // Too late for this step as well.
            next = now - now % self.period + self.period;
        }
        while now < next {
            waiter.wait(Some(next))?;
            woken();
            now = waiter.now();
        }
        let step = now / self.period;
        let periods = step - self.step;
        meter.sample(Sample::Late(now - next));
        if periods > 1 {
            meter.sample(Sample::Skipped(periods - 1));
        }
        self.step = step;
        self.used = false;
        self.duration = periods as f64 * self.period as f64 * 1e-9;
        Ok(true)
    }

    /// The step's path time, while it changes to the rate that the operator wants.
    pub fn advance(&mut self, wanted_rate: f64, suspended: bool) {
        self.suspended = suspended;
        self.dt = self.feed.advance(wanted_rate, self.duration) * self.duration;
    }

    /// From a standstill a motion starts at the wanted rate.
    pub fn start(&mut self, wanted_rate: f64) {
        self.feed.reset(wanted_rate);
        self.dt = self.feed.rate() * self.duration;
    }

    /// The first step of a motion from a standstill: no period of it can have been skipped.
    pub fn count_from_here(&mut self) {
        self.duration = self.period as f64 * 1e-9;
        self.dt = self.feed.rate() * self.duration;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::Nothing;
    use core::cell::Cell;

    /// A clock that is where it is told to be, and then jumps to every deadline.
    struct Jumps(Cell<Nanos>);

    impl Waiter for Jumps {
        fn now(&self) -> Nanos {
            self.0.get()
        }
        fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
            self.0.set(deadline.ok_or(Closed)?);
            Ok(())
        }
    }

    #[test]
    fn a_late_step_counts_the_periods_that_it_skipped_and_begins_within_the_grace_or_at_the_next_one() {
        // Period 1000 ns, grace 500 ns: after step 3, at `now`, which step begins, and how many periods are it?
        for (now, step, periods) in
            [(3000, 4, 1), (3999, 4, 1), (4000, 4, 1), (4499, 4, 1), (4500, 5, 2), (5499, 5, 2), (5500, 6, 3)]
        {
            let waiter = Jumps(Cell::new(3000));
            let mut clock = StepClock::new(Duration::from_nanos(1000), 500, Feed::new(5.0));
            assert_eq!(clock.begin(&waiter, &Nothing, || ()), Ok(true));
            clock.spend();
            waiter.0.set(now);
            assert_eq!(clock.begin(&waiter, &Nothing, || ()), Ok(true));
            assert_eq!(clock.step(), step, "at {now}");
            assert!((clock.duration() - f64::from(periods) * 1e-6).abs() < 1e-18, "at {now}");
        }
    }

    #[test]
    fn a_step_that_was_kept_is_used_again() {
        let waiter = Jumps(Cell::new(0));
        let mut clock = StepClock::new(Duration::from_nanos(1000), 500, Feed::new(5.0));
        assert_eq!((clock.begin(&waiter, &Nothing, || ()), clock.step()), (Ok(true), 1));
        clock.spend();
        clock.keep();
        assert_eq!((clock.begin(&waiter, &Nothing, || ()), clock.step()), (Ok(false), 1));
        waiter.0.set(1500);
        clock.keep_unless_late(&waiter);
        assert_eq!((clock.begin(&waiter, &Nothing, || ()), clock.step()), (Ok(true), 2));
    }
}
