//! Capsules: what the links of robots, tools and obstacles are approximated by.

use mrroc::pose::Pose;
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
    /// Each covers a rod of rectangular section. Its caps stand out at both ends by half the diagonal of that section: with
    /// more capsules they stand out less.
    #[must_use]
    pub fn covering_box(edges: Vector3<f64>, across: usize) -> Vec<Self> {
        let along = edges.imax();
        let n = across.max(1);
        let [u, v] = [(along + 1) % 3, (along + 2) % 3];
        let width = edges[u] / n as f64;
        let height = edges[v] / n as f64;
        let radius = 0.5 * width.hypot(height);
        let place = |k: usize, size: f64, edge: f64| (k as f64 + 0.5) * size - 0.5 * edge;
        let rods = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let capsules = rods.map(|(i, j)| {
            let mut end = Vector3::zeros();
            end[u] = place(i, width, edges[u]);
            end[v] = place(j, height, edges[v]);
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
}
