//! The distance between two capsules in closed form.
//!
//! In: two segments with their radii. Out: the nearest points of the segments, after Ericson, *Real-Time Collision
//! Detection* (2005), section 5.1.9: with `d1 = b1 - a1`, `d2 = b2 - a2`, `r = a1 - a2`, the points `a1 + s d1`,
//! `a2 + t d2` are nearest where
//!
//! ```text
//! s = (d1.d2 d2.r - d1.r d2.d2) / (d1.d1 d2.d2 - (d1.d2)^2),    t = (d1.d2 s + d2.r) / d2.d2
//! ```
//!
//! each brought into 0..1, `t` first and `s` again for it. Why no library does this: decision 3.

use nalgebra::Vector3;

use crate::models::Capsule;

impl Capsule {
    /// The gap to another capsule.
    #[must_use]
    pub fn gap(&self, other: &Self) -> Gap {
        let [p, q] = nearest_points(&self.ends, &other.ends);
        Gap::between([p, q], [self.radius, other.radius])
    }

    /// The distance of a point from its surface \[m\]; below 0 inside, at least minus the radius.
    #[must_use]
    pub fn distance(&self, point: &Vector3<f64>) -> f64 {
        let [a, b] = &self.ends;
        let d = b - a;
        let length = d.norm_squared();
        let part = if length > 0.0 { (d.dot(&(point - a)) / length).clamp(0.0, 1.0) } else { 0.0 };
        (point - a - d * part).norm() - self.radius
    }
}

/// The distance between two bodies, and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Distance of the surfaces \[m\]; below 0, how deep the bodies overlap along the line of the points.
    pub distance: f64,
    /// The nearest points on the surfaces \[m\]; where the segments themselves meet, the points of the segments.
    pub points: [Vector3<f64>; 2],
}

impl Gap {
    /// The gap of bodies that reach `radii` \[m\] around the points `p`, `q` of their cores.
    pub(super) fn between([p, q]: [Vector3<f64>; 2], radii: [f64; 2]) -> Self {
        let line = q - p;
        let length = line.norm();
        let direction = if length > 0.0 { line / length } else { Vector3::zeros() };
        let points = [p + direction * radii[0], q - direction * radii[1]];
        Self { distance: length - radii[0] - radii[1], points }
    }
}

