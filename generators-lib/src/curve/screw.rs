//! The screw motion between two poses (Chasles): one turn about and one advance along a single axis.

use mrroc::pose::Pose;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::line::MotionLimits;
use crate::profile::ProfileError;

/// `X(s) = X_0 exp(s log(X_0^-1 X_1))`: every point of the body moves on a helix about the screw's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screw {
    from: Pose,
    to: Pose,
    /// Velocity of the origin and angular velocity by `s`, in the axes of the moving frame.
    linear: Vector3<f64>,
    turn: Vector3<f64>,
}

/// `(1 - cos x) / x^2` and `(x - sin x) / x^3`.
fn coefficients(x: f64) -> (f64, f64) {
    // Two terms are exact to 1e-17 below 1e-4; above, cancellation costs eight digits at most of a term that is small.
    if x < 1e-2 {
        let y = x * x;
        (
            0.5 - y / 24.0 * (1.0 - y / 30.0 * (1.0 - y / 56.0)),
            1.0 / 6.0 - y / 120.0 * (1.0 - y / 42.0 * (1.0 - y / 72.0)),
        )
    } else {
        let half = (0.5 * x).sin();
        (2.0 * half * half / (x * x), (x - x.sin()) / (x * x * x))
    }
}

/// The origin's displacement by a constant twist (left Jacobian of SO(3) applied to its linear part).
fn displacement(linear: &Vector3<f64>, turn: &Vector3<f64>) -> Vector3<f64> {
    let (b, c) = coefficients(turn.norm());
    let cross = turn.cross(linear);
    linear + cross * b + turn.cross(&cross) * c
}

impl Screw {
    /// Between two poses in one common frame \[m\], turning through the smaller angle; half a turn goes about the axis that the
    /// relative quaternion names.
    #[must_use]
    pub fn new(from: Pose, to: Pose) -> Self {
        let between = from.inv_mul(&to);
        let turn = between.rotation.scaled_axis();
        let p = between.translation.vector;
        let x = turn.norm();
        // The inverse of the left Jacobian: 1 - 1/2 [turn] + (1/x^2 - cot(x/2) / 2x) [turn]^2.
        let (b, c) = coefficients(x);
        let e = if x < 1e-2 {
            let y = x * x;
            1.0 / 12.0 * (1.0 + y / 60.0 * (1.0 + y / 42.0))
        } else {
            (1.0 - 0.5 * (1.0 - x * x * c) / b) / (x * x)
        };
        let cross = turn.cross(&p);
        let linear = p - cross * 0.5 + turn.cross(&cross) * e;
        Screw { from, to, linear, turn }
    }

    /// Length of the linear part of the twist \[m\].
    #[must_use]
    pub fn length(&self) -> f64 {
        self.linear.norm()
    }

    /// Angle of the turn \[rad\], 0..=pi.
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.turn.norm()
    }

    /// Pose at `s` in 0..=1; the ends are met exactly.
    #[must_use]
    pub fn pose(&self, s: f64) -> Pose {
        if s <= 0.0 {
            return self.from;
        }
        if s >= 1.0 {
            return self.to;
        }
        let linear = self.linear * s;
        let turn = self.turn * s;
        let moved = Translation3::from(displacement(&linear, &turn));
        self.from * Pose::from_parts(moved, UnitQuaternion::from_scaled_axis(turn))
    }

    /// The fastest profile of `s` from 0 to 1 within `limits`, of the kind that goes with them.
    ///
    /// # Errors
    /// A pose that is not finite or a limit that is not positive.
    pub fn profile<L: MotionLimits>(&self, limits: L) -> Result<L::Profile, ProfileError> {
        limits.profile(self.length(), self.angle())
    }
}
