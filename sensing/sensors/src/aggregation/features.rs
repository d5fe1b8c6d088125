//! Features of a thing in an image that do not change when it turns: what a network tells classes by.
//!
//! All lengths are on the plane of the belt, undistorted. Brightness is in that of the thing's bright places, so that paint and lamp
//! do not matter.

use nalgebra::Vector2;

use super::blobs::Blob;

/// How many features there are.
pub const FEATURES: usize = 31;
/// Lengths are in this \[m\].
const UNIT: f64 = 0.03;
/// Rings and stripes.
const RINGS: usize = 8;
const STRIPES: usize = 4;

/// Where a thing is in a plane and how it extends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// \[m²\].
    pub area: f64,
    /// Middle of its area \[m\].
    pub centre: Vector2<f64>,
    /// Second central moments over the area: xx, xy, yy \[m²\].
    pub spread: [f64; 3],
}

impl Moments {
    /// Of places with an area each \[m, m²\].
    pub fn of(places: impl Iterator<Item = ([f64; 2], f64)> + Clone) -> Self {
        let (mut area, mut sum) = (0.0, Vector2::zeros());
        for ([x, y], part) in places.clone() {
            area += part;
            sum += Vector2::new(x, y) * part;
        }
        let centre = if area > 0.0 { sum / area } else { sum };
        let mut spread = [0.0; 3];
        for ([x, y], part) in places {
            let (x, y) = (x - centre.x, y - centre.y);
            spread[0] += x * x * part;
            spread[1] += x * y * part;
            spread[2] += y * y * part;
        }
        Self { area, centre, spread: spread.map(|sum| if area > 0.0 { sum / area } else { sum }) }
    }

    /// The angle of its long axis from x, within half a turn \[rad\].
    #[must_use]
    pub fn axis(&self) -> f64 {
        let [xx, xy, yy] = self.spread;
        0.5 * (2.0 * xy).atan2(xx - yy)
    }

    /// Standard deviations along its long and its short axis \[m\].
    #[must_use]
    pub fn extent(&self) -> [f64; 2] {
        let [xx, xy, yy] = self.spread;
        let (mean, half) = (0.5 * (xx + yy), (0.25 * (xx - yy).powi(2) + xy * xy).sqrt());
        [(mean + half).sqrt(), (mean - half).max(0.0).sqrt()]
    }
}

/// The features of a thing: the grey values of an image of this width, with the place and the area of each pixel.
#[must_use]
pub fn features(
    blob: &Blob,
    moments: &Moments,
    image: &[u8],
    width: usize,
    ground: impl Fn(usize) -> ([f64; 2], f64),
) -> [f32; FEATURES] {
    let size = moments.area.sqrt();
    let (sin, cos) = moments.axis().sin_cos();
    let mut histogram = [0_usize; 256];
    blob.pixels.iter().for_each(|&index| histogram[usize::from(image[index])] += 1);
    let mut above = 0;
    let is_bright = |grey: &usize| {
        above += histogram[*grey];
        above * 10 >= blob.pixels.len()
    };
    let bright = (0..256).rev().find(is_bright).unwrap_or(255).max(1) as f64;

    let (mut rings, mut lights) = ([0.0; RINGS], [0.0; RINGS]);
    let (mut along, mut across) = ([[0.0; 2]; STRIPES], [[0.0; 2]; STRIPES]);
    let (mut third, mut third_y, mut deviation) = ([0.0; 4], 0.0, [0.0; 2]);
    let [long, short] = moments.extent();
    for &index in &blob.pixels {
        let ([x, y], area) = ground(index);
        let (x, y) = (x - moments.centre.x, y - moments.centre.y);
        let share = area / moments.area;
        let grey = f64::from(image[index]) / bright;
        let ring = (x.hypot(y) / size * RINGS as f64 / 0.9) as usize;
        let ring = ring.min(RINGS - 1);
        rings[ring] += share;
        lights[ring] += share * grey;
        let (u, v) = ((x * cos + y * sin) / (2.0 * long), (y * cos - x * sin) / (2.0 * short));
        for (stripes, at) in [(&mut along, u), (&mut across, v)] {
            let stripe = &mut stripes[((at.abs() * STRIPES as f64) as usize).min(STRIPES - 1)];
            stripe[0] += share;
            stripe[1] += share * grey;
        }
        // Third moments, as Hu (1962) joins them.
        third[0] += x.powi(3) * share;
        third[1] += x * x * y * share;
        third[2] += x * y * y * share;
        third[3] += y.powi(3) * share;
        deviation[0] += grey * share;
        deviation[1] += grey * grey * share;
        third_y += u * grey * share;
    }
    let cube = size.powi(3);
    let [xxx, xxy, xyy, yyy] = third.map(|sum| sum / cube);
    let hu = [(xxx - 3.0 * xyy).hypot(3.0 * xxy - yyy), (xxx + xyy).hypot(xxy + yyy)];
    let rim = blob.rim(width).len() as f64;
    let count = blob.pixels.len() as f64;
    let mut all = [0.0_f32; FEATURES];
    let shape = [
        size / UNIT,
        long / UNIT,
        short / UNIT,
        rim * rim / count / 16.0,
        blob.holes(width) as f64 / count * 4.0,
        hu[0] * 40.0,
        hu[1] * 40.0,
        (deviation[1] - deviation[0] * deviation[0]).max(0.0).sqrt() * 4.0,
        third_y.abs() * 10.0,
    ];
    // The outermost rings are empty of most things.
    let light = |sum: f64, share: f64| if share > 2e-3 { sum / share } else { 0.0 };
    let ring_shares = rings.iter().take(RINGS - 1).copied();
    let ring_lights = lights.iter().zip(&rings).take(RINGS - 1).map(|(sum, share)| light(*sum, *share));
    let stripes = along.iter().chain(&across).map(|[share, sum]| light(*sum, *share));
    let values = shape.into_iter().chain(ring_shares).chain(ring_lights).chain(stripes);
    all.iter_mut().zip(values).for_each(|(feature, value)| *feature = value as f32);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_moments_of_a_turned_rectangle_are_those_of_geometry() {
        // 60 x 20 mm, turned by 0.3 rad: sigma is the edge by the root of 12.
        let turn = nalgebra::Rotation2::new(0.3);
        let place = |i: u32| {
            let at = Vector2::new(
                f64::from(i % 300) * 2e-4 - 0.03 + 1e-4,
                f64::from(i / 300) * 2e-4 - 0.01 + 1e-4,
            );
            let at = turn * at;
            ([at.x + 0.2, at.y - 0.1], 4e-8)
        };
        let moments = Moments::of((0..30_000).map(place));
        let [long, short] = moments.extent();
        assert!((moments.area - 1.2e-3).abs() < 1e-12 && (moments.axis() - 0.3).abs() < 1e-9, "{moments:?}");
        assert!(
            (long - 0.06 / 12.0_f64.sqrt()).abs() < 1e-6 && (short - 0.02 / 12.0_f64.sqrt()).abs() < 1e-6
        );
        assert!((moments.centre - Vector2::new(0.2, -0.1)).norm() < 1e-9);
    }
}
