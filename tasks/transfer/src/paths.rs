//! How the body moves: soft paths, as functions of path time.

use mrroc::Pose;
use mrroc_generators::cooperation::TimedBody;
use mrroc_generators::line::LinePath;

/// How far a motion from rest to rest is after the share `u` of its time: `10 u³ - 15 u⁴ + 6 u⁵`, whose velocity and
/// acceleration are zero at both ends.
#[must_use]
pub fn share(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    u * u * u * (10.0 + u * (6.0 * u - 15.0))
}

/// The body straight by `X_BsB`, from rest to rest, in `duration` \[s\].
#[allow(non_snake_case)]
pub fn soft(X_BsB: Pose, duration: f64) -> TimedBody<impl FnMut(f64) -> Pose> {
    let line = LinePath::new(Pose::identity(), X_BsB);
    TimedBody::new(duration, move |t| line.pose(share(t / duration)))
}
