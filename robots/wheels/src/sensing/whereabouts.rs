//! The virtual sensor that tells where the base stands: `f_v` of its wheels and its gyro.

use mrroc::fault::FaultKind;
use mrroc::payload::Payload;
use mrroc::prelude::*;

use super::dead_reckoning::{DeadReckoning, Reckoned};
use super::gyro::Gyro;
use super::planar::Planar;
use crate::model::Two;

/// The kind of sensor that tells where a base stands.
#[derive(Clone, Copy, Debug)]
pub struct Whereabouts;

impl Sensor for Whereabouts {
    const KIND: &'static str = "whereabouts";
    type Reading = Standing;
    type Configuration = ();
}

/// Where a base stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Standing {
    /// Its pose.
    pub pose: Planar,
    /// Whether it stands still, and the gyro's bias is known.
    pub stands: bool,
}

/// Aggregates readings of a base's wheels and its gyro.
#[derive(Debug)]
pub struct Located {
    gyro: Gyro,
    reckoning: DeadReckoning,
}

impl Located {
    /// By this gyro, from where `reckoning` begins.
    #[must_use]
    pub const fn by(gyro: Gyro, reckoning: DeadReckoning) -> Self {
        Self { gyro, reckoning }
    }

    /// It is known better where the base stands.
    pub fn correct(&mut self, pose: Planar) {
        self.reckoning.correct(pose);
    }

    /// The gyro, to break it.
    pub const fn gyro_mut(&mut self) -> &mut Gyro {
        &mut self.gyro
    }

    /// One step of what the wheels and the gyro say.
    ///
    /// # Errors
    /// [`FaultKind::SensorFailed`]: the gyro does not answer, or it and the wheels disagree so much that the heading is not known any more.
    pub fn step(&mut self, wheels: &Two) -> Result<Reckoned, Fault> {
        let Some(turned) = self.gyro.ask() else {
            let fault = Fault::new(FaultKind::SensorFailed);
            return Err(fault.text("the gyro does not answer: look at its cable"));
        };
        let reckoned = self.reckoning.step(wheels, &turned);
        if reckoned.apart.abs() > DeadReckoning::MOST {
            let fault = Fault::new(FaultKind::SensorFailed)
                .exceeds(reckoned.apart, DeadReckoning::MOST, "rad")
                .text("gyro and wheels disagree about a turn: a wheel slips or is blocked, or the gyro fails; put the base where it is said to begin");
            return Err(fault);
        }
        Ok(reckoned)
    }
}

/// The wheels' angles that go with an order.
pub(crate) fn wheels(robot: Option<&mrroc::sensor::EffectorState>) -> Result<Two, Fault> {
    let state =
        robot.ok_or_else(|| Fault::thrown("a base's place needs the state of its wheels: write `of`"))?;
    Ok(Two::new(state.joints[0], state.joints[1]))
}

impl VirtualSensor for Located {
    type Kind = Whereabouts;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Standing, Fault> {
        let reckoned = self.step(&wheels(order.robot.as_ref())?)?;
        Ok(Standing { pose: reckoned.pose, stands: reckoned.stands })
    }

    fn is_simulated(&self) -> bool {
        true
    }
}
