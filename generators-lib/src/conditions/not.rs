//! The negation of a condition.

use mrroc::generator::{Class, Condition};
use mrroc::prelude::*;

/// A condition that holds when `condition` does not.
///
/// Mind what a condition says without a reading: "no part is seen" is not what `not(part_seen {})` means while the camera has
/// not been read yet.
///
/// ```
/// use mrroc::generator::Condition;
/// use mrroc::prelude::*;
/// use mrroc_generators::conditions::{elapsed, not};
///
/// let mut in_time = not(elapsed(0.01));
/// let t = Tick { step: 0, dt: 0.002, duration: 0.002 };
/// let mut ask = || in_time.is_met(&Order::new(()), &State::new(()), &Reading::new(()), t);
/// // 10 ms are 5 steps of 2 ms.
/// assert_eq!((0..8).filter(|_| ask() == Ok(true)).count(), 5);
/// ```
#[must_use]
pub const fn not<C: Condition>(condition: C) -> Not<C> {
    Not(condition)
}

/// Holds when a condition does not: [`not`].
#[derive(Clone, Copy, Debug)]
pub struct Not<C>(C);

impl<C: Condition> Condition for Not<C> {
    type Robots = C::Robots;
    type Sensors = C::Sensors;
    type Order = C::Order;
    const CLASS: Class = C::CLASS;

    fn is_met(
        &mut self,
        order: &Order<C::Order>,
        e: &State<C::Robots>,
        v: &Reading<C::Sensors>,
        t: Tick,
    ) -> Result<bool, Fault> {
        self.0.is_met(order, e, v, t).map(|met| !met)
    }
}
