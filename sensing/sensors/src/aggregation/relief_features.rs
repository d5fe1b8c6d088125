//! Features of a relief that do not change when the thing turns: what a network tells classes by.

use nalgebra::{Rotation2, Vector2};

use super::features::Moments;
use super::relief::Relief;

/// How many features there are.
pub const RELIEF_FEATURES: usize = 42;
/// Lengths are in this, and heights \[m\].
const UNIT: f64 = 0.03;
const HEIGHT: f64 = 0.04;
/// What stands out of the belt, and higher levels \[m\].
const LEVELS: [f64; 8] = [0.008, 0.014, 0.020, 0.024, 0.028, 0.031, 0.034, 0.037];
/// Rings about the middle, and their width \[m\].
const RINGS: usize = 8;
const RING: f64 = 0.007;

/// A place with its height, and how loud it is.
type Spot = (Vector2<f64>, f64, f64);

/// The features of a relief.
#[must_use]
pub fn relief_features(relief: &Relief) -> [f32; RELIEF_FEATURES] {
    let spots: Vec<Spot> = relief
        .samples
        .iter()
        .filter_map(|sample| {
            sample.heard.map(|[z, loud]| (Vector2::new(sample.along, sample.across), z, loud))
        })
        .collect();
    // What was lost is made up for by what is about it.
    let share = spots.len() as f64 / relief.samples.len().max(1) as f64;
    let area = relief.area / share.max(0.1);
    let above = |level: f64| {
        let places =
            spots.iter().filter(move |spot| spot.1 > level).map(move |spot| ([spot.0.x, spot.0.y], area));
        Moments::of(places)
    };
    let levels = LEVELS.map(above);
    let [all, ..] = levels;
    let centre = all.centre;

    let (mut count, mut height, mut square, mut loud) =
        ([0.0; RINGS], [0.0; RINGS], [0.0; RINGS], [0.0; RINGS]);
    let mut waves = [Vector2::<f64>::zeros(); 3];
    let (mut sum, mut loudness, mut loud_square) = (0.0, 0.0, 0.0);
    for (at, z, strength) in &spots {
        let off = at - centre;
        let ring = (off.norm() / RING) as usize;
        let z = (z / HEIGHT).clamp(-0.25, 1.5);
        if ring < RINGS {
            count[ring] += 1.0;
            height[ring] += z;
            square[ring] += z * z;
            loud[ring] += strength.min(2.0);
        }
        if z * HEIGHT > LEVELS[0] {
            let unit = off.x.hypot(off.y).max(1e-9);
            for (wave, order) in waves.iter_mut().zip([2, 3, 4]) {
                let angle = f64::from(order) * off.y.atan2(off.x);
                *wave += Rotation2::new(angle) * Vector2::x() * (z * unit / UNIT);
            }
            sum += 1.0;
            loudness += strength.min(2.0);
            loud_square += strength.min(2.0).powi(2);
        }
    }
    let count = count.map(|count: f64| count.max(1.0));
    let sum = f64::max(sum, 1.0);
    let [long, short] = all.extent();
    let [long_high, short_high] = levels[4].extent();
    let mean = loudness / sum;
    let shape = [
        long / UNIT,
        short / UNIT,
        long_high / UNIT,
        short_high / UNIT,
        mean,
        (loud_square / sum - mean * mean).max(0.0).sqrt(),
    ];
    let sizes = levels.iter().map(|level| level.area.sqrt() / UNIT);
    let shifts = [2, 5].map(|level: usize| {
        let level = &levels[level];
        if level.area > 0.0 { (level.centre - centre).norm() / 0.01 } else { 0.0 }
    });
    let rings = (0..RINGS).map(|ring| height[ring] / count[ring]);
    let rough = (0..RINGS - 1).map(|ring| {
        let mean = height[ring] / count[ring];
        2.0 * (square[ring] / count[ring] - mean * mean).max(0.0).sqrt()
    });
    let louds = (0..RINGS).map(|ring| loud[ring] / count[ring]);
    let waves = waves.map(|wave| wave.norm() / sum);
    let values =
        shape.into_iter().chain(sizes).chain(shifts).chain(rings).chain(rough).chain(louds).chain(waves);
    let mut features = [0.0_f32; RELIEF_FEATURES];
    features.iter_mut().zip(values).for_each(|(feature, value)| *feature = value as f32);
    features
}
