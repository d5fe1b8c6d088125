//! The radius that a capsule may have: no point of it farther than the excess from the filled volume.
//!
//! Around each point `c` of its segment a ball of radius `excess - f(c)` may be drawn (`solid.rs`), so the radius is the least of
//! these. As `f` changes by at most the length of a move, between two points that are `l` apart it is nowhere above `(f + f' + l) / 2`:
//! the segment is halved until that is within a tolerance of the largest level that was seen.

use nalgebra::Vector3;

use super::solid::Solid;

/// The radius that a capsule with these ends may have \[m\], if it is above 0: at most `tolerance` \[m\] less than the largest one.
pub(super) fn radius(solid: &Solid, [a, b]: [Vector3<f64>; 2], excess: f64, tolerance: f64) -> Option<f64> {
    let level = |point: &Vector3<f64>| solid.level_below(point, excess);
    let (first, last) = (level(&a)?, level(&b)?);
    let length = (b - a).norm();
    if length == 0.0 {
        return Some(excess - first);
    }
    let mut worst = first.max(last);
    let mut open = vec![(0.0, 1.0, first, last)];
    while let Some((from, to, at_from, at_to)) = open.pop() {
        let highest = 0.5 * (at_from + at_to + (to - from) * length);
        if highest > worst + tolerance {
            let middle = 0.5 * (from + to);
            let at_middle = level(&(a + (b - a) * middle))?;
            worst = worst.max(at_middle);
            open.push((from, middle, at_from, at_middle));
            open.push((middle, to, at_middle, at_to));
        }
    }
    let radius = excess - worst - tolerance;
    (radius > 0.0).then_some(radius)
}
