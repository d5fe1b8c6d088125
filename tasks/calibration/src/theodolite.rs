//! A theodolite: what it is as a thing, with the errors that such instruments have.
//!
//! ```text
//! face 1: Hz = hz + c / cos V + i tan V + e,   V = v + v0 + e        face 2: with the signs of c, i and v0 turned
//! ```
//!
//! hz counts from x to y of its frame, v from the level plane upwards. A compensator levels it to within some tenths of a second. The mean of
//! both faces is free of c (collimation), i (trunnion axis) and v0 (index). Figures of precision instruments: 5 to 20 arc seconds for
//! the axes, 0.5 to 5 for a sight.

use mrroc::pose::Pose;
use mrroc::random::Random;
use nalgebra::Vector3;

use crate::random::normal;

/// An arc second \[rad\].
pub const SECOND: f64 = core::f64::consts::PI / 648_000.0;

/// A tenth of a milligon, to which a circle is read \[rad\].
const QUANTUM: f64 = 1e-4 * core::f64::consts::PI / 200_000.0;

/// How far the centre of a ball is missed in a sight \[m\].
const CENTRING: f64 = 2e-5;

/// How level the compensator keeps the instrument \[rad\].
pub const LEVEL: f64 = 0.3 * SECOND;

/// On which face the telescope is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// As usual.
    One,
    /// Turned over.
    Two,
}

/// A theodolite somewhere in the world.
#[derive(Clone, Debug)]
pub struct Theodolite {
    /// Where it truly stands, `X_WI`.
    pub place: Pose,
    /// Collimation, trunnion axis and index \[rad\].
    axes: [f64; 3],
    /// Standard deviation of a sight \[rad\].
    sigma: f64,
    random: Random,
}

impl Theodolite {
    /// One of this accuracy (standard deviation of a sight \[rad\]), at a place about which it is levelled, with axes that are off as `seed` says.
    #[must_use]
    pub fn new(place: Pose, sigma: f64, seed: u64) -> Self {
        let mut random = Random::seeded(seed);
        let tilt = Vector3::new(normal(&mut random), normal(&mut random), 0.0) * LEVEL;
        let axes = [0; 3].map(|_| random.between(-20.0, 20.0) * SECOND);
        Self { place: place * Pose::rotation(tilt), axes, sigma, random }
    }

    /// Sights a point of the world \[m\]: horizontal angle and elevation \[rad\].
    pub fn sight(&mut self, point: &Vector3<f64>, face: Face) -> [f64; 2] {
        let mut normal = || normal(&mut self.random);
        let missed = Vector3::new(normal(), normal(), normal()) * CENTRING;
        let noise = [normal(), normal()].map(|one| one * self.sigma);
        let p = self.place.inverse() * nalgebra::Point3::from(point + missed);
        let (hz, v) = (p.y.atan2(p.x), p.z.atan2(p.x.hypot(p.y)));
        let [c, i, v0] = self.axes;
        let sign = if face == Face::One { 1.0 } else { -1.0 };
        let read = [hz + sign * (c / v.cos() + i * v.tan()) + noise[0], v + sign * v0 + noise[1]];
        read.map(|angle| (angle / QUANTUM).round() * QUANTUM)
    }
}

/// The mean of sights of one target \[rad\]; free of the axes' errors if both faces are in it as often.
#[must_use]
pub fn mean(sights: impl IntoIterator<Item = [f64; 2]>) -> [f64; 2] {
    let (mut first, mut sum, mut count) = (None, [0.0; 2], 0.0_f64);
    for [hz, v] in sights {
        let first: f64 = *first.get_or_insert(hz);
        // Beside half a turn some of them may be on the other side.
        let turns = ((hz - first) / core::f64::consts::TAU).round();
        sum = [sum[0] + hz - turns * core::f64::consts::TAU, sum[1] + v];
        count += 1.0;
    }
    sum.map(|of| of / count.max(1.0))
}
