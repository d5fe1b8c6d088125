//! A pose as `cell.toml` writes it.

use mrroc::pose::{Pose, Rpy};

/// The keys `xyz` \[m\] and `quat_xyzw`, from which the pose is read without a loss, and the orientation in words that a person
/// reads: roll, pitch and yaw, and a rotation vector \[rad\].
pub(crate) fn pose_text(pose: &Pose) -> String {
    let (p, q, v) = (pose.translation.vector, pose.rotation.quaternion(), pose.rotation.scaled_axis());
    let Rpy { roll, pitch, yaw } = Rpy::of(&pose.rotation);
    format!(
        "xyz = {:?}\nquat_xyzw = {:?}\n# The same orientation: rpy = {:?}, as a rotation vector {:?} [rad]\n",
        [p.x, p.y, p.z],
        [q.i, q.j, q.k, q.w],
        [roll, pitch, yaw],
        [v.x, v.y, v.z]
    )
}
