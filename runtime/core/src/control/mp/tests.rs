//! An MP without robots.

use crate::link::{Host, Waiter};
use crate::observe::activity::Activity;
use crate::observe::shown::Shown;
use core::cell::Cell;

use super::*;
use crate::control::overruns::Timed;
use crate::link::Closed;
use crate::link::timeout::AnswerTimeout;

const STEP: Nanos = 1_000_000;

/// Time that passes while the process works, and otherwise when it sleeps.
#[derive(Default)]
struct Time(Cell<Nanos>);

impl Waiter for Time {
    fn now(&self) -> Nanos {
        self.0.get()
    }
    fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
        self.0.set(deadline.map_or(self.0.get(), |deadline| deadline.max(self.0.get())));
        Ok(())
    }
}

/// Begins steps in which the MP works for so long \[ns\]; the step and the fault that it ends with.
fn run(work: impl Fn(u64) -> Nanos, steps: u64) -> Option<(u64, FaultKind)> {
    let time = Time::default();
    let timed = Timed::new(Host::of(&time));
    let sensing = Sensing {
        owner: crate::model::list::Owner::unique(),
        ports: Vec::new(),
        timeout: AnswerTimeout { most: STEP, again: STEP },
        step_observers: StepObservers::to(Vec::new()),
    };
    let timing =
        MpTiming { period: Duration::from_nanos(STEP), grace: STEP / 2, rate_change: 5.0, path_stop: 100 };
    let activity = Shown::new(Activity::default());
    let mut mp = Mp::new(timed.host(), Vec::new(), sensing, (Operator::new(), None, activity), &timing);
    for begun in 0..steps {
        if let Err(fault) = mp.begin_step() {
            return Some((begun, fault.kind()));
        }
        time.0.set(time.now() + work(begun));
        mp.clock.spend();
    }
    None
}

#[test]
fn fault_12_an_mp_whose_steps_take_longer_than_a_period_ends_with_overrun_at_the_tenth() {
    // The work of step n is known when step n + 1 begins.
    assert_eq!(run(|_| 1_200_000, 100), Some((10, FaultKind::Overrun)));
    assert_eq!(run(|_| 900_000, 100), None);
    // Every second one: never more than one net.
    assert_eq!(run(|step| if step % 2 == 0 { 1_200_000 } else { 300_000 }, 1000), None);
    // Two of three: one net in three steps, so eight after 24, and the tenth with the second one of the next three.
    let two_of_three = |step| if step % 3 < 2 { 1_200_000 } else { 300_000 };
    assert_eq!(run(two_of_three, 1000), Some((26, FaultKind::Overrun)));
}

#[test]
fn fault_11_one_step_that_takes_long_is_counted_unless_it_takes_more_than_l_periods() {
    let once = |time| move |step| if step == 5 { time } else { 0 };
    assert_eq!(run(once(1_500_000), 100), None);
    assert_eq!(run(once(20 * STEP), 100), None);
    assert_eq!(run(once(21 * STEP), 100), Some((6, FaultKind::Overrun)));
}
