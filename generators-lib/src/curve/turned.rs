//! A tool on a curve, turning at a constant rate as it goes.

use mrroc::pose::Pose;
use nalgebra::Translation3;

use super::{Curve, CurveError};
use crate::line::{LinePath, ToolPoint};
use crate::profile::ProfilePoint;

/// Leads a tool's origin along a curve, while its orientation turns through the smaller angle at a constant rate per length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnedCurve<C> {
    curve: C,
    turn: LinePath,
    /// Share of the turn per length [1/m].
    rate: f64,
}

impl<C: Curve> TurnedCurve<C> {
    /// Along `curve`, with the orientations of two poses at its ends.
    ///
    /// # Errors
    /// A curve without length.
    pub fn new(curve: C, start: Pose, end: Pose) -> Result<Self, CurveError> {
        let rate = 1.0 / curve.length();
        if !(rate > 0.0 && rate.is_finite()) {
            return Err(CurveError::Coincident);
        }
        Ok(TurnedCurve { curve, turn: LinePath::new(start, end), rate })
    }

    /// The curve.
    #[must_use]
    pub fn curve(&self) -> &C {
        &self.curve
    }

    /// Angle of the turn \[rad\], 0..=pi.
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.turn.angle()
    }

    /// Pose at the length `s` \[m\].
    #[inline]
    #[must_use]
    pub fn pose(&self, s: f64) -> Pose {
        let position = Translation3::from(self.curve.at(s).position);
        Pose::from_parts(position, self.turn.rotation(s * self.rate))
    }

    /// Pose, velocity and acceleration where a profile of the length is at `point`:
    /// `v = s' t`, `a = s'' t + s'^2 k`.
    #[inline]
    #[must_use]
    pub fn at(&self, point: &ProfilePoint) -> ToolPoint {
        let on = self.curve.at(point.s);
        let turning = self.turn.turning() * self.rate;
        ToolPoint {
            pose: Pose::from_parts(Translation3::from(on.position), self.turn.rotation(point.s * self.rate)),
            velocity: on.tangent * point.v,
            turning: turning * point.v,
            acceleration: on.tangent * point.a + on.curvature * (point.v * point.v),
            turning_acceleration: turning * point.a,
        }
    }
}
