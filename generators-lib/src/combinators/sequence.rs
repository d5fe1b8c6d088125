//! One generator after another.

use mrroc::generator::{Class, Generator};
use mrroc::prelude::*;

/// Runs `A` to its end, then `B`, as one motion: the step in which the first is done is the first step of the second, so that
/// no step is lost between them, and the demand goes on from where it was.
///
/// What ends at rest and what starts at rest go together; a generator that ends while moving is a step in velocity, which the
/// limits refuse. Displacements count from the start of the whole motion: a generator of these may come first, not second.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::combinators::Sequence;
/// use mrroc_generators::generators::{JointMove, Sleep};
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::{Irp6, Six};
///
/// let goal = Irp6::READY + Six::x() * 0.2;
/// let to = |q| JointMove::to(q, Six::repeat(0.4), Six::repeat(0.8));
/// let there_and_back = Sequence::of(to(goal), Sequence::of(Sleep::lasting(0.1), to(Irp6::READY)));
/// let demands = rehearse(there_and_back, &Irp6::nominal(), Irp6::READY, 0.002)?;
/// // Twice 2 sqrt(0.2 / 0.8) s, and the sleep; no step is lost between them.
/// assert_eq!(demands.len(), 500 + 50 + 500);
/// assert_eq!(demands[499].as_joints(), Some(goal));
/// # Ok::<(), Fault>(())
/// ```
pub struct Sequence<A, B> {
    first: A,
    second: B,
    stage: Stage,
}

#[derive(Clone, Copy, PartialEq)]
enum Stage {
    First,
    Second,
}

impl<A, B> Sequence<A, B>
where
    A: Generator,
    B: Generator<Robots = A::Robots, Language = A::Language, Sensors = A::Sensors, Order = A::Order>,
{
    /// `first`, then `second`: of one level, for the same robots, sensors and orders.
    #[must_use]
    pub fn of(first: A, second: B) -> Self {
        const { assert!(A::CLASS.level as u8 == B::CLASS.level as u8, "both of an MP, or both of an ECP") };
        const { assert!(A::ENDS, "the first must end by itself") };
        Sequence { first, second, stage: Stage::First }
    }
}

impl<A, B> Generator for Sequence<A, B>
where
    A: Generator,
    B: Generator<Robots = A::Robots, Language = A::Language, Sensors = A::Sensors, Order = A::Order>,
{
    type Robots = A::Robots;
    type Language = A::Language;
    type Sensors = A::Sensors;
    type Order = A::Order;
    const CLASS: Class = {
        let a = A::CLASS;
        let b = B::CLASS;
        // The second may begin in any step, even in the first one.
        let later = b.first_uses().and(b.next_uses());
        Class {
            level: a.level,
            first: a.first_uses().and(b.first_uses()),
            next: a.next_uses().and(later),
            until: None,
        }
    };
    const ENDS: bool = B::ENDS;

    fn first_step(
        &mut self,
        c0: &Order<A::Order>,
        e: &State<A::Robots>,
        v: &Reading<A::Sensors>,
        t: Tick,
    ) -> Result<Step<A::Robots, A::Language>, Fault> {
        match self.first.first_step(c0, e, v, t)? {
            Step::Next(told) => Ok(Step::Next(told)),
            Step::Done => {
                self.stage = Stage::Second;
                self.second.first_step(c0, e, v, t)
            }
        }
    }

    fn next_step(
        &mut self,
        c0: &Order<A::Order>,
        e: &State<A::Robots>,
        v: &Reading<A::Sensors>,
        t: Tick,
    ) -> Result<Step<A::Robots, A::Language>, Fault> {
        if self.stage == Stage::Second {
            return self.second.next_step(c0, e, v, t);
        }
        match self.first.next_step(c0, e, v, t)? {
            Step::Next(told) => Ok(Step::Next(told)),
            Step::Done => {
                self.stage = Stage::Second;
                self.second.first_step(c0, e, v, t)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generators::{JointMove, Sleep};
    use mrroc::observe::ServoRecord;

    use mrroc_robots::{Irp6, SimulatedIrp6, Six};
    use std::{cell::RefCell, rc::Rc, time::Duration};

    #[test]
    fn three_motions_take_the_sum_of_their_times_and_no_step_more() {
        let start = Irp6::READY;
        let to = move |q: f64| {
            JointMove::<Irp6>::to(
                start + Six::new(q, 0.0, 0.0, 0.0, 0.0, 0.0),
                Six::repeat(0.4),
                Six::repeat(0.8),
            )
        };
        let trace = Rc::new(RefCell::new(Vec::new()));
        let recorder = Rc::clone(&trace);
        let robot = RobotSetup::new("irp6", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start))
            .observe(move |record: &ServoRecord<Irp6>| recorder.borrow_mut().push(record.demanded[0]))
            .program(move |ecp| {
                let motion = Sequence::of(to(0.2), Sequence::of(Sleep::lasting(0.1), to(0.0)));
                ecp.move_robot((), motion).map(drop)
            });
        let report = Cell::new(Duration::from_millis(2)).robot(robot).run().expect("within the limits");
        // Twice 2 sqrt(D / A) = 2 sqrt(0.2 / 0.8) = 1 s, and the sleep.
        let duration = report.time.as_secs_f64();
        assert!((2.1..2.12).contains(&duration), "{duration} s");
        let trace = trace.borrow();
        let peak = trace.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert!((peak - 0.2).abs() < 1e-3 && trace.last().is_some_and(|q| q.abs() < 1e-3), "{peak}");
        let jumps = trace.windows(3).map(|q| (q[2] - 2.0 * q[1] + q[0]).abs() / 4e-6);
        assert!(jumps.fold(0.0, f64::max) < 0.81);
    }
}
