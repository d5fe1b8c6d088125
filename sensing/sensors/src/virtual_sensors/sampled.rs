//! Light barriers at an input card that samples them every millisecond.

use mrroc::pose::Pose;

use crate::aggregation::{Debounce, Edge};
use crate::physics::LightBarrier;
use crate::scene::Scene;

/// A barrier, sampled and debounced.
#[derive(Clone, Debug)]
pub struct Sampled {
    barrier: LightBarrier,
    debounce: Debounce,
    /// Samples that were taken.
    count: u64,
}

impl Sampled {
    /// Time between two samples \[s\].
    pub const PERIOD: f64 = 1e-3;
    /// A burst of chatter is over after so long \[s\].
    const QUIET: f64 = 5e-3;
    /// Of samples that are due, so many at most are taken after a pause: the card keeps no older ones.
    const KEPT: u64 = 20;

    /// A barrier at the card.
    #[must_use]
    pub const fn new(barrier: LightBarrier) -> Self {
        Self { barrier, debounce: Debounce::new(Self::QUIET), count: 0 }
    }

    /// The barrier.
    pub const fn barrier(&mut self) -> &mut LightBarrier {
        &mut self.barrier
    }

    /// Whether it is covered, chatter aside.
    #[must_use]
    pub const fn is_covered(&self) -> bool {
        self.debounce.is_covered()
    }

    /// Takes all samples that are due, and hands on each edge. The beam L was at `X_WL(t)` so many seconds before the scene's time.
    #[allow(non_snake_case)]
    pub fn sample(&mut self, scene: &dyn Scene, X_WL: impl Fn(f64) -> Pose, mut edge: impl FnMut(Edge)) {
        let due = (scene.now() / Self::PERIOD + 1e-6) as u64;
        self.count = self.count.max(due.saturating_sub(Self::KEPT));
        while self.count < due {
            self.count += 1;
            let time = self.count as f64 * Self::PERIOD;
            let covered = self.barrier.sample(scene, &X_WL(scene.now() - time), time);
            if let Some(seen) = self.debounce.take(time, covered) {
                // The barrier's mean delay is known.
                edge(Edge { time: seen.time - LightBarrier::DELAY, ..seen });
            }
        }
    }
}
