//! Stays where it is for a path time.

use core::marker::PhantomData;

use mrroc::prelude::*;

/// Holds the robot for a path time, or until the coordinator ends the motion.
///
/// Path time stands still while the cell is suspended, and so does the sleep.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::Sleep;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::Irp6;
///
/// // 0.5 s are 250 steps of 2 ms.
/// let demands = rehearse(Sleep::lasting(0.5), &Irp6::nominal(), Irp6::READY, 0.002)?;
/// assert_eq!(demands, vec![Demand::hold(); 250]);
/// # Ok::<(), Fault>(())
/// ```
pub struct Sleep<R> {
    duration: f64,
    time: f64,
    of: PhantomData<R>,
}

impl<R: Robot> Sleep<R> {
    /// For `duration` \[s\], >= 0; infinite to hold until the coordinator ends the motion.
    #[must_use]
    pub fn lasting(duration: f64) -> Self {
        Sleep { duration, time: 0.0, of: PhantomData }
    }
}

#[generator(ecp)]
impl<R: Robot> Sleep<R> {
    fn next_step(&mut self, t: Tick) -> Result<Step<R>, Fault> {
        if self.duration.is_nan() || self.duration < 0.0 {
            return Err(Fault::thrown("the duration of a sleep must be >= 0"));
        }
        // The sum of n increments may miss n * dt by rounding; that must not cost a step.
        if self.time >= self.duration - 1e-9 * t.dt {
            return Ok(Step::Done);
        }
        self.time += t.dt;
        Ok(Step::Next(Demand::hold()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc_robots::{Irp6, SimulatedIrp6};
    use std::time::Duration;

    #[test]
    fn it_sleeps_as_long_as_told() {
        let start = Irp6::READY;
        let robot = RobotSetup::new("irp6", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start))
            .program(|ecp| ecp.move_robot((), Sleep::lasting(0.5)).map(drop));
        let report = Cell::new(Duration::from_millis(2)).robot(robot).run().expect("nothing moves");
        let duration = report.time.as_secs_f64();
        assert!((0.5..0.52).contains(&duration), "{duration} s");
    }
}