/// The points of two segments that are nearest to one another; of parallel ones, one such pair.
fn nearest_points([a1, b1]: &[Vector3<f64>; 2], [a2, b2]: &[Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
    let (d1, d2, r) = (b1 - a1, b2 - a2, a1 - a2);
    let aa = d1.norm_squared();
    let bb = d2.norm_squared();
    let ab = d1.dot(&d2);
    let (ar, br) = (d1.dot(&r), d2.dot(&r));
    let inside = |part: f64, whole: f64| if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.0 };
    // Of parallel segments every s will do; a part of 1e-14 of the product is round-off.
    let determinant = aa * bb - ab * ab;
    let s = if determinant > 1e-14 * aa * bb { inside(ab * br - ar * bb, determinant) } else { 0.0 };
    let t = inside(ab * s + br, bb);
    let s = inside(ab * t - ar, aa);
    [a1 + d1 * s, a2 + d2 * t]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(x: f64, y: f64, z: f64) -> Vector3<f64> {
        Vector3::new(x, y, z)
    }

    fn gap(a: [Vector3<f64>; 2], b: [Vector3<f64>; 2]) -> f64 {
        Capsule::new(a[0], a[1], 0.1).gap(&Capsule::new(b[0], b[1], 0.2)).distance
    }

    #[test]
    fn capsules_in_known_positions_have_the_distances_of_geometry() {
        let along_x = [at(0.0, 0.0, 0.0), at(2.0, 0.0, 0.0)];
        let cases = [
            // Parallel and beside one another, one behind the other, touching at the ends.
            ([at(0.5, 1.0, 0.0), at(1.5, 1.0, 0.0)], 1.0),
            ([at(5.0, 0.0, 0.0), at(3.0, 0.0, 0.0)], 1.0),
            ([at(5.0, 0.0, 0.0), at(5.0, 4.0, 0.0)], 3.0),
            // Crossed at a right angle, 0.7 above.
            ([at(1.0, -1.0, 0.7), at(1.0, 1.0, 0.7)], 0.7),
            // Past the end: 3, 4, 5.
            ([at(5.0, 4.0, 0.0), at(9.0, 4.0, 0.0)], 5.0),
            // A ball.
            ([at(1.0, 0.0, 2.0), at(1.0, 0.0, 2.0)], 2.0),
            // They meet: both radii deep.
            ([at(1.0, -1.0, 0.0), at(1.0, 1.0, 0.0)], 0.0),
            // On one line, overlapping.
            ([at(1.0, 0.0, 0.0), at(3.0, 0.0, 0.0)], 0.0),
        ];
        for (other, axes) in cases {
            assert!((gap(along_x, other) - (axes - 0.3)).abs() < 1e-15, "{other:?}");
            assert!((gap([other[1], other[0]], along_x) - (axes - 0.3)).abs() < 1e-15, "{other:?}");
        }
    }

    #[test]
    fn points_of_a_gap_lie_on_the_surfaces_at_its_distance() {
        let one = Capsule::new(at(0.0, 0.0, 0.0), at(2.0, 0.0, 0.0), 0.1);
        let gap = one.gap(&Capsule::new(at(1.0, -1.0, 0.7), at(1.0, 1.0, 0.7), 0.2));
        assert!((gap.points[0] - at(1.0, 0.0, 0.1)).amax() < 1e-15);
        assert!((gap.points[1] - at(1.0, 0.0, 0.5)).amax() < 1e-15);
    }

    #[test]
    fn distances_agree_with_those_of_parry() {
        let (mut count, text) = (0, include_str!("../../tests/reference/capsules_parry.csv"));
        for row in text.lines().skip(1) {
            let n: Vec<f64> = row.split(',').map(|n| n.parse().unwrap()).collect();
            let p = |i: usize| at(n[i], n[i + 1], n[i + 2]);
            let distance = gap([p(0), p(3)], [p(6), p(9)]) + 0.3;
            // GJK ends at 1e-7 or so.
            assert!((distance - n[12]).abs() < 1e-6, "{row}: {distance}");
            count += 1;
        }
        assert!(count > 250);
    }

    #[test]
    fn capsules_that_cover_a_box_hold_its_corners() {
        for across in 1..4 {
            let edges = at(0.1, 0.4, 0.2);
            let capsules = Capsule::covering_box(edges, across);
            assert_eq!(capsules.len(), across * across);
            for i in 0..1000 {
                // Points on a grid of 10 x 10 x 10 over the box, its surface included.
                let part = |k: i32| f64::from(i / 10_i32.pow(k as u32) % 10) / 9.0 - 0.5;
                let p = edges.component_mul(&at(part(0), part(1), part(2)));
                let ball = Capsule::new(p, p, 1e-12);
                assert!(capsules.iter().any(|capsule| capsule.gap(&ball).distance < 1e-12), "{p}");
            }
        }
    }

    prop_compose! {
        fn segment()(p in proptest::array::uniform6(-1.0..1.0_f64)) -> [Vector3<f64>; 2] {
            [at(p[0], p[1], p[2]), at(p[3], p[4], p[5])]
        }
    }

    proptest! {
        #[test]
        fn no_points_of_two_segments_are_nearer_and_some_are_as_near(a in segment(), b in segment()) {
            const N: usize = 60;
            let on = |s: &[Vector3<f64>; 2], k: usize| s[0] + (s[1] - s[0]) * (k as f64 / N as f64);
            let pairs = (0..=N).flat_map(|i| (0..=N).map(move |j| (i, j)));
            let sampled = pairs.map(|(i, j)| (on(&a, i) - on(&b, j)).norm()).fold(f64::INFINITY, f64::min);
            let distance = gap(a, b) + 0.3;
            prop_assert!(distance <= sampled + 1e-12);
            // No point of a segment is farther than half a step from a sample.
            let step = ((a[1] - a[0]).norm() + (b[1] - b[0]).norm()) / N as f64;
            prop_assert!(distance >= sampled - 0.5 * step);
            prop_assert!((gap(b, a) - gap(a, b)).abs() < 1e-12);
        }

        /// Nearly parallel segments are the hard case: the distance must be that of points on both.
        #[test]
        fn nearly_parallel_segments_lose_no_distance(
            a in segment(), shift in -1.0..1.0_f64, tilt in -9.0..-3.0_f64,
        ) {
            let d = a[1] - a[0];
            prop_assume!(d.norm() > 0.1);
            let across = d.cross(&at(0.3, 0.5, -0.7)).normalize();
            let b = [a[0] + d * shift + across * 0.4, a[1] + d * shift + across * (0.4 + 10_f64.powf(tilt))];
            // Within the stretch that both share, they are 0.4 apart at least; else past an end.
            let past = (shift.abs() - 1.0).max(0.0) * d.norm();
            let expected = (0.16 + past * past).sqrt();
            let distance = gap(a, b) + 0.3;
            prop_assert!(distance >= expected - 1e-9 && distance <= expected + 10_f64.powf(tilt) + 1e-9);
        }
    }
}
