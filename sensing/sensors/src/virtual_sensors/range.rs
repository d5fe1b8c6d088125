//! A range finder across a belt: where parts lie.

use mrroc::pose::Pose;
use mrroc::prelude::*;

use crate::aggregation::Laterals;
use crate::physics::{Triangulation, distance_of};
use crate::scene::Scene;

/// The kind of sensor: how far parts are that pass a range finder.
#[derive(Clone, Copy, Debug)]
pub struct Across;

impl Sensor for Across {
    const KIND: &'static str = "across";
    type Reading = AcrossReading;
    type Configuration = ();
}

/// What a range finder says of the newest part that has come to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct AcrossReading {
    /// How many parts have come; 0: none yet, and the rest says nothing.
    pub parts: u32,
    /// Values that were invalid.
    pub invalid: u32,
    /// From the sensor to the near side of the part \[m\].
    pub distance: f64,
    /// How many values it is the median of.
    pub values: u32,
    /// How long ago the last of them was finished, at the step of the reading \[s\].
    pub since: f64,
}

/// A triangulation sensor over a scene.
#[derive(Debug)]
#[allow(non_snake_case)]
pub struct RangeFinder<S> {
    scene: S,
    X_WL: Pose,
    sensor: Triangulation,
    laterals: Laterals,
    step: f64,
}

impl<S: Scene + 'static> RangeFinder<S> {
    /// It looks along z of its frame `X_WL`, and takes for a part what `laterals` says; `step` \[s\] is that of the cell.
    #[must_use]
    #[allow(non_snake_case)]
    pub const fn new(scene: S, X_WL: Pose, sensor: Triangulation, laterals: Laterals, step: f64) -> Self {
        Self { scene, X_WL, sensor, laterals, step }
    }
}

impl<S: Scene + 'static> VirtualSensor for RangeFinder<S> {
    type Kind = Across;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<AcrossReading, Fault> {
        let (time, code) = self.sensor.sample(&self.scene, &self.X_WL);
        self.laterals.take(time, code, distance_of);
        let (parts, invalid) = (self.laterals.count(), self.laterals.invalid());
        let Some(newest) = self.laterals.newest() else {
            return Ok(AcrossReading { parts, invalid, ..AcrossReading::default() });
        };
        let since = order.step as f64 * self.step - newest.last;
        Ok(AcrossReading { parts, invalid, distance: newest.distance, values: newest.values, since })
    }

    fn is_simulated(&self) -> bool {
        true
    }
}
