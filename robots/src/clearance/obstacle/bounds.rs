//! A box along the axes, and what is nearest to it.
//!
//! In: a point or a segment in the frame of the box. Out: its nearest point, or the distance. The squared distance of a point
//! from a box is the sum of the squares of what each coordinate is beyond its face.

use mrroc::pose::Pose;
use nalgebra::{Point3, Vector3};

/// A box along the axes \[m\]; a face may be infinitely far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) low: Vector3<f64>,
    pub(super) high: Vector3<f64>,
}

impl Bounds {
    /// The box that holds nothing: what is joined to it is the whole.
    pub(super) const NOTHING: Bounds = Bounds {
        low: Vector3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Vector3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// The box around a segment, and `radius` \[m\] around that.
    pub(super) fn around([a, b]: &[Vector3<f64>; 2], radius: f64) -> Self {
        Self { low: a.inf(b).add_scalar(-radius), high: a.sup(b).add_scalar(radius) }
    }

    /// The least box that holds both.
    pub(super) fn and(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// The box along the axes of the world around this one, which is finite and along those of O.
    #[allow(non_snake_case)]
    pub(super) fn moved(&self, X_WO: &Pose) -> Self {
        let centre = X_WO.transform_point(&Point3::from((self.low + self.high) * 0.5)).coords;
        let reach = X_WO.rotation.to_rotation_matrix().matrix().abs() * (self.high - self.low) * 0.5;
        Self { low: centre - reach, high: centre + reach }
    }

    /// The point of the box that is nearest to `p`.
    pub(super) fn onto(&self, p: &Vector3<f64>) -> Vector3<f64> {
        p.sup(&self.low).inf(&self.high)
    }

    /// The squared distance of `p` from the box \[m²\].
    pub(super) fn distance_squared(&self, p: &Vector3<f64>) -> f64 {
        (p - self.onto(p)).norm_squared()
    }

    /// The point of a segment that is nearest to the box.
    ///
    /// The squared distance is convex in the part of the segment, and a parabola between the at most six parts where a
    /// coordinate passes a face: its derivative grows, so its zero lies between two of them, found on a line.
    pub(super) fn nearest_of(&self, [a, b]: &[Vector3<f64>; 2]) -> Vector3<f64> {
        let d = b - a;
        let slope = |t: f64| {
            let p = a + d * t;
            d.dot(&(p - self.onto(&p)))
        };
        let mut low = (0.0, slope(0.0));
        let mut high = (1.0, slope(1.0));
        if low.1 >= 0.0 {
            return *a;
        }
        if high.1 <= 0.0 {
            return *b;
        }
        for i in 0..3 {
            for face in [self.low[i], self.high[i]] {
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
}
