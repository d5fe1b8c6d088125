//! The displacement from one pose to another along and about fixed axes, as velocities of a tool are told.

use mrroc::prelude::*;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// From one pose to another: along \[m\] and about \[rad\] the axes of the frame that both are told in.
///
/// ```
/// use mrroc::pose::Pose;
/// use mrroc_generators::between::{moved, displacement};
///
/// let (from, to) = (Pose::identity(), Pose::translation(0.1, 0.0, 0.0) * Pose::rotation(nalgebra::Vector3::z()));
/// let [along, about] = displacement(&from, &to);
/// assert!((along.x - 0.1).abs() < 1e-15 && (about.z - 1.0).abs() < 1e-15);
/// assert!((moved(&from, [along, about]).inv_mul(&to)).translation.vector.norm() < 1e-15);
/// ```
#[must_use]
pub fn displacement(from: &Pose, to: &Pose) -> [Vector3<f64>; 2] {
    let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
    [to.translation.vector - from.translation.vector, turn]
}

/// A pose moved by such a [`displacement`].
#[must_use]
pub fn moved(pose: &Pose, [along, about]: [Vector3<f64>; 2]) -> Pose {
    let mut rotation = UnitQuaternion::from_scaled_axis(about) * pose.rotation;
    rotation.renormalize_fast();
    Pose::from_parts(Translation3::from(pose.translation.vector + along), rotation)
}
