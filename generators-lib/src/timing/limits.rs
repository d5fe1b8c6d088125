//! What bounds the motion along a path, and why there may be none.

use mrroc::robot::{JointVector, NoInverse};
use thiserror::Error;

use crate::curve::{CurveError, SplinePoint};

/// Limits of the joints on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathLimits<J> {
    /// Velocity per joint [rad/s or m/s], in both directions, finite, > 0.
    pub velocity: J,
    /// Acceleration per joint [rad/s^2 or m/s^2], in both directions, finite, > 0.
    pub acceleration: J,
    /// Speed of the path's parameter [1/s], [m/s] where it is a length, > 0; infinite where it does not matter.
    pub speed: f64,
}

/// `low <= a s'' + b s'^2 <= high` at one point of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearLimit {
    /// Coefficient of the path's acceleration.
    pub a: f64,
    /// Coefficient of the square of its speed.
    pub b: f64,
    /// Least value.
    pub low: f64,
    /// Largest value, >= `low`.
    pub high: f64,
}

/// Why a path has no time-optimal motion.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum TimingError {
    /// A limit is not positive, or not finite where it must be.
    #[error("{name} limit {value} of joint {joint} must be finite and greater than 0")]
    Limit {
        /// Which.
        name: &'static str,
        /// The joint, counted from 1; 0 for the path itself.
        joint: usize,
        /// Its value, SI.
        value: f64,
    },
    /// The grid does not lead from the path's start to its end in rising order.
    #[error("the grid must rise from the start {0} of the path to its end {1}")]
    Grid(f64, f64),
    /// A number of the path or of a limit along it is infinite or not a number, or the square of their ratio is not finite.
    #[error(
        "the path or a limit along it is not finite at {0}, or they are too many orders of magnitude apart"
    )]
    NotFinite(f64),
    /// There are more or fewer linear limits at one point than at another.
    #[error(
        "{actual} linear limits at {at}, {expected} at the start: help: state the same ones at every point"
    )]
    Rows {
        /// Parameter.
        at: f64,
        /// Limits there.
        actual: usize,
        /// Limits at the start.
        expected: usize,
    },
    /// Within the limits no speed at this place leads to the end.
    #[error(
        "no motion within the limits leads from {0} on: help: what holds the arm still there needs more than it has"
    )]
    Impassable(f64),
    /// The speed asked for at the start or at the end is not possible.
    #[error(
        "speed {asked} at the path's {place} lies outside what the limits and the path allow, {least} to {most}"
    )]
    Speed {
        /// `start` or `end`.
        place: &'static str,
        /// Speed of the parameter asked for [1/s].
        asked: f64,
        /// Least possible.
        least: f64,
        /// Largest possible.
        most: f64,
    },
    /// The path of a tool has no joint positions.
    #[error("no joint positions at {at} of the path: {cause}")]
    NoInverse {
        /// Parameter.
        at: f64,
        /// What keeps the robot from it.
        cause: NoInverse,
    },
    /// The joints jump, or bend so sharply that no spline follows them.
    #[error(
        "the joints miss the path by {miss} rad or m at {at}: help: it has a corner, or passes a singularity"
    )]
    NotSmooth {
        /// Parameter.
        at: f64,
        /// By how much a spline through many points misses the path.
        miss: f64,
    },
    /// The joint positions make no spline.
    #[error(transparent)]
    Curve(#[from] CurveError),
}

impl<J: JointVector> PathLimits<J> {
    /// Checks every limit.
    ///
    /// # Errors
    /// The first that is not positive, or not finite where it must be.
    pub fn validate(&self) -> Result<(), TimingError> {
        for (name, values) in [("velocity", &self.velocity), ("acceleration", &self.acceleration)] {
            for (i, &value) in values.as_slice().iter().enumerate() {
                if !(value > 0.0 && value.is_finite()) {
                    return Err(TimingError::Limit { name, joint: i + 1, value });
                }
            }
        }
        let value = self.speed;
        if value > 0.0 { Ok(()) } else { Err(TimingError::Limit { name: "speed", joint: 0, value }) }
    }
}

/// The limits `low <= tau <= high` of torques [N m or N], from the inverse dynamics `tau(q, q', q'')` of the arm, which is
/// called three times: `tau = M q'' + C q' + g` is linear in `s''` and `s'^2`.
pub fn torque_limits<J: JointVector>(
    at: &SplinePoint<J>,
    tau: impl Fn(&J, &J, &J) -> J,
    low: &J,
    high: &J,
) -> impl Iterator<Item = LinearLimit> {
    let zeros = J::zeros();
    let still = tau(&at.value, &zeros, &zeros);
    let a = tau(&at.value, &zeros, &at.first) - still;
    let b = tau(&at.value, &at.first, &at.second) - still;
    let low = *low - still;
    let high = *high - still;
    (0..J::LEN).map(move |i| LinearLimit { a: a[i], b: b[i], low: low[i], high: high[i] })
}
