//! Conditions of which one holds.

use mrroc::generator::{Class, Condition};
use mrroc::prelude::*;

use super::parts::Parts;

/// A condition that holds when at least one of its parts does: two to four conditions in a tuple, or an array of
/// conditions of one type. They share their robots and sensors, unless they are [`separate`](super::separate()).
///
/// ```
/// use mrroc::generator::Condition;
/// use mrroc::prelude::*;
/// use mrroc_generators::conditions::{any, elapsed, not};
///
/// let mut before_4_or_from_8_ms = any((not(elapsed(0.004)), elapsed(0.008)));
/// let t = Tick { step: 0, dt: 0.002, duration: 0.002 };
/// let mut ask = || before_4_or_from_8_ms.is_met(&Order::new(()), &State::new(()), &Reading::new(()), t);
/// let met: Result<Vec<bool>, Fault> = (0..6).map(|_| ask()).collect();
/// assert_eq!(met?, [true, true, false, false, true, true]);
/// # Ok::<(), Fault>(())
/// ```
#[must_use]
pub const fn any<P: Parts>(parts: P) -> Any<P> {
    Any(parts)
}

/// Holds when at least one of its parts does: [`any`].
#[derive(Clone, Copy, Debug)]
pub struct Any<P>(P);

impl<P: Parts> Condition for Any<P> {
    type Robots = P::Robots;
    type Sensors = P::Sensors;
    type Order = P::Order;
    const CLASS: Class = P::CLASS;

    fn is_met(
        &mut self,
        order: &Order<P::Order>,
        e: &State<P::Robots>,
        v: &Reading<P::Sensors>,
        t: Tick,
    ) -> Result<bool, Fault> {
        let mut met = false;
        self.0.ask(order, e, v, t, |part| met |= part)?;
        Ok(met)
    }
}
