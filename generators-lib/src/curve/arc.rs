//! An arc of a circle.

use super::{Curve, CurveError, CurvePoint, Helix, finite};
use nalgebra::{UnitVector3, Vector3};

/// Least sine of an angle between three points that are taken to be on a circle.
const COLLINEAR: f64 = 1e-9;

/// An arc of a circle, a whole one, or more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc(Helix);

impl Arc {
    /// From `start` through `via` to `end` \[m\], three points that differ: `u = via - start`, `v = end - start`,
    /// `n = u x v`, `centre = start + (|v|^2 n x u + |u|^2 v x n) / 2 |n|^2`.
    ///
    /// # Errors
    /// Points that coincide, lie on a line, or are not finite.
    pub fn through(start: Vector3<f64>, via: Vector3<f64>, end: Vector3<f64>) -> Result<Self, CurveError> {
        finite([&start, &via, &end])?;
        let u = via - start;
        let v = end - start;
        let w = end - via;
        let shortest = u.norm().min(v.norm()).min(w.norm());
        if !(shortest > 0.0 && v.norm_squared().is_finite()) {
            return Err(CurveError::Coincident);
        }
        // Of size 1: neither very large nor very small coordinates overflow.
        let size = u.norm().max(v.norm());
        let u = u / size;
        let v = v / size;
        let n = u.cross(&v);
        if n.norm() <= COLLINEAR * u.norm() * v.norm() {
            return Err(CurveError::Collinear);
        }
        let to_centre = (n.cross(&u) * v.norm_squared() + v.cross(&n) * u.norm_squared())
            / (2.0 * n.norm_squared())
            * size;
        let centre = start + to_centre;
        let axis = UnitVector3::new_normalize(n);
        let x = -to_centre;
        let z = end - centre;
        let angle = z.dot(&axis.cross(&x)).atan2(z.dot(&x)).rem_euclid(std::f64::consts::TAU);
        Ok(Arc(Helix::about(start, centre, axis, angle, 0.0)?.ending_at(end)))
    }

    /// From `start` \[m\] about the `axis` through `centre` \[m\] by `angle` \[rad\] != 0, right-handed.
    ///
    /// # Errors
    /// A start on the axis, no angle, a number that is not finite.
    pub fn about(
        start: Vector3<f64>,
        centre: Vector3<f64>,
        axis: UnitVector3<f64>,
        angle: f64,
    ) -> Result<Self, CurveError> {
        Ok(Arc(Helix::about(start, centre, axis, angle, 0.0)?))
    }

    /// Radius \[m\].
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.0.radius()
    }

    /// Angle from start to end \[rad\], > 0.
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.0.angle()
    }

    /// Centre \[m\].
    #[must_use]
    pub fn centre(&self) -> Vector3<f64> {
        self.0.centre()
    }
}

impl Curve for Arc {
    fn length(&self) -> f64 {
        self.0.length()
    }

    #[inline]
    fn at(&self, s: f64) -> CurvePoint {
        self.0.at(s)
    }
}
