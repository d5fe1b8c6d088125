//! Capsules, and the distance between two of them in closed form.
//!
//! In: two segments with their radii. Out: the nearest points of the segments, after Ericson, *Real-Time Collision
//! Detection* (2005), section 5.1.9: with `d1 = b1 - a1`, `d2 = b2 - a2`, `r = a1 - a2`, the points `a1 + s d1`,
//! `a2 + t d2` are nearest where
//!
//! ```text
//! s = (d1.d2 d2.r - d1.r d2.d2) / (d1.d1 d2.d2 - (d1.d2)^2),    t = (d1.d2 s + d2.r) / d2.d2
//! ```
//!
//! each brought into 0..1, `t` first and `s` again for it. Why no library does this: decision 12.

use mrroc::Pose;
use nalgebra::{Point3, Vector3};

/// All points within `radius` of a segment; a ball where its ends are one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// Ends of the segment \[m\].
    pub ends: [Vector3<f64>; 2],
    /// Radius \[m\], finite, > 0.
    pub radius: f64,
}

impl Capsule {
    /// A capsule with the ends `a`, `b` \[m\] of its segment and `radius` \[m\].
    #[must_use]
    pub const fn new(a: Vector3<f64>, b: Vector3<f64>, radius: f64) -> Self {
        Self { ends: [a, b], radius }
    }

    /// Capsules that together cover a box whose centre is the origin, with edges of `edges` \[m\] along the axes: side by
    /// side along the longest edge, `across` of them in each of the two other directions, at least 1.
    ///
    /// Each covers a rod of rectangular section and its caps stand out at both ends: by half the diagonal of the
    /// section, which is what the model is larger than the box; more capsules fit it better.
    #[must_use]
    pub fn covering_box(edges: Vector3<f64>, across: usize) -> Vec<Self> {
        let (along, n) = (edges.imax(), across.max(1));
        let [u, v] = [(along + 1) % 3, (along + 2) % 3];
        let (width, height) = (edges[u] / n as f64, edges[v] / n as f64);
        let radius = 0.5 * width.hypot(height);
        let place = |k: usize, size: f64, edge: f64| (k as f64 + 0.5) * size - 0.5 * edge;
        let rods = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let capsules = rods.map(|(i, j)| {
            let mut end = Vector3::zeros();
            (end[u], end[v]) = (place(i, width, edges[u]), place(j, height, edges[v]));
            let mut half = Vector3::zeros();
            half[along] = 0.5 * edges[along];
            Self::new(end - half, end + half, radius)
        });
        capsules.collect()
    }

    /// The same capsule, given in A, seen from W.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn moved(&self, X_WA: &Pose) -> Self {
        let ends = self.ends.map(|end| X_WA.transform_point(&Point3::from(end)).coords);
        Self { ends, radius: self.radius }
    }

    /// Whether all numbers are finite and the radius is above 0.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let finite = self.ends.iter().flat_map(|end| end.iter()).all(|x| x.is_finite());
        finite && self.radius.is_finite() && self.radius > 0.0
    }

    /// Centre and radius of the least ball around it \[m\].
    #[must_use]
    pub fn ball(&self) -> (Vector3<f64>, f64) {
        let [a, b] = &self.ends;
        ((a + b) * 0.5, 0.5 * (b - a).norm() + self.radius)
    }

    /// The gap to another capsule.
    #[must_use]
    pub fn gap(&self, other: &Self) -> Gap {
        let [p, q] = nearest_points(&self.ends, &other.ends);
        Gap::between([p, q], [self.radius, other.radius])
    }
}

/// What lies between two bodies.
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
    let (aa, bb, ab) = (d1.norm_squared(), d2.norm_squared(), d1.dot(&d2));
    let (ar, br) = (d1.dot(&r), d2.dot(&r));
    let inside = |part: f64, whole: f64| if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.0 };
    // Of parallel segments every s will do; a part of 1e-14 of the product is round-off.
    let determinant = aa * bb - ab * ab;
    let s = if determinant > 1e-14 * aa * bb { inside(ab * br - ar * bb, determinant) } else { 0.0 };
    let t = inside(ab * s + br, bb);
    let s = inside(ab * t - ar, aa);
    [a1 + d1 * s, a2 + d2 * t]
}
