//! A condition that holds after a time.

use mrroc::generator::{AnyRobots, Class, Condition, Level, Uses};
use mrroc::prelude::*;

use super::stopwatch::Stopwatch;

/// A condition that holds when `time` \[s\], finite, >= 0, has passed since the first step in which it was asked, rounded up to
/// whole steps. It looks at nothing, so it goes with the robots and sensors of any other condition.
///
/// ```
/// use mrroc::generator::Condition;
/// use mrroc::prelude::*;
/// use mrroc_generators::conditions::elapsed;
///
/// let mut over = elapsed(0.5);
/// let t = Tick { step: 0, dt: 0.002, duration: 0.002 };
/// let mut ask = || over.is_met(&Order::new(()), &State::new(()), &Reading::new(()), t);
/// // 0.5 s are 250 steps of 2 ms.
/// assert_eq!((0..).find(|_| ask() == Ok(true)), Some(250));
/// ```
#[must_use]
pub const fn elapsed(time: f64) -> Elapsed {
    Elapsed { time: Stopwatch::until(time), begun: false }
}

/// Holds when a time has passed: [`elapsed`].
#[derive(Clone, Copy, Debug)]
pub struct Elapsed {
    time: Stopwatch,
    begun: bool,
}

impl Condition for Elapsed {
    type Robots = AnyRobots;
    type Sensors = ();
    type Order = ();
    // Of either level: what it is put together with says of which.
    const CLASS: Class = Class::new(Level::Ecp, Uses { state: true, tick: true, ..Uses::NOTHING });

    fn is_met(
        &mut self,
        _: &Order<()>,
        _: &State<AnyRobots>,
        _: &Reading<()>,
        t: Tick,
    ) -> Result<bool, Fault> {
        self.time.check()?;
        if self.begun {
            self.time.advance(t);
        }
        self.begun = true;
        Ok(self.time.is_over(t))
    }
}
