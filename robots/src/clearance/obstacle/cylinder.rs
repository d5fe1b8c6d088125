//! The point of a segment that is nearest to a solid cylinder.
//!
//! In: a segment in the frame of the cylinder, whose axis is z and whose centre is the origin. Out: its nearest point `p(t)`.
//! With `c(p)` the cylinder's point nearest to `p`, half the squared distance is convex in `t` and has the derivative
//! `d . (p - c(p))`, which never falls: its zero is enclosed, and the enclosure narrowed by the Illinois method (Dowell and
//! Jarratt, BIT 11, 1971), halved where that is slow.

use nalgebra::{Vector2, Vector3};

/// How narrow the enclosure of `t` becomes.
const NARROW: f64 = 1e-13;
/// Halving alone reaches it in 44 rounds, and every third round halves.
const ROUNDS: usize = 140;

/// The point of the cylinder that is nearest to `p`.
pub(super) fn onto(p: &Vector3<f64>, radius: f64, half_length: f64) -> Vector3<f64> {
    let across = Vector2::new(p.x, p.y);
    let far = across.norm();
    let across = if far > radius { across * (radius / far) } else { across };
    Vector3::new(across.x, across.y, p.z.clamp(-half_length, half_length))
}

/// The point of the segment that is nearest to the cylinder.
pub(super) fn nearest_of([a, b]: &[Vector3<f64>; 2], radius: f64, half_length: f64) -> Vector3<f64> {
    let d = b - a;
    let slope = |t: f64| {
        let p = a + d * t;
        d.dot(&(p - onto(&p, radius, half_length)))
    };
    let (mut low, mut high) = ((0.0, slope(0.0)), (1.0, slope(1.0)));
    if low.1 >= 0.0 {
        return *a;
    }
    if high.1 <= 0.0 {
        return *b;
    }
    // The slopes that the method uses: one that stays for a second round counts half.
    let (mut weighed, mut last_was_low) = ([low.1, high.1], None);
    for round in 0..ROUNDS {
        let width = high.0 - low.0;
        if width < NARROW {
            break;
        }
        let part = if round % 3 == 2 { 0.5 } else { weighed[0] / (weighed[0] - weighed[1]) };
        let t = low.0 + width * part;
        let at = (t, slope(t));
        if at.1 == 0.0 {
            return a + d * t;
        }
        let is_low = at.1 < 0.0;
        if is_low {
            low = at
        } else {
            high = at
        }
        let stays = usize::from(is_low);
        weighed[1 - stays] = at.1;
        if last_was_low == Some(is_low) {
            weighed[stays] *= 0.5;
        }
        last_was_low = Some(is_low);
    }
    // Of the two ends of the enclosure the nearer one: of the slopes the smaller.
    a + d * if -low.1 < high.1 { low.0 } else { high.0 }
}
