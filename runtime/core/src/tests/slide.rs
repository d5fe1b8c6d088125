//! A robot for unit tests: one slide along x, and drives that are where they are told to be.

use core::time::Duration;

use nalgebra::Vector1;

use crate::model::drive_fault::DriveFault;
use crate::model::driver::{Driver, Measured};
use crate::model::pose::Pose;
use crate::model::robot::{Limits, NoInverse, Robot};

pub(crate) type One = Vector1<f64>;

#[derive(Clone, Debug)]
pub(crate) struct Slide(pub Limits<One>);

impl Slide {
    /// From -1 m to 1 m, 1 m/s, 10 m/s².
    pub fn new() -> Slide {
        Slide(Limits {
            lower: One::new(-1.0),
            upper: One::new(1.0),
            velocity: One::new(1.0),
            acceleration: One::new(10.0),
            jerk: None,
        })
    }
}

impl Robot for Slide {
    const KIND: &'static str = "slide";
    type Joints = One;
    fn limits(&self) -> &Limits<One> {
        &self.0
    }
    fn forward(&self, q: &One) -> Pose {
        Pose::translation(q[0], 0.0, 0.0)
    }
    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, _: &One) -> Result<One, NoInverse> {
        Ok(One::new(X_WF.translation.x))
    }
}

pub(crate) struct Exact {
    pub period: Duration,
    pub measured: Measured<One>,
}

impl Exact {
    /// At 0, at rest.
    pub fn new(period: Duration) -> Exact {
        Exact { period, measured: Measured { position: One::zeros(), velocity: One::zeros() } }
    }
}

impl Driver<Slide> for Exact {
    fn period(&self) -> Duration {
        self.period
    }
    fn measured(&self) -> Result<Measured<One>, DriveFault> {
        Ok(self.measured)
    }
    fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
        self.measured.position = *demanded;
        Ok(self.measured)
    }
}
