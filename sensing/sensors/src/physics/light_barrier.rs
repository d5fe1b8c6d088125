//! A light barrier: a round beam, a receiver that switches where enough of it is covered, and the time that takes.
//!
//! ```text
//! level(t)  = share of the beam that solids cover + noise
//! output(t) : covered from level(t - d) > threshold + h on, open from level(t - d) < threshold - h on
//! d         = 0.5 ms +- 0.1 ms, anew for each sample: jitter
//! ```
//!
//! Where an edge passes slowly, or a round part comes near the threshold, noise switches the output to and fro: chatter.

use mrroc::pose::Pose;
use mrroc::random::Noise;

use crate::scene::Scene;

/// A through-beam light barrier.
#[derive(Clone, Debug)]
pub struct LightBarrier {
    radius: f64,
    threshold: f64,
    noise: f64,
    random: Noise,
    covered: bool,
    /// From when on it is broken \[s\], and how.
    stuck: Option<(f64, Stuck)>,
}

/// What a barrier that is broken gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stuck {
    /// Always covered: its lamp is off, or its lens is dirty.
    Covered,
    /// Always open: its output has a short circuit.
    Open,
}

impl LightBarrier {
    /// The mean time from a level to the output \[s\].
    pub const DELAY: f64 = 5e-4;
    /// The time from a level to the output differs from its mean by at most this \[s\].
    pub const JITTER: f64 = 1e-4;
    /// Half of the hysteresis, in the beam's area.
    pub const HYSTERESIS: f64 = 0.005;

    /// A barrier with a beam of this diameter \[m\], > 0. It switches where half of it is covered, but for a deviation of up to 5 % of the
    /// beam that the seed draws; the level has noise of 1 %.
    #[must_use]
    pub fn new(diameter: f64, seed: u64) -> Self {
        let mut random = Noise::seeded(seed);
        let threshold = random.between(0.45, 0.55);
        Self { radius: 0.5 * diameter, threshold, noise: 0.01, random, covered: false, stuck: None }
    }

    /// The same barrier that switches at this share of the beam, 0 to 1, with this noise of the level.
    #[must_use]
    pub const fn switching_at(self, threshold: f64, noise: f64) -> Self {
        Self { threshold, noise, ..self }
    }

    /// Breaks it from a time on, on the scene's clock \[s\].
    pub const fn fail(&mut self, from: f64, stuck: Stuck) {
        self.stuck = Some((from, stuck));
    }

    /// Whether its output says "covered" at `time` \[s\], at most the scene's time and shortly before it. The beam runs along z of its frame
    /// L, at `X_WL`, through the whole scene.
    #[allow(non_snake_case)]
    pub fn sample(&mut self, scene: &dyn Scene, X_WL: &Pose, time: f64) -> bool {
        let delay = Self::DELAY + self.random.between(-Self::JITTER, Self::JITTER);
        let before = scene.now() - time + delay;
        let mut level = self.noise * self.random.normal();
        scene.each_solid(&mut |solid| level += solid.covers(X_WL, self.radius, before));
        if level > self.threshold + Self::HYSTERESIS {
            self.covered = true;
        } else if level < self.threshold - Self::HYSTERESIS {
            self.covered = false;
        }
        match self.stuck.filter(|(from, _)| time >= *from) {
            None => self.covered,
            Some((_, Stuck::Covered)) => true,
            Some((_, Stuck::Open)) => false,
        }
    }
}
