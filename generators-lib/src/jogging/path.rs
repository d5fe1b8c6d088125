//! Where the joints are after some of a jog.
//!
//! ```text
//! joint        q(s) = q0 + s e_i
//! along        X_WE(s) = (p0 + s u, R0)
//! about        X_WE(s) = (p0, exp(s u) R0)
//! to           q(s) = q0 + s (q1 - q0),    0 <= s <= 1
//! ```

use mrroc::operator::jog::{JogMotion, JogOrder, JogPanel};
use mrroc::prelude::*;
use mrroc::robot::JointVector;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// A path of a robot's joints. Its length `s` is in rad or m of the joint, m or rad of the tool, or in shares of the whole path.
#[derive(Clone, Copy, Debug)]
pub struct JogPath<R: Robot> {
    kind: Kind<R::Joints>,
    /// Where it begins: joints, and the pose of the tool `X_WE`.
    from: R::Joints,
    start: Pose,
    /// The flange in the tool, `X_EF`.
    flange: Pose,
    /// How long it is, if it ends.
    length: Option<f64>,
}

#[derive(Clone, Copy, Debug)]
enum Kind<J> {
    /// A change of joints for each unit of length.
    Joints(J),
    /// The tool along, or about, a unit vector in the world.
    Along(Vector3<f64>),
    About(Vector3<f64>),
}

impl<R: Robot> JogPath<R> {
    /// The path that an order asks for, from the joints `q` [rad or m], of the tool `X_FE`; `None` if there is no such frame or
    /// joint, nothing to go, or an output is switched.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn of(order: &JogOrder, panel: &JogPanel<R>, q: R::Joints, X_FE: &Pose) -> Option<Self> {
        let start = panel.model().forward(&q) * X_FE;
        let sign = order.speed.signum();
        let (kind, length) = match &order.motion {
            JogMotion::Joint { joint } => {
                let joint = usize::from(*joint);
                let of = |i: usize| if i == joint { sign } else { 0.0 };
                ((joint < R::Joints::LEN).then(|| Kind::Joints(R::Joints::from_joints(of)))?, order.distance)
            }
            JogMotion::Output { .. } => return None,
            JogMotion::To { joints } => (Kind::Joints(joints.of::<R::Joints>()? - q), Some(1.0)),
            JogMotion::Tool { frame, axis } => {
                let mut unit = Vector3::zeros();
                unit[axis.index()] = sign;
                let in_world = panel.frame(*frame, &start)?.rotation * unit;
                (if axis.turns() { Kind::About(in_world) } else { Kind::Along(in_world) }, order.distance)
            }
        };
        let is_nothing = matches!(kind, Kind::Joints(by) if by.as_slice().iter().all(|q| *q == 0.0));
        (!is_nothing).then(|| JogPath { kind, from: q, start, flange: X_FE.inverse(), length })
    }

    /// How long it is; infinite as long as it is held.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length.unwrap_or(f64::INFINITY)
    }

    /// The joints [rad or m] after `s` of it, on the branch of those nearby; `None` where the arm cannot follow.
    #[must_use]
    pub fn joints(&self, model: &R, s: f64, near: &R::Joints) -> Option<R::Joints> {
        let pose = match &self.kind {
            Kind::Joints(by) => return Some(self.from + *by * s),
            Kind::Along(unit) => {
                let at = self.start.translation.vector + unit * s;
                Pose::from_parts(Translation3::from(at), self.start.rotation)
            }
            Kind::About(axis) => {
                let rotation = UnitQuaternion::from_scaled_axis(axis * s) * self.start.rotation;
                Pose::from_parts(self.start.translation, rotation)
            }
        };
        let joints = model.inverse(&(pose * self.flange), near).ok()?;
        joints.as_slice().iter().all(|q| q.is_finite()).then_some(joints)
    }

    /// The pose of the tool at joints [rad or m], `X_WE`.
    #[must_use]
    pub fn tool(&self, model: &R, q: &R::Joints) -> Pose {
        model.forward(q) * self.flange.inverse()
    }
}
