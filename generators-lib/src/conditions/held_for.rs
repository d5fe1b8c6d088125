//! A condition that must hold for a while.

use mrroc::generator::{Class, Condition, Uses};
use mrroc::prelude::*;

use super::stopwatch::Stopwatch;

/// Methods of every condition.
pub trait ConditionExt: Condition {
    /// Holds when this condition has held in every step for `time` \[s\], finite, >= 0: in `time` divided by the step, rounded
    /// up, steps in a row, and in one at least. A step in which it does not hold starts the time anew.
    ///
    /// Programmable controllers call this an on-delay (TON of IEC 61131-3); a switch that bounces is debounced by it.
    ///
    /// ```
    /// use mrroc::generator::Condition;
    /// use mrroc::prelude::*;
    /// use mrroc_generators::conditions::ConditionExt;
    ///
    /// struct Switch(std::vec::IntoIter<bool>);
    ///
    /// #[condition(ecp)]
    /// fn switch(c: &mut Switch) -> bool {
    ///     c.0.next().unwrap_or(false)
    /// }
    ///
    /// let bouncing = [true, false, true, true, true, true].to_vec();
    /// let mut closed = Switch(bouncing.into_iter()).held_for(0.006); // 3 steps of 2 ms
    /// let t = Tick { step: 0, dt: 0.002, duration: 0.002 };
    /// let mut ask = || closed.is_met(&Order::new(()), &State::new(()), &Reading::new(()), t);
    /// let held: Result<Vec<bool>, Fault> = (0..6).map(|_| ask()).collect();
    /// assert_eq!(held?, [false, false, false, false, true, true]);
    /// # Ok::<(), Fault>(())
    /// ```
    fn held_for(self, time: f64) -> HeldFor<Self> {
        HeldFor { condition: self, time: Stopwatch::until(time) }
    }
}

impl<C: Condition> ConditionExt for C {}

/// A condition that has held for a while: [`ConditionExt::held_for`].
#[derive(Clone, Copy, Debug)]
pub struct HeldFor<C> {
    condition: C,
    time: Stopwatch,
}

impl<C: Condition> Condition for HeldFor<C> {
    type Robots = C::Robots;
    type Sensors = C::Sensors;
    type Order = C::Order;
    const CLASS: Class = {
        let own = Uses { state: true, tick: true, ..Uses::NOTHING };
        Class::new(C::CLASS.level, C::CLASS.next.and(own))
    };

    fn is_met(
        &mut self,
        order: &Order<C::Order>,
        e: &State<C::Robots>,
        v: &Reading<C::Sensors>,
        t: Tick,
    ) -> Result<bool, Fault> {
        self.time.check()?;
        let met = self.condition.is_met(order, e, v, t)?;
        if met {
            self.time.advance(t);
        } else {
            self.time.reset();
        }
        Ok(met && self.time.is_over(t))
    }
}
