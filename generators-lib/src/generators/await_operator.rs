//! Stays where it is until a person confirms.

use core::marker::PhantomData;

use mrroc::prelude::*;

/// Holds the robot until a function that it calls in every step returns true: for example the state of a button, or the
/// answer of a dialog that another thread stores in an `AtomicBool`. While the cell is suspended it does not call the
/// function.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::AwaitOperator;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::Irp6;
///
/// // A button that is pressed after 100 steps.
/// let mut asked = 0;
/// let pressed = || {
///     asked += 1;
///     asked > 100
/// };
/// let demands = rehearse(AwaitOperator::until(pressed), &Irp6::nominal(), Irp6::READY, 0.002)?;
/// assert_eq!(demands, vec![Demand::hold(); 100]);
/// # Ok::<(), Fault>(())
/// ```
pub struct AwaitOperator<R, F> {
    confirmed: F,
    of: PhantomData<R>,
}

impl<R: Robot, F: FnMut() -> bool> AwaitOperator<R, F> {
    /// Until `confirmed` returns true. It is called in every step, so it must neither block nor allocate.
    #[must_use]
    pub fn until(confirmed: F) -> Self {
        AwaitOperator { confirmed, of: PhantomData }
    }
}

#[generator(ecp)]
impl<R: Robot, F: FnMut() -> bool> AwaitOperator<R, F> {
    fn next_step(&mut self) -> Step<R> {
        if (self.confirmed)() { Step::Done } else { Step::Next(Demand::hold()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc_robots::{Irp6, SimulatedIrp6};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};
    use std::time::Duration;

    #[test]
    fn it_asks_once_a_step_until_it_is_confirmed() {
        let start = Irp6::READY;
        let asked = Arc::new(AtomicU32::new(0));
        let button = Arc::clone(&asked);
        let robot = RobotSetup::new("irp6", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start))
            .program(move |ecp| {
                let pressed = || button.fetch_add(1, Ordering::Relaxed) == 100;
                ecp.move_robot((), AwaitOperator::until(pressed)).map(drop)
            });
        let report = Cell::new(Duration::from_millis(2)).robot(robot).run().expect("nothing moves");
        assert_eq!(asked.load(Ordering::Relaxed), 101);
        // A hundred steps of 2 ms, and a few to begin and to end.
        let duration = report.time.as_secs_f64();
        assert!((0.2..0.22).contains(&duration), "{duration} s");
    }
}
