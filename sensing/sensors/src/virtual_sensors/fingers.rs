//! A light barrier between the fingers of a gripper.

use mrroc::pose::Pose;
use mrroc::prelude::*;

use super::sampled::Sampled;
use crate::physics::LightBarrier;
use crate::scene::Scene;

/// The kind of sensor: whether something is between the fingers.
#[derive(Clone, Copy, Debug)]
pub struct Between;

impl Sensor for Between {
    const KIND: &'static str = "between";
    type Reading = Fingers;
    type Configuration = ();
}

/// What a barrier between fingers says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Fingers {
    /// Whether something is there.
    pub covered: bool,
    /// How often that has changed.
    pub edges: u32,
    /// How long ago it changed last, at the step of the reading \[s\]; 0 before the first change.
    pub since: f64,
}

/// A scene with a tool in it that the barrier moves with.
pub trait Tool: Scene {
    /// `X_WE`, where the tool was so many seconds before the scene's time.
    fn pose_before(&self, before: f64) -> Pose;
}

/// A light barrier at a tool, over a scene.
#[derive(Debug)]
#[allow(non_snake_case)]
pub struct FingerBarrier<S> {
    scene: S,
    X_EL: Pose,
    barrier: Sampled,
    edges: u32,
    last: f64,
    step: f64,
}

impl<S: Tool + 'static> FingerBarrier<S> {
    /// The beam runs along z of its frame `X_EL` at the tool; `step` \[s\] is that of the cell.
    #[must_use]
    #[allow(non_snake_case)]
    pub const fn new(scene: S, X_EL: Pose, barrier: LightBarrier, step: f64) -> Self {
        Self { scene, X_EL, barrier: Sampled::new(barrier), edges: 0, last: 0.0, step }
    }

    /// Its barrier, to break it.
    pub const fn barrier(&mut self) -> &mut LightBarrier {
        self.barrier.barrier()
    }
}

impl<S: Tool + 'static> VirtualSensor for FingerBarrier<S> {
    type Kind = Between;

    #[allow(non_snake_case)]
    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Fingers, Fault> {
        let Self { scene, X_EL, barrier, edges, last, .. } = self;
        let beam = |before| scene.pose_before(before) * *X_EL;
        barrier.sample(scene, beam, |edge| {
            *edges += 1;
            *last = edge.time;
        });
        let since = if self.edges > 0 { order.step as f64 * self.step - self.last } else { 0.0 };
        Ok(Fingers { covered: self.barrier.is_covered(), edges: self.edges, since })
    }

    fn is_simulated(&self) -> bool {
        true
    }
}
