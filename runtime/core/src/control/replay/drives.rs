//! Drives that read from a recording what their encoders read.
//!
//! In: servo periods. Out: what the encoders had read when the next step began; between two steps, a moment too early.
//! A demand changes nothing: whether the programs demand the same is what a replay is for.

use core::marker::PhantomData;
use core::time::Duration;
use std::rc::Rc;

use crate::control::homing::{AnyHoming, Drives};
use crate::model::drive_fault::DriveFault;
use crate::model::driver::{Channels, Driver, Measured, Regulators};
use crate::model::joints::JointVector;
use crate::model::robot::Robot;
use crate::model::signals::Signals;
use crate::model::time::Nanos;

use super::RecordedRobot;

/// The times that such drives go by \[ns\].
#[derive(Clone, Copy, Debug)]
struct Times {
    step: Nanos,
    servo: Nanos,
}

impl Times {
    /// The step whose image shows what a servo period, counted from the cell's start, measured: the first one to begin
    /// after the middle of the period, where a step begins half the shorter period late.
    fn shown_in(self, tick: u64) -> u64 {
        let middle = tick * self.servo + self.servo / 2;
        let late = self.servo.min(self.step) / 2;
        middle.checked_sub(late).map_or(0, |after| after / self.step + 1)
    }
}

/// The drives.
struct Recorded<R: Robot> {
    recorded: Rc<RecordedRobot>,
    times: Times,
    /// As of the drives that were recorded.
    load_time: Duration,
    ticks: u64,
    /// The step whose image shows what was measured last.
    step: u64,
    robot: PhantomData<fn() -> R>,
}

impl<R: Robot> Recorded<R> {
    fn new(recorded: Rc<RecordedRobot>, times: Times, load_time: Duration) -> Recorded<R> {
        Recorded { step: recorded.first, recorded, times, load_time, ticks: 0, robot: PhantomData }
    }

    fn at(&self, step: u64) -> Measured<R::Joints> {
        match self.recorded.nearest(step) {
            Some(image) => Measured {
                position: R::Joints::from_joints(|i| image.measured.position[i]),
                velocity: R::Joints::from_joints(|i| image.measured.velocity[i]),
            },
            None => Measured { position: R::Joints::zeros(), velocity: R::Joints::zeros() },
        }
    }
}

impl<R: Robot> Driver<R> for Recorded<R> {
    fn period(&self) -> Duration {
        Duration::from_nanos(self.times.servo)
    }

    fn measured(&self) -> Result<Measured<R::Joints>, DriveFault> {
        Ok(self.at(self.recorded.first))
    }

    fn tick(&mut self, _: &R::Joints) -> Result<Measured<R::Joints>, DriveFault> {
        self.step = self.times.shown_in(self.ticks);
        self.ticks += 1;
        Ok(self.at(self.step))
    }

    /// Which channels there are, the run that was recorded has checked.
    fn channels(&self) -> Channels {
        Channels::ALL
    }

    fn signals(&self) -> Signals {
        self.recorded.signals(self.step)
    }

    fn load_time(&self) -> Duration {
        self.load_time
    }

    /// Which sets there are, the run that was recorded has checked.
    fn has_regulator(&self, _: usize, _: u8) -> bool {
        true
    }

    fn choose_regulators(&mut self, _: &Regulators) {}
}

/// Drives that are found when those of the recording were.
struct RecordedHoming<R: Robot> {
    drives: Option<Recorded<R>>,
    /// The servo period in which they were found.
    first: u64,
    ticks: u64,
    period: Duration,
}

impl<R: Robot> AnyHoming<R> for RecordedHoming<R> {
    fn period(&self) -> Duration {
        self.period
    }

    fn search(&mut self) -> Result<Option<Box<dyn Driver<R>>>, DriveFault> {
        let found = self.ticks >= self.first;
        self.ticks += 1;
        let Some(mut drives) = self.drives.take_if(|_| found) else { return Ok(None) };
        drives.ticks = self.first;
        Ok(Some(Box::new(drives)))
    }
}

/// The drives of a robot, replaced by what a recording says of them.
pub(crate) fn recorded_drives<R: Robot>(
    drives: &Drives<R>,
    recorded: Rc<RecordedRobot>,
    step: Duration,
) -> Drives<R> {
    let period = drives.period();
    let times = Times { step: step.as_nanos() as Nanos, servo: period.as_nanos() as Nanos };
    match drives {
        Drives::Homed(drives) => {
            let load_time = drives.load_time();
            Drives::Homed(Box::new(Recorded::new(recorded, times, load_time)))
        }
        Drives::Unhomed(_) => {
            // Drives that were never found are never found again.
            let first = recorded.found.map_or(u64::MAX, |found| found / times.servo.max(1));
            let drives = Some(Recorded::new(recorded, times, Duration::ZERO));
            Drives::Unhomed(Box::new(RecordedHoming { drives, first, ticks: 0, period }))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_servo_period_measures_what_the_next_step_to_begin_shows() {
        // Servo and step in ns; step k begins at k T + min(s, T) / 2, period n has its middle at n s + s / 2.
        for (servo, step) in
            [(1000, 1000), (1000, 2000), (250, 1000), (2000, 1000), (3000, 1000), (4000, 2000)]
        {
            let times = Times { step, servo };
            let late = servo.min(step) / 2;
            for tick in 0..40 {
                let middle = tick * servo + servo / 2;
                let shown = (0..).find(|k| k * step + late > middle).expect("steps have no end");
                assert_eq!(times.shown_in(tick), shown, "period {tick} of {servo}/{step}");
            }
        }
    }
}
