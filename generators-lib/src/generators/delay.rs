//! Stays where it is for a time by the clock.

use core::marker::PhantomData;

use mrroc::prelude::*;

/// Holds the robot for a time by the clock, whatever the operator's speed: while glue dries, or a tool runs up to
/// speed. The time goes on while the cell is suspended; that of a [`Sleep`](mrroc_generators::generators::Sleep) does
/// not.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::Delay;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::Irp6;
///
/// // 0.5 s are 250 steps of 2 ms.
/// let demands = rehearse(Delay::lasting(0.5), &Irp6::nominal(), Irp6::READY, 0.002)?;
/// assert_eq!(demands, vec![Demand::hold(); 250]);
/// # Ok::<(), Fault>(())
/// ```
pub struct Delay<R> {
    duration: f64,
    time: f64,
    of: PhantomData<R>,
}

impl<R: Robot> Delay<R> {
    /// For `duration` \[s\], >= 0, finite, rounded up to whole steps.
    #[must_use]
    pub fn lasting(duration: f64) -> Self {
        Delay { duration, time: 0.0, of: PhantomData }
    }
}

#[generator(ecp)]
impl<R: Robot> Delay<R> {
    fn next_step(&mut self, t: Tick) -> Result<Step<R>, Fault> {
        if !(self.duration.is_finite() && self.duration >= 0.0) {
            return Err(Fault::thrown("the duration of a delay must be finite and >= 0"));
        }
        // The sum of n increments may miss n * dt by rounding; that must not cost a step.
        if self.time >= self.duration - 1e-9 * t.duration {
            return Ok(Step::Done);
        }
        self.time += t.duration;
        Ok(Step::Next(Demand::hold()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_robots::Irp6;

    #[test]
    fn the_operators_speed_does_not_stretch_it() {
        for dt in [0.0, 1e-3, 2e-3] {
            let mut delay = Delay::<Irp6>::lasting(0.5);
            let t = Tick { step: 0, dt, duration: 2e-3 };
            let steps = (0..).take_while(|_| delay.next_step(t) == Ok(Step::Next(Demand::hold()))).count();
            assert_eq!(steps, 250);
        }
    }
}
