//! What stands in the cell: tables, posts, fixtures.

use mrroc::pose::Pose;
use nalgebra::{Point3, Vector3};

use super::gap::Gap;
use crate::models::Capsule;

/// A body that does not move, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Obstacle {
    /// All points `p` with `normal . p <= height` \[m\]: a table, a floor, a wall. `normal` has the length 1.
    HalfSpace {
        /// Away from the obstacle, of length 1.
        normal: Vector3<f64>,
        /// Distance of the surface from the world's origin along `normal` \[m\].
        height: f64,
    },
    /// A post, a pipe, a ball.
    Capsule(Capsule),
    /// A box.
    #[allow(non_snake_case)]
    Box {
        /// The centre of the box, its axes along the edges.
        X_WO: Pose,
        /// Half the edges \[m\], each > 0.
        half: Vector3<f64>,
    },
}

impl Obstacle {
    /// All that lies below `height` \[m\].
    #[must_use]
    pub fn table(height: f64) -> Self {
        Obstacle::HalfSpace { normal: Vector3::z(), height }
    }

    /// Whether its numbers make a body.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        match self {
            Obstacle::HalfSpace { normal, height } => {
                (normal.norm() - 1.0).abs() < 1e-9 && height.is_finite()
            }
            Obstacle::Capsule(capsule) => capsule.is_valid(),
            Obstacle::Box { X_WO, half } => {
                let pose = X_WO.translation.vector.iter().chain(X_WO.rotation.coords.iter());
                pose.chain(half.iter()).all(|x| x.is_finite()) && half.iter().all(|x| *x > 0.0)
            }
        }
    }

    /// The gap to a capsule, whose point comes first. Of a box whose inside the capsule's segment meets, the distance is
    /// the negative radius.
    #[must_use]
    pub fn gap(&self, capsule: &Capsule) -> Gap {
        match self {
            Obstacle::HalfSpace { normal, height } => {
                let heights = capsule.ends.map(|end| normal.dot(&end) - height);
                let lower = usize::from(heights[1] < heights[0]);
                let end = capsule.ends[lower];
                let above = heights[lower];
                let points = [end - normal * capsule.radius, end - normal * above];
                Gap { distance: above - capsule.radius, points }
            }
            Obstacle::Capsule(other) => capsule.gap(other),
            Obstacle::Box { X_WO, half } => {
                let [a, b] = capsule.ends.map(|end| X_WO.inverse_transform_point(&Point3::from(end)).coords);
                let p = nearest_to_box(&a, &(b - a), half);
                let points = [p, onto_box(&p, half)].map(|p| X_WO.transform_point(&Point3::from(p)).coords);
                Gap::between(points, [capsule.radius, 0.0])
            }
        }
    }

    /// A lower bound of the gap to what lies in a ball \[m\].
    pub(super) fn at_least(&self, centre: &Vector3<f64>, radius: f64) -> f64 {
        self.gap(&Capsule::new(*centre, *centre, radius)).distance
    }
}

/// The point of a box around the origin that is nearest to `p`.
fn onto_box(p: &Vector3<f64>, half: &Vector3<f64>) -> Vector3<f64> {
    p.zip_map(half, |x, h| x.clamp(-h, h))
}

/// The point of the segment from `a` along `d` that is nearest to a box around the origin.
///
/// The squared distance is convex in the way along the segment, and a parabola between the at most six ways where a
/// coordinate passes a face: its derivative grows, so its zero lies between two of them, found on a line.
fn nearest_to_box(a: &Vector3<f64>, d: &Vector3<f64>, half: &Vector3<f64>) -> Vector3<f64> {
    let slope = |t: f64| {
        let p = a + d * t;
        d.dot(&(p - onto_box(&p, half)))
    };
    let mut low = (0.0, slope(0.0));
    let mut high = (1.0, slope(1.0));
    if low.1 >= 0.0 {
        return *a;
    }
    if high.1 <= 0.0 {
        return a + d;
    }
    for i in 0..3 {
        for face in [-half[i], half[i]] {
            let t = (face - a[i]) / d[i];
            if t > low.0 && t < high.0 {
                let at = (t, slope(t));
                if at.1 < 0.0 { low = at } else { high = at }
            }
        }
    }
    let t = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1);
    a + d * t
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn above_a_table_the_lower_end_counts() {
        let capsule = Capsule::new(Vector3::new(0.0, 0.0, 1.0), Vector3::new(1.0, 0.0, 0.7), 0.1);
        let gap = Obstacle::table(0.2).gap(&capsule);
        assert!((gap.distance - 0.4).abs() < 1e-15);
        assert!((gap.points[0] - Vector3::new(1.0, 0.0, 0.6)).amax() < 1e-15);
        assert!((gap.points[1] - Vector3::new(1.0, 0.0, 0.2)).amax() < 1e-15);
    }

    proptest! {
        #[test]
        fn the_distance_to_a_box_is_the_least_of_all_points(
            a in proptest::array::uniform3(-2.0..2.0_f64), b in proptest::array::uniform3(-2.0..2.0_f64),
            turn in proptest::array::uniform3(-3.0..3.0_f64),
        ) {
            const N: usize = 2000;
            let half = Vector3::new(0.3, 0.5, 0.2);
            let place = Pose::new(Vector3::new(0.1, -0.2, 0.3), Vector3::from(turn));
            let (a, b) = (Vector3::from(a), Vector3::from(b));
            let distance = Obstacle::Box { X_WO: place, half }.gap(&Capsule::new(a, b, 0.05)).distance + 0.05;
            let sampled = (0..=N).map(|k| {
                let p = a + (b - a) * (k as f64 / N as f64);
                let p = place.inverse() * Point3::from(p);
                // Outside a box, what each coordinate is beyond its face.
                p.coords.zip_map(&half, |x, h| (x.abs() - h).max(0.0)).norm()
            });
            let sampled = sampled.fold(f64::INFINITY, f64::min);
            prop_assert!(distance <= sampled + 1e-12);
            prop_assert!(distance >= sampled - 0.5 * (b - a).norm() / N as f64);
        }
    }
}
