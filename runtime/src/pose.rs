//! Poses in space and the orientation coordinates of the field: ZYZ Euler angles and angle-axis vectors.

/// A rigid-body transform. `X_AB` is the pose of frame B in frame A; lengths in metres.
pub type Pose = nalgebra::Isometry3<f64>;
