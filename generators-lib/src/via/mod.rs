//! Straight legs through via points without a stop, past each point within a stated deviation.
//!
//! In: points of joints or poses of the tool, limits of velocity, acceleration and jerk (infinite: parabolic blends), the
//! deviation allowed. Out: the motion over path time in closed form.
//!
//! A leg is passed at a constant rate, or at three: slow out of one corner, fast, slow into the next. From rate to rate and
//! round every corner the velocity changes by an acceleration that is a trapezoid over time, a rectangle `t` long averaged
//! over `s` (the [`Blend`]):
//!
//! ```text
//! |dv| / t <= A,   |dv| / (t s) <= J,   deviation |dv| (t / 8 + s^2 / 24 t),   duration t + s
//! ```
//!
//! Blends do not overlap, so at any instant there is one at most, and velocities in it are mixtures of those before and
//! behind: limits hold. A single leg from rest to rest takes the least time there is; legs with corners do not, since speed
//! is not traded for the curvature within a blend ([`timing`](crate::timing) does that, without a limit of jerk).
//! Literature: Paul, *Robot Manipulators* (1981), chapter 5; Biagiotti and Melchiorri, chapters 3 and 4 (averaging).

mod blend;
mod joints;
mod legs;
mod poses;
mod times;

pub use blend::Blend;
pub use joints::ViaJoints;
pub use poses::{PoseDeviation, ViaPoses};

use thiserror::Error;

use crate::waypoints::PointsError;

/// Why there is no motion through the points.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ViaError {
    /// A limit or a deviation is not positive, or not finite where it must be.
    #[error(
        "{name} {value} of the motion through via points must be finite and greater than 0 (jerk: or infinite)"
    )]
    Limit {
        /// Which.
        name: &'static str,
        /// Its value, SI.
        value: f64,
    },
    /// The points make no path.
    #[error(transparent)]
    Points(#[from] PointsError),
    /// Distances and limits are too many orders of magnitude apart.
    #[error("the via points and their limits are too many orders of magnitude apart")]
    Precision,
}
