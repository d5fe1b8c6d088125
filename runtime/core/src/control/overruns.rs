//! Steps that a process missed by its own fault: because it woke late, or because what it had to do took too long.
//!
//! In: for each step how many periods went by meanwhile. Out: nothing, or the fault that ends the cell (faults 11 and 12
//! in docs/safety). A counter that leaks: each late step adds one, each punctual one takes one away; ten are too many,
//! and so are more than `L` periods missed in a row.

use core::cell::Cell;
use core::time::Duration;

use crate::link::{Client, Closed, Host, Meter, Sample, Waiter};
use crate::model::fault::{Fault, FaultKind};
use crate::model::time::Nanos;
use crate::safety::stopping::missed_step_budget;

/// Late steps, less punctual ones, that are too many.
const NET: u32 = 10;

/// The whole periods in a time: mostly none, and then nothing is divided.
#[inline]
pub(crate) fn periods_in(time: Nanos, period: Nanos) -> u64 {
    if time < period { 0 } else { time / period.max(1) }
}

/// The counter.
pub(crate) struct Overruns {
    net: u32,
    budget: u64,
}

impl Overruns {
    /// None in a cell of this step.
    pub fn new(step: Duration) -> Overruns {
        Overruns { net: 0, budget: u64::from(missed_step_budget(step)) }
    }

    /// As if no step had been late: after a reset.
    pub fn forget(&mut self) {
        self.net = 0;
    }

    /// Counts a step for which `missed` periods went by.
    ///
    /// # Errors
    /// `Overrun` when there are too many.
    #[inline]
    pub fn note(&mut self, missed: u64) -> Result<(), Fault> {
        if missed == 0 {
            self.net = self.net.saturating_sub(1);
            return Ok(());
        }
        self.net += 1;
        let fault = |text, actual: f64, limit: f64| {
            Err(Fault::new(FaultKind::Overrun).text(text).exceeds(actual, limit, "step"))
        };
        if missed > self.budget {
            return fault("in a row", missed as f64, self.budget as f64);
        }
        if self.net >= NET {
            return fault("late steps, less punctual ones", f64::from(self.net), f64::from(NET - 1));
        }
        Ok(())
    }
}

/// A waiter that knows for how long its process did not wait: what it spends on messages of others is not its own time.
pub(crate) struct Timed<'w> {
    host: Host<'w>,
    /// When it woke last, and its own time until then since it was asked last \[ns\].
    woke: Cell<Nanos>,
    own: Cell<Nanos>,
}

impl<'w> Timed<'w> {
    /// Counts from now.
    pub fn new(host: Host<'w>) -> Timed<'w> {
        Timed { host, woke: Cell::new(host.waiter.now()), own: Cell::new(0) }
    }

    /// What the process has of its link, with its time counted, where time passes while it works.
    pub fn host(&self) -> Host<'_> {
        if self.host.waiter.stands_still() {
            self.host
        } else {
            Host { waiter: self, meter: self, ..self.host }
        }
    }

    /// Waits as `wait` does, until `deadline` or a message.
    fn count(
        &self,
        deadline: Option<Nanos>,
        wait: impl FnOnce() -> Result<(), Closed>,
    ) -> Result<(), Closed> {
        let began = self.now();
        let worked = began.saturating_sub(self.woke.get());
        let outcome = wait();
        let woke = self.now();
        // A deadline that was over before is not the sleep's fault.
        let late = deadline.map_or(0, |deadline| woke.saturating_sub(deadline.max(began)));
        self.own.set(self.own.get() + worked + late);
        self.woke.set(woke);
        outcome
    }
}

impl Waiter for Timed<'_> {
    fn now(&self) -> Nanos {
        self.host.waiter.now()
    }

    fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
        self.count(deadline, || self.host.waiter.wait(deadline))
    }

    fn wait_for_reply(&self, client: &dyn Client, deadline: Option<Nanos>) -> Result<(), Closed> {
        self.count(deadline, || self.host.waiter.wait_for_reply(client, deadline))
    }

    fn stands_still(&self) -> bool {
        self.host.waiter.stands_still()
    }

    fn call(&self, place: usize) -> Result<(), Closed> {
        self.host.waiter.call(place)
    }

    fn wait_closing(&self, until: Nanos) -> Result<(), Closed> {
        self.host.waiter.wait_closing(until)
    }
}

