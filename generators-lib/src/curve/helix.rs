//! Turns about an axis while advancing along it.

use super::sine::sin_cos;
use super::{Curve, CurveError, CurvePoint, finite};
use nalgebra::{UnitVector3, Vector3};

/// A helix: turns about an axis at a constant radius, and advances along it by a constant pitch; a circle where that is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Helix {
    centre: Vector3<f64>,
    /// From the centre to the start, and across it, both of the radius' length.
    radial: [Vector3<f64>; 2],
    /// Advance per angle [m/rad].
    advance: Vector3<f64>,
    angle: f64,
    length: f64,
    /// Angle per length [rad/m].
    per_length: f64,
    end: Option<Vector3<f64>>,
}

impl Helix {
    /// From `start` \[m\] about the `axis` through `centre` \[m\] by `angle` \[rad\] != 0 (right-handed), advancing by
    /// `pitch` \[m\] along the axis per turn in that sense.
    ///
    /// # Errors
    /// A start on the axis, no angle, a number that is not finite.
    pub fn about(
        start: Vector3<f64>,
        centre: Vector3<f64>,
        axis: UnitVector3<f64>,
        angle: f64,
        pitch: f64,
    ) -> Result<Self, CurveError> {
        finite([&start, &centre, &axis.into_inner()])?;
        if !(angle.is_finite() && pitch.is_finite()) {
            return Err(CurveError::NotFinite);
        }
        // Backwards is forwards about the opposite axis.
        let turn = axis.into_inner() * angle.signum();
        let centre = centre + turn * turn.dot(&(start - centre));
        let radial = start - centre;
        let per_angle = pitch / std::f64::consts::TAU;
        let rate = radial.norm().hypot(per_angle);
        if !(radial.norm() > 0.0 && angle != 0.0 && (rate * angle).is_finite()) {
            return Err(CurveError::Coincident);
        }
        let radial = [radial, turn.cross(&radial)];
        let advance = turn * per_angle;
        let angle = angle.abs();
        let per_length = 1.0 / rate;
        Ok(Helix { centre, radial, advance, angle, length: rate * angle, per_length, end: None })
    }

    /// The same, ending at a point that differs from its own end by rounding.
    pub(super) fn ending_at(self, end: Vector3<f64>) -> Self {
        Helix { end: Some(end), ..self }
    }

    /// Where it has turned by `angle` \[rad\].
    #[inline]
    fn turned(&self, angle: f64) -> CurvePoint {
        let (sin, cos) = sin_cos(angle);
        let [x, y] = self.radial;
        let i = self.per_length;
        let out = x * cos + y * sin;
        let across = y * cos - x * sin;
        CurvePoint {
            position: self.centre + out + self.advance * angle,
            tangent: (across + self.advance) * i,
            curvature: out * (-i * i),
        }
    }

    #[cold]
    fn end(&self) -> CurvePoint {
        let end = self.turned(self.angle);
        CurvePoint { position: self.end.unwrap_or(end.position), ..end }
    }

    /// Radius \[m\].
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radial[0].norm()
    }

    /// Angle turned from start to end \[rad\], > 0.
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// Centre of the first turn \[m\].
    #[must_use]
    pub fn centre(&self) -> Vector3<f64> {
        self.centre
    }
}

impl Curve for Helix {
    fn length(&self) -> f64 {
        self.length
    }

    #[inline]
    fn at(&self, s: f64) -> CurvePoint {
        if s >= self.length {
            return self.end();
        }
        self.turned(s.max(0.0) * self.per_length)
    }
}
