//! A gate: two light barriers across a belt.

use mrroc::pose::Pose;
use mrroc::prelude::*;

use super::sampled::Sampled;
use crate::aggregation::Passages;
use crate::physics::LightBarrier;
use crate::scene::Scene;

/// The kind of sensor: parts that pass a gate.
#[derive(Clone, Copy, Debug)]
pub struct Gate;

impl Sensor for Gate {
    const KIND: &'static str = "gate";
    type Reading = GateReading;
    type Configuration = ();
}

/// What a gate says of the newest part that has passed it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct GateReading {
    /// How many parts have passed; 0: none yet, and the rest says nothing.
    pub parts: u32,
    /// How often its edges made no part: [`Passages`].
    pub dropped: u32,
    /// How long ago the part's trailing edge left the second barrier, at the step of the reading \[s\].
    pub since: f64,
    /// How long ago its leading edge came to the first barrier \[s\].
    pub came: f64,
    /// [m/s].
    pub speed: f64,
    /// Along the belt \[m\].
    pub length: f64,
    /// Whether a barrier is covered now.
    pub covered: bool,
}

impl GateReading {
    /// How far the middle of the part is beyond the second barrier, `later` \[s\] after the step of the reading \[m\].
    #[must_use]
    pub fn place(&self, later: f64) -> f64 {
        0.5 * self.length + self.speed * (self.since + later)
    }
}

/// Two light barriers over a scene.
#[derive(Debug)]
pub struct GateSensor<S> {
    scene: S,
    /// `X_WL` of both.
    beams: [Pose; 2],
    barriers: [Sampled; 2],
    passages: Passages,
    step: f64,
}

impl<S: Scene + 'static> GateSensor<S> {
    /// The beams run along z of their frames `X_WL`, the second one behind the first as the belt runs; `step` \[s\] is that of the cell.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn new(scene: S, X_WL: [Pose; 2], barriers: [LightBarrier; 2], step: f64) -> Self {
        let spacing = (X_WL[1].translation.vector - X_WL[0].translation.vector).norm();
        Self {
            scene,
            beams: X_WL,
            barriers: barriers.map(Sampled::new),
            passages: Passages::new(spacing),
            step,
        }
    }

    /// One of its barriers, 0 or 1, to break it.
    ///
    /// # Panics
    /// For other numbers.
    pub const fn barrier(&mut self, number: usize) -> &mut LightBarrier {
        self.barriers[number].barrier()
    }
}

impl<S: Scene + 'static> VirtualSensor for GateSensor<S> {
    type Kind = Gate;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<GateReading, Fault> {
        for (number, (barrier, beam)) in self.barriers.iter_mut().zip(&self.beams).enumerate() {
            barrier.sample(&self.scene, |_| *beam, |edge| self.passages.take(number, edge));
        }
        let covered = self.barriers.iter().any(Sampled::is_covered);
        let (parts, dropped) = (self.passages.count(), self.passages.dropped());
        let Some(last) = self.passages.last() else {
            return Ok(GateReading { parts, dropped, covered, ..GateReading::default() });
        };
        let now = order.step as f64 * self.step;
        let (since, came) = (now - last.left, now - last.came);
        Ok(GateReading { parts, dropped, since, came, speed: last.speed, length: last.length, covered })
    }

    fn is_simulated(&self) -> bool {
        true
    }
}
