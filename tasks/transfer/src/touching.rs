//! Both arms touch the same points with a tip, one after the other: what their controllers say then, for `calibrate bases`.
//!
//! Each arm is taken by hand or by jogging until its tip is in a small cone on the table. What is simulated is where its controller believes the
//! tip to be then: in its own base, which is elsewhere than programs believe, and off by what a person misses a cone by.

use mrroc::pose::Pose;
use mrroc::random::Random;
use nalgebra::{Point3, Vector3};

use crate::places::{TABLE, polycrank_base, table};
use crate::plant::calibration_error;

/// By how much a tip is off in a cone, as a standard deviation along each axis \[m\] (assumed).
pub const MISSED: f64 = 3e-5;

/// Points on posts of different heights about the table, as far apart as both arms reach \[m\].
#[must_use]
pub fn points() -> [Vector3<f64>; 6] {
    let middle = table().translation;
    let at = |x: f64, y: f64, height: f64| Vector3::new(middle.x + x, middle.y + y, TABLE + height);
    [
        at(-0.25, -0.35, 0.02),
        at(0.25, -0.35, 0.12),
        at(0.25, 0.35, 0.02),
        at(-0.25, 0.35, 0.12),
        at(0.0, 0.0, 0.2),
        at(0.0, -0.1, 0.02),
    ]
}

/// By point and arm what the arm's controller says of its tip, in its base \[m\]; Polycrank's base is off by [`calibration_error`].
#[must_use]
pub fn touches(seed: u64) -> Vec<(String, String, Vector3<f64>)> {
    let bases = [("rnt", Pose::identity()), ("polycrank", polycrank_base() * calibration_error())];
    let mut random = Random::seeded(seed);
    let mut all = Vec::new();
    for (i, point) in points().into_iter().enumerate() {
        for (arm, base) in bases {
            let missed = Vector3::from_fn(|_, _| noise(&mut random) * MISSED);
            let said = (base.inverse() * Point3::from(point + missed)).coords;
            all.push((format!("P{}", i + 1), arm.to_owned(), said));
        }
    }
    all
}

/// The sum of twelve numbers, which is nearly normally distributed.
fn noise(random: &mut Random) -> f64 {
    (0..12).map(|_| random.unit()).sum::<f64>() - 6.0
}
