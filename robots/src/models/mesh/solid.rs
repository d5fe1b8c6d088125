//! How deep a point lies in the filled volume of a mesh.
//!
//! The parts of a mesh that share no vertex are looked at one by one. One whose edges all have an even number of triangles parts
//! space into inside and outside, which a ray tells by the number of its crossings, whichever way the triangles face. The filled volume
//! is the union of these insides and of all triangles. The level of a point is
//!
//! ```text
//! f(x) = min over the parts of (-distance from its surface, inside of a closed part; +distance, elsewhere)
//! ```
//!
//! It changes by at most the length of a move (all its terms do), and a ball around `c` of radius `r >= f(c)` has no
//! point farther than `r + f(c)` from the filled volume: the segment from an inner `c` to a point outside leaves the part at its surface,
//! which is at least `-f(c)` away.

use nalgebra::Vector3;

use super::surface::Surface;
use super::triangles::TriangleMesh;

/// Directions in which rays are sent; no edge of a drawn part runs along them.
const RAYS: [[f64; 3]; 3] = [
    [0.573_291_7, 0.613_904_3, 0.542_700_1],
    [-0.717_203_9, 0.281_600_7, 0.637_481_3],
    [0.131_907_3, -0.837_402_9, 0.530_411_7],
];

/// A part of a mesh.
#[derive(Clone, Debug)]
struct Part {
    surface: Surface,
    is_closed: bool,
}

/// The filled volume of a mesh.
#[derive(Clone, Debug)]
pub(super) struct Solid {
    parts: Vec<Part>,
}

impl Solid {
    pub(super) fn of(mesh: &TriangleMesh) -> Self {
        let part = |(triangles, is_closed): (Vec<[u32; 3]>, bool)| Part {
            surface: Surface::of(mesh, &triangles),
            is_closed,
        };
        let parts = mesh.parts().into_iter().map(part);
        Self { parts: parts.collect() }
    }

    /// The level `f` of a point \[m\], below 0 inside, if it is below `most`. Where rays do not agree the point counts as outside,
    /// where the level is larger.
    pub(super) fn level_below(&self, point: &Vector3<f64>, most: f64) -> Option<f64> {
        let mut level = most;
        for part in &self.parts {
            let is_inside = part.holds(point);
            // One from outside must be nearer than what was found, one from inside deeper.
            let within = if is_inside { f64::INFINITY } else { level.max(0.0) };
            if within > 0.0
                && let Some(on) = part.surface.nearest(point, within)
            {
                let apart = (on - point).norm();
                level = level.min(if is_inside { -apart } else { apart });
            }
        }
        (level < most).then_some(level)
    }

    /// The largest ball in a closed part that touches its surface at `point`, on the side to which `normal` (of length 1)
    /// points, if there is one: its centre, and where else it touches (shrinking balls; Ma, Bae, Choi 2012).
    pub(super) fn inner_ball(
        &self,
        point: &Vector3<f64>,
        normal: &Vector3<f64>,
    ) -> Option<(Vector3<f64>, Option<Vector3<f64>>)> {
        let start = point + normal * 1e-6;
        let part = self.parts.iter().find(|part| part.holds(&start) && part.touches(point))?;
        let (least, most) = part.surface.bounds();
        let mut radius = (most - least).norm();
        let mut touched = None;
        for _ in 0..30 {
            let centre = point + normal * radius;
            let Some(on) = part.surface.nearest(&centre, radius * (1.0 - 1e-6)) else {
                return Some((centre, touched));
            };
            let chord = on - point;
            let along = chord.dot(normal);
            if along <= 0.0 {
                return None;
            }
            let next = chord.norm_squared() / (2.0 * along);
            touched = Some(on);
            if next >= radius {
                return Some((centre, touched));
            }
            radius = next;
        }
        None
    }
}

impl Part {
    fn holds(&self, point: &Vector3<f64>) -> bool {
        let (least, most) = self.surface.bounds();
        let is_near = (0..3).all(|axis| (least[axis]..=most[axis]).contains(&point[axis]));
        self.is_closed && is_near && RAYS.iter().all(|ray| self.surface.is_odd(point, &Vector3::from(*ray)))
    }

    fn touches(&self, point: &Vector3<f64>) -> bool {
        self.surface.nearest(point, 1e-9).is_some()
    }
}
