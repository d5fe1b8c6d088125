//! Conditions that all hold.

use mrroc::generator::{Class, Condition};
use mrroc::prelude::*;

use super::parts::Parts;

/// A condition that holds when every of its parts holds: two to four conditions in a tuple, or an array of
/// conditions of one type. They share their robots and sensors, unless they are [`separate`](super::separate()).
///
/// ```
/// use mrroc::generator::Condition;
/// use mrroc::prelude::*;
/// use mrroc_generators::conditions::{all, elapsed, not};
///
/// let mut from_4_to_8_ms = all((elapsed(0.004), not(elapsed(0.008))));
/// let t = Tick { step: 0, dt: 0.002, duration: 0.002 };
/// let mut ask = || from_4_to_8_ms.is_met(&Order::new(()), &State::new(()), &Reading::new(()), t);
/// let met: Result<Vec<bool>, Fault> = (0..6).map(|_| ask()).collect();
/// assert_eq!(met?, [false, false, true, true, false, false]);
/// # Ok::<(), Fault>(())
/// ```
#[must_use]
pub const fn all<P: Parts>(parts: P) -> All<P> {
    All(parts)
}

/// Holds when every of its parts holds: [`all`].
#[derive(Clone, Copy, Debug)]
pub struct All<P>(P);

impl<P: Parts> Condition for All<P> {
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
        let mut met = true;
        self.0.ask(order, e, v, t, |part| met &= part)?;
        Ok(met)
    }
}
