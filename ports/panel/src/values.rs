//! Numbers and poses, as a page reads them.
//!
//! In: numbers and poses of a cell. Out: numbers that JSON can say, in short texts.

use mrroc_core::pose::Pose;

/// Whether it is a pose at all: finite, and with a rotation.
pub fn is_pose(pose: &Pose) -> bool {
    let norm = pose.rotation.as_ref().norm();
    pose.translation.vector.iter().all(|x| x.is_finite()) && (norm - 1.0).abs() < 1e-6
}

/// To a millionth: a micrometre is more than a page shows, and short texts are sooner read.
pub fn rounded(x: f64) -> f64 {
    (x * 1e6).round() / 1e6
}

/// A number that JSON can say.
pub fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

/// A pose as x, y, z and the quaternion x, y, z, w.
pub fn numbers(pose: &Pose) -> [f64; 7] {
    let (p, q) = (&pose.translation, &pose.rotation);
    [p.x, p.y, p.z, q.i, q.j, q.k, q.w].map(rounded)
}