impl Meter for Timed<'_> {
    fn own_time(&self) -> Nanos {
        let now = self.now();
        self.own.take() + now.saturating_sub(self.woke.replace(now))
    }

    fn sample(&self, sample: Sample) {
        self.host.meter.sample(sample);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn fault_12_ten_late_steps_more_than_punctual_ones_are_too_many() {
        let mut overruns = Overruns::new(MS);
        // Every second step late: never more than one at a time.
        assert!((0..1000).all(|step| overruns.note(step % 2).is_ok()));
        let mut overruns = Overruns::new(MS);
        assert!((0..9).all(|_| overruns.note(1).is_ok()));
        assert!(overruns.note(0).is_ok() && overruns.note(1).is_ok());
        let fault = overruns.note(1).expect_err("ten");
        let excess = fault.excess().expect("steps");
        assert_eq!((fault.kind(), excess.actual, excess.limit), (FaultKind::Overrun, 10.0, 9.0));
    }

    #[test]
    fn steps_that_were_late_before_a_reset_do_not_count_after_it() {
        let mut overruns = Overruns::new(MS);
        assert!((0..9).all(|_| overruns.note(1).is_ok()));
        overruns.forget();
        assert!((0..9).all(|_| overruns.note(1).is_ok()));
        assert!(overruns.note(1).is_err());
    }

    #[test]
    fn fault_11_one_late_step_is_too_many_when_it_is_late_for_more_than_the_budget() {
        // L = 20 at 1 ms and 3 at 8 ms.
        for (step, budget) in [(MS, 20), (8 * MS, 3)] {
            assert!(Overruns::new(step).note(budget).is_ok());
            assert!(Overruns::new(step).note(budget + 1).is_err());
        }
    }

    /// Time that passes as it is told.
    #[derive(Default)]
    struct Told {
        now: Cell<Nanos>,
        /// How much later than asked it wakes.
        late: Cell<Nanos>,
        worked: Cell<Option<Sample>>,
    }

    impl Waiter for Told {
        fn now(&self) -> Nanos {
            self.now.get()
        }
        fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
            // A message comes after 300 ns.
            self.now.set(deadline.map_or(self.now.get() + 300, |deadline| deadline + self.late.get()));
            Ok(())
        }
    }

    impl Meter for Told {
        fn sample(&self, sample: Sample) {
            self.worked.set(Some(sample));
        }
    }

    #[test]
    fn own_time_is_work_and_late_waking_and_not_waiting_for_others() {
        let told = Told::default();
        let timed = Timed::new(Host { meter: &told, ..Host::of(&told) });
        let work = |time| told.now.set(told.now.get() + time);
        work(50);
        timed.wait(None).expect("open");
        work(7);
        assert_eq!(timed.own_time(), 57);
        timed.sample(Sample::Worked(57));
        assert_eq!(told.worked.get(), Some(Sample::Worked(57)));
        told.late.set(20);
        timed.wait(Some(told.now.get() + 1000)).expect("open");
        work(1);
        assert_eq!(timed.own_time(), 21);
        // A deadline that is over: the work before it was the cause, and counts once.
        told.late.set(0);
        work(500);
        told.late.set(105);
        timed.wait(Some(told.now.get() - 100)).expect("open");
        assert_eq!(timed.own_time(), 505);
    }

    /// Keeps what it is asked.
    #[derive(Default)]
    struct Asked(core::cell::RefCell<Vec<String>>);

    impl Asked {
        fn note<T>(&self, asked: String, answer: T) -> T {
            self.0.borrow_mut().push(asked);
            answer
        }
    }

    impl Waiter for Asked {
        fn now(&self) -> Nanos {
            0
        }
        fn wait(&self, _: Option<Nanos>) -> Result<(), Closed> {
            self.note("wait".into(), Err(Closed))
        }
        fn call(&self, place: usize) -> Result<(), Closed> {
            self.note(format!("call {place}"), Err(Closed))
        }
        fn wait_closing(&self, until: Nanos) -> Result<(), Closed> {
            self.note(format!("wait closing {until}"), Err(Closed))
        }
    }

    impl Meter for Asked {
        fn sample(&self, sample: Sample) {
            self.note(format!("{sample:?}"), ());
        }
    }

    #[test]
    fn what_is_no_waiting_is_asked_of_the_waiter_itself() {
        let asked = Asked::default();
        let timed = Timed::new(Host { meter: &asked, ..Host::of(&asked) });
        assert_eq!(timed.wait(None), Err(Closed));
        assert_eq!(timed.call(3), Err(Closed));
        assert_eq!(timed.wait_closing(7), Err(Closed));
        timed.sample(Sample::Skipped(4));
        let expected = ["wait", "call 3", "wait closing 7", "Skipped(4)"];
        assert_eq!(*asked.0.borrow(), expected);
    }
}
