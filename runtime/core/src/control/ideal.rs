//! Ideal drives: simulated ones for any robot, without a model of its motors.
//!
//! In: joint positions. Out: the same, as fast as the velocity limits permit. They stand in for real drives where nothing
//! real may move.

use core::time::Duration;

use crate::model::drive_fault::DriveFault;
use crate::model::driver::{Driver, Measured, SimulatedDrives};
use crate::model::excess::Excess;
use crate::model::joints::{JointVector, MAX_JOINTS};
use crate::model::robot::{Limits, Robot};

/// How much farther than its velocity limit says a joint goes in a period, as a share: for round-off.
const ROUND_OFF: f64 = 1e-6;
/// How far outside of its range a joint may be told to be, as a share of the range: a robot may stand beside it.
const BESIDE: f64 = 0.01;

/// Simulated drives that are at the end of every servo period where they are told to be; a joint that is told to go faster
/// than its velocity limit follows as fast as that. No motor is simulated, so following errors, currents and regulators
/// are not.
///
/// A demand that is no number, or far outside of a joint's range, trips them: as without commands they brake by the
/// acceleration limits.
#[derive(Clone, Debug)]
pub struct IdealDrives<R: Robot> {
    limits: Limits<R::Joints>,
    units: [&'static str; MAX_JOINTS],
    period: Duration,
    measured: Measured<R::Joints>,
    tripped: Option<DriveFault>,
}

impl<R: Robot> IdealDrives<R> {
    /// Drives of a robot that stands at `start` [rad or m], with a servo period.
    pub fn new(robot: &R, start: R::Joints, period: Duration) -> Self {
        let units = core::array::from_fn(|i| if i < R::Joints::LEN { robot.joint(i).unit(0) } else { "" });
        let measured = Measured { position: start, velocity: R::Joints::zeros() };
        IdealDrives { limits: *robot.limits(), units, period, measured, tripped: None }
    }

    /// Why they do not go to `demanded`.
    fn refusal(&self, demanded: &R::Joints) -> Option<DriveFault> {
        (0..R::Joints::LEN).find_map(|i| {
            let (lower, upper) = (self.limits.lower[i], self.limits.upper[i]);
            let beside = BESIDE * (upper - lower);
            let limit = if demanded[i] > upper { upper } else { lower };
            let is_near = (lower - beside..=upper + beside).contains(&demanded[i]);
            let excess = Excess::new(demanded[i], limit, self.units[i]);
            (!is_near).then(|| DriveFault::exceeded(i, "demanded position", excess))
        })
    }
}

impl<R: Robot> Driver<R> for IdealDrives<R> {
    fn period(&self) -> Duration {
        self.period
    }

    fn measured(&self) -> Result<Measured<R::Joints>, DriveFault> {
        Ok(self.measured)
    }

    fn tick(&mut self, demanded: &R::Joints) -> Result<Measured<R::Joints>, DriveFault> {
        self.tripped = self.tripped.or_else(|| self.refusal(demanded));
        if let Some(trip) = self.tripped {
            self.brake();
            return Err(trip);
        }
        let Measured { position: before, .. } = self.measured;
        let seconds = self.period.as_secs_f64();
        let position = R::Joints::from_joints(|i| {
            let displacement = demanded[i] - before[i];
            let most = self.limits.velocity[i] * seconds * (1.0 + ROUND_OFF);
            if displacement.abs() <= most { demanded[i] } else { before[i] + most.copysign(displacement) }
        });
        self.measured = Measured { position, velocity: (position - before) * seconds.recip() };
        Ok(self.measured)
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.tripped = None;
        Ok(())
    }

    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<R::Joints>> {
        Some(self)
    }
}

impl<R: Robot> SimulatedDrives<R::Joints> for IdealDrives<R> {
    fn brake(&mut self) -> Measured<R::Joints> {
        let Measured { position, velocity } = self.measured;
        let seconds = self.period.as_secs_f64();
        let slower = R::Joints::from_joints(|i| {
            let speed = (velocity[i].abs() - self.limits.acceleration[i] * seconds).max(0.0);
            speed.copysign(velocity[i])
        });
        self.measured =
            Measured { position: position + (velocity + slower) * (0.5 * seconds), velocity: slower };
        self.measured
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::slide::{One, Slide};

    const MS: Duration = Duration::from_millis(1);

    /// From -1 m to 1 m, 1 m/s, 10 m/s².
    fn drives() -> IdealDrives<Slide> {
        IdealDrives::new(&Slide::new(), One::new(0.5), MS)
    }

    #[test]
    fn they_are_where_they_are_told_to_be_as_fast_as_the_velocity_limit_permits() {
        let mut drives = drives();
        let near = drives.tick(&One::new(0.5 + 1e-3)).expect("1 m/s");
        assert_eq!(near.position[0], 0.5 + 1e-3);
        assert!((near.velocity[0] - 1.0).abs() < 1e-9);
        // 10 mm take ten periods.
        for period in 1..=9 {
            let position = drives.tick(&One::new(0.511)).expect("followed").position[0];
            assert!((position - 0.501 - 1e-3 * f64::from(period)).abs() < 1e-7, "{position}");
        }
        assert_eq!(drives.tick(&One::new(0.511)).expect("followed").position[0], 0.511);
    }

    #[test]
    fn what_is_no_number_or_far_outside_of_the_range_trips_them_until_they_are_switched_on() {
        for value in [f64::NAN, f64::INFINITY, 1.03, -1.03] {
            let mut drives = drives();
            let trip = drives.tick(&One::new(value)).expect_err("refused");
            assert_eq!((trip.joint(), trip.what()), (Some(0), "demanded position"));
            assert!(drives.tick(&One::new(0.5)).is_err());
            drives.switch_on().expect("they come on");
            assert_eq!(drives.tick(&One::new(0.5)).map(|measured| measured.position[0]), Ok(0.5));
        }
        // The robot may stand 10 mm beside its range of 2 m.
        assert!(IdealDrives::new(&Slide::new(), One::new(1.01), MS).tick(&One::new(1.01)).is_ok());
    }

    #[test]
    fn without_commands_they_brake_by_the_acceleration_limit() {
        let mut drives = drives();
        drives.tick(&One::new(0.5 + 0.5e-3)).expect("0.5 m/s");
        // 0.5 m/s at 10 m/s²: 50 periods, and v²/2a.
        for _ in 0..49 {
            assert!(drives.brake().velocity[0] > 1e-9);
        }
        let rest = drives.brake();
        assert!(
            rest.velocity[0].abs() < 1e-9 && (rest.position[0] - 0.5005 - 0.0125).abs() < 1e-9,
            "{rest:?}"
        );
    }
}
