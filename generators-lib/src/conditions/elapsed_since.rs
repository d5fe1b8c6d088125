//! A condition that holds a while after another one.

use mrroc::generator::{Class, Condition, Uses};
use mrroc::prelude::*;

use super::stopwatch::Stopwatch;

/// A condition that holds when `time` \[s\], finite, >= 0, has passed since `condition` held for the first time, rounded up to
/// whole steps; whether `condition` still holds does not matter. `elapsed_since(a, 0.0)` holds from the step on in which `a` has
/// held once.
///
/// ```
/// use mrroc::generator::Condition;
/// use mrroc::prelude::*;
/// use mrroc_generators::conditions::elapsed_since;
///
/// struct Pulse(u64);
///
/// /// Holds in its sixth step only.
/// #[condition(ecp)]
/// fn pulse(c: &mut Pulse) -> bool {
///     c.0 += 1;
///     c.0 == 6
/// }
///
/// let mut glue_is_dry = elapsed_since(Pulse(0), 0.2);
/// let t = Tick { step: 0, dt: 0.01, duration: 0.01 };
/// let mut ask = || glue_is_dry.is_met(&Order::new(()), &State::new(()), &Reading::new(()), t);
/// // Step 5 is the sixth, and 0.2 s are 20 steps more.
/// assert_eq!((0..).find(|_| ask() == Ok(true)), Some(25));
/// ```
#[must_use]
pub const fn elapsed_since<C: Condition>(condition: C, time: f64) -> ElapsedSince<C> {
    ElapsedSince { condition, time: Stopwatch::until(time), begun: false }
}

/// Holds a while after a condition has held for the first time: [`elapsed_since`].
#[derive(Clone, Copy, Debug)]
pub struct ElapsedSince<C> {
    condition: C,
    time: Stopwatch,
    begun: bool,
}

impl<C: Condition> Condition for ElapsedSince<C> {
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
        if self.begun {
            self.time.advance(t);
        }
        self.begun |= self.condition.is_met(order, e, v, t)?;
        Ok(self.begun && self.time.is_over(t))
    }
}
