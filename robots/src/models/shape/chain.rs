//! A robot as a serial chain of rigid bodies: what batched kinematics works on.
//!
//! In: joint positions. Out: the same capsules in the world that the robot's [`Outline`](super::Outline) gives, from joints and
//! bodies that can be copied into any layout.
//!
//! ```text
//! X_WJ_i = X_WJ_i-1 X_before_i M_i(multiplier_i q[leader_i] + offset_i),    X_WF = X_WJ_n X_tip
//! ```
//!
//! with `M_i` a turn about z or a shift along z.

use mrroc::pose::Pose;
use mrroc::robot::JointKind;
use nalgebra::Vector3;

use super::capsule::Capsule;

/// A serial chain of rigid bodies, each a capsule that the first joints of the chain move.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Chain {
    /// The joints that move, from base to flange, those that follow others too.
    pub joints: Vec<ChainJoint>,
    /// The capsules, in the order of [`Outline::links`](super::Outline::links).
    pub bodies: Vec<ChainBody>,
    /// Pose of the flange F in the frame of the last joint; in the world W where there is none.
    pub X_tip: Pose,
}

/// One joint that moves, with all that is fixed before it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct ChainJoint {
    /// Pose of the joint's frame where it stands at 0, its z along the axis, in the frame of the joint before; of the first joint in
    /// the world W, so the robot's base is part of it.
    pub X_before: Pose,
    /// How it moves along z.
    pub kind: JointKind,
    /// Index of the robot's coordinate that moves it.
    pub leader: usize,
    /// By how much it moves when that moves by 1 [1, rad/m or m/rad], finite.
    pub multiplier: f64,
    /// Where it stands when that is at 0 [rad or m], finite.
    pub offset: f64,
}

/// One capsule of a chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainBody {
    /// How many joints move it: the first of the chain.
    pub joints: usize,
    /// In the frame of the last of them, or in the world W where none does.
    pub capsule: Capsule,
}

impl ChainJoint {
    /// Pose of the joint's frame in that of the joint before, its coordinate at `value` [rad or m].
    #[must_use]
    #[allow(non_snake_case)]
    pub fn pose(&self, value: f64) -> Pose {
        let along = self.multiplier * value + self.offset;
        let X_motion = match self.kind {
            JointKind::Revolute => Pose::rotation(Vector3::z() * along),
            JointKind::Prismatic => Pose::translation(0.0, 0.0, along),
        };
        self.X_before * X_motion
    }
}

impl Chain {
    /// Poses in the world W of the frames of all joints at `q` [rad or m], and of the flange F behind them. A coordinate that `q`
    /// lacks is not a number, and neither is any pose behind it.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn frames(&self, q: &[f64]) -> Vec<Pose> {
        let mut X_WJ = Pose::identity();
        let joints = self.joints.iter().map(|joint| {
            X_WJ *= joint.pose(q.get(joint.leader).copied().unwrap_or(f64::NAN));
            X_WJ
        });
        let mut frames: Vec<Pose> = joints.collect();
        frames.push(X_WJ * self.X_tip);
        frames
    }

    /// The capsules in the world W at `q` [rad or m], in the order of the bodies.
    #[must_use]
    pub fn capsules(&self, q: &[f64]) -> Vec<Capsule> {
        let frames = self.frames(q);
        let place = |body: &ChainBody| match body.joints.checked_sub(1) {
            Some(last) => body.capsule.moved(&frames[last.min(frames.len() - 1)]),
            None => body.capsule,
        };
        self.bodies.iter().map(place).collect()
    }
}
