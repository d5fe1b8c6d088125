//! A triangulation sensor for distances, as the infrared ones of Sharp: a code from an analog-to-digital converter of 10 bits.
//!
//! ```text
//! code = 4835 / (d / cm) + 28.76        fit of 25 measured points, 0.27 cm root mean square
//! ```
//!
//! It measures for 38 ms, and gives the mean of that as a new value. What is nearer than [`NEAREST`] folds back to smaller codes, as of
//! something far; at times it gives a 0.

use mrroc::pose::Pose;
use mrroc::random::Noise;

use crate::scene::Scene;

/// Where the curve turns \[m\]: nearer objects look farther.
const NEAREST: f64 = 0.08;
/// Codes per inverse distance \[cm\], and the code of something infinitely far.
const CURVE: [f64; 2] = [4835.0, 28.76];
/// The largest code.
const FULL: f64 = 1023.0;

/// The code of a distance \[m\], > 0, without noise.
#[must_use]
pub fn code_of(distance: f64) -> f64 {
    // Below the turn the spot leaves the detector, and less and less of it is seen.
    let folded = if distance < NEAREST { NEAREST * NEAREST / distance.max(1e-3) } else { distance };
    CURVE[0] / (folded * 100.0) + CURVE[1]
}

/// The distance \[m\] that a code says; infinite below the curve.
#[must_use]
pub fn distance_of(code: f64) -> f64 {
    if code > CURVE[1] { CURVE[0] / (code - CURVE[1]) / 100.0 } else { f64::INFINITY }
}

/// A triangulation sensor.
#[derive(Clone, Debug)]
pub struct Triangulation {
    background: f64,
    noise: f64,
    zeros: f64,
    random: Noise,
    /// When the value that it gives was finished \[s\], and that value.
    last: (f64, u32),
    sum: f64,
    parts: u32,
}

impl Triangulation {
    /// Time between two values \[s\].
    pub const UPDATE: f64 = 0.038;
    /// How often it looks while it measures one value.
    const LOOKS: u32 = 4;
    /// By how much the code of something black is above that of something white, as a share.
    const BLACK: f64 = 0.02;

    /// A sensor that sees something at `background` \[m\] where nothing is nearer: noise of 2 codes, and one value in 50 is a 0.
    #[must_use]
    pub const fn new(background: f64, seed: u64) -> Self {
        let random = Noise::seeded(seed);
        Self { background, noise: 2.0, zeros: 0.02, random, last: (0.0, 0), sum: 0.0, parts: 0 }
    }

    /// The same sensor with this noise in codes, >= 0, and this share of zeros, 0 to 1.
    #[must_use]
    pub const fn with_noise(self, noise: f64, zeros: f64) -> Self {
        Self { noise, zeros, ..self }
    }

    /// When its value was finished \[s\], and the code; at the scene's time. It looks along z of its frame L, at `X_WL`, and is to be
    /// asked at least every 10 ms.
    #[allow(non_snake_case)]
    pub fn sample(&mut self, scene: &dyn Scene, X_WL: &Pose) -> (f64, u32) {
        let now = scene.now();
        let share = Self::UPDATE / f64::from(Self::LOOKS);
        while now - self.last.0 >= f64::from(self.parts + 1) * share {
            let before = now - self.last.0 - f64::from(self.parts + 1) * share;
            self.sum += self.look(scene, X_WL, before);
            self.parts += 1;
            if self.parts == Self::LOOKS {
                let mean = self.sum / f64::from(Self::LOOKS) + self.noise * self.random.normal();
                let is_zero = self.random.uniform() <= self.zeros;
                let code = if is_zero { 0.0 } else { mean.round().clamp(0.0, FULL) };
                self.last = (self.last.0 + Self::UPDATE, code as u32);
                (self.sum, self.parts) = (0.0, 0);
            }
        }
        self.last
    }

    /// The code of what is nearest.
    #[allow(non_snake_case)]
    fn look(&self, scene: &dyn Scene, X_WL: &Pose, before: f64) -> f64 {
        let mut nearest = (self.background, 1.0);
        scene.each_solid(&mut |solid| {
            let off = X_WL.inverse() * nalgebra::Point3::from(solid.pose.translation.vector);
            // Most solids are far from the ray.
            let near = off.coords.xy().norm_squared()
                < solid.hull.iter().map(|p| p.norm_squared()).fold(0.0, f64::max) + 1e-4;
            if let Some(distance) = near.then(|| solid.meets(X_WL, before)).flatten()
                && distance < nearest.0
            {
                nearest = (distance, solid.reflectance);
            }
        });
        code_of(nearest.0) * (1.0 + Self::BLACK * (1.0 - nearest.1))
    }
}
