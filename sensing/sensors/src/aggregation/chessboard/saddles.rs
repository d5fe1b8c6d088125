//! Saddles of grey values: places around which dark and bright quarters alternate.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Vector2;

use super::grey::Smooth;

/// A saddle, and the edges that meet there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Saddle {
    /// \[pixel\].
    pub(super) at: Vector2<f64>,
    /// The directions of two edges \[rad, 0..pi, from u to v\]: going round from u to v, at the first one dark becomes bright, at the other one bright
    /// becomes dark.
    pub(super) edges: [f64; 2],
}

/// Samples on a circle around a saddle, and its radius \[pixel\].
const RING: usize = 32;
const RADIUS: f64 = 4.5;
/// Saddles are told from noise at this standard deviation of the smoothing \[pixel\].
const SMOOTH: f32 = 1.4;
/// Of weaker saddles, as a share of the strongest, there are too many.
const WEAK: f32 = 3e-3;
/// No more of them are looked at.
const MOST: usize = 6000;
/// Grey values of a ring spread at least so much around their mean.
const CONTRAST: f64 = 4.0;
/// How alike opposite halves of a ring are at least: 1 of the same.
const ALIKE: f64 = 0.5;

/// All saddles of an image, the sharpest first.
pub(super) fn saddles(image: &Smooth) -> Vec<Saddle> {
    let smooth = image.blurred(SMOOTH);
    let (width, height) = (smooth.width, smooth.height);
    let rim = RADIUS.ceil() as usize + 1;
    if width <= 2 * rim || height <= 2 * rim {
        return Vec::new();
    }
    let value = |x: usize, y: usize| smooth.values[y * width + x];
    let mut sharp = vec![0.0_f32; width * height];
    for y in 1..height - 1 {
        for x in 1..width - 1 {
            let here = value(x, y);
            let xx = value(x + 1, y) + value(x - 1, y) - 2.0 * here;
            let yy = value(x, y + 1) + value(x, y - 1) - 2.0 * here;
            let xy = 0.25
                * (value(x + 1, y + 1) + value(x - 1, y - 1) - value(x + 1, y - 1) - value(x - 1, y + 1));
            sharp[y * width + x] = xy * xy - xx * yy;
        }
    }
    let most = sharp.iter().copied().fold(0.0, f32::max);
    let mut peaks: Vec<(f32, usize)> = Vec::new();
    for y in rim..height - rim {
        for x in rim..width - rim {
            let here = sharp[y * width + x];
            let largest = || (y - 2..=y + 2).all(|v| (x - 2..=x + 2).all(|u| sharp[v * width + u] <= here));
            if here > WEAK * most && largest() {
                peaks.push((here, y * width + x));
            }
        }
    }
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    peaks.truncate(MOST);
    let told = |(_, index): (f32, usize)| {
        let at = Vector2::new((index % width) as f64, (index / width) as f64);
        Some(Saddle { at, edges: edges(&smooth, &at)? })
    };
    peaks.into_iter().filter_map(told).collect()
}

/// The edges that cross a ring; `None` if it is not that of a saddle.
fn edges(smooth: &Smooth, at: &Vector2<f64>) -> Option<[f64; 2]> {
    let place = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / RING as f64).sin_cos();
        at + Vector2::new(cos, sin) * RADIUS
    };
    let mut ring: [f64; RING] = core::array::from_fn(|k| smooth.at(&place(k)));
    let mean = ring.iter().sum::<f64>() / RING as f64;
    ring.iter_mut().for_each(|grey| *grey -= mean);
    let square: f64 = ring.iter().map(|grey| grey * grey).sum();
    let opposite: f64 = (0..RING).map(|k| ring[k] * ring[(k + RING / 2) % RING]).sum();
    if square < CONTRAST * CONTRAST * RING as f64 || opposite < ALIKE * square {
        return None;
    }
    let (mut angles, mut count) = ([[0.0; 2]; 2], [0; 2]);
    for k in 0..RING {
        let (a, b) = (ring[k], ring[(k + 1) % RING]);
        if (a < 0.0) == (b < 0.0) {
            continue;
        }
        let kind = usize::from(b < 0.0);
        *angles[kind].get_mut(count[kind])? = TAU / RING as f64 * (k as f64 + a / (a - b));
        count[kind] += 1;
    }
    // Both ends of each edge, which are about half a turn apart.
    let line = |[a, b]: [f64; 2]| {
        let off = apart(a, b);
        (off.abs() < 0.6).then(|| (a + 0.5 * off).rem_euclid(PI))
    };
    if count != [2, 2] {
        return None;
    }
    Some([line(angles[0])?, line(angles[1])?])
}

/// How far the direction of one line is from that of another \[rad, -pi/2 to pi/2\].
pub(super) fn apart(from: f64, to: f64) -> f64 {
    (to - from + FRAC_PI_2).rem_euclid(PI) - FRAC_PI_2
}
