//! Where a robot stands: the pose of its base frame in the world.

use mrroc::pose::Pose;

/// The base frame B of a robot in the world W. Kinematics is written in B; `X_WF = X_WB X_BF` for a flange F.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)]
pub(crate) struct Base {
    /// The base in the world.
    pub(crate) X_WB: Pose,
    /// The world seen from the base, `X_WB^-1`: computed once, because every call of inverse kinematics needs it.
    pub(crate) X_BW: Pose,
}

impl Base {
    /// The base at `X_WB` in the world.
    #[allow(non_snake_case)]
    pub(crate) fn at(X_WB: Pose) -> Self {
        Self { X_WB, X_BW: X_WB.inverse() }
    }
}

/// The base at the world's origin.
impl Default for Base {
    fn default() -> Self {
        Self { X_WB: Pose::identity(), X_BW: Pose::identity() }
    }
}
