//! What the runtime must know of a robot: its kinematics and its limits.

use crate::model::excess::Excess;
use crate::model::joints::JointVector;
use crate::model::pose::Pose;

/// A kind of robot: a value holds the geometry (nominal or calibrated, where its base stands) and the limits.
///
/// One robot is one file: implement this trait, and [`Driver`](crate::robot::Driver) for what moves it.
pub trait Robot: Clone + 'static {
    /// The kind's name, for messages: `"irp6"`.
    const KIND: &'static str;

    /// Joint coordinates, `SVector<f64, N>`.
    type Joints: JointVector;

    /// What kind joint `i` is; revolute unless a robot says otherwise.
    fn joint(&self, _i: usize) -> JointKind {
        JointKind::Revolute
    }

    /// The limits that every demand is checked against.
    fn limits(&self) -> &Limits<Self::Joints>;

    /// Limits that a box of joint limits cannot express, such as those of motors that several joints share:
    /// checked for the way from `from` to `to` \[rad or m\] in `duration` \[s\]. None unless a robot says so.
    ///
    /// # Errors
    /// The first [`CoupledLimit`] that the way breaks.
    fn check_coupled(
        &self,
        _from: &Self::Joints,
        _to: &Self::Joints,
        _duration: f64,
    ) -> Result<(), CoupledLimit> {
        Ok(())
    }

    /// The singularity near which `q` lies, if any, where joints must turn fast for the tool to turn slowly: named in
    /// the fault when a demanded pose asks for more than the joints can do there. None unless a robot says so.
    fn near_singularity(&self, _q: &Self::Joints) -> Option<&'static str> {
        None
    }

    /// Direct kinematics: `X_WF`, the pose of the flange in the world, for joint positions `q` [rad, m].
    fn forward(&self, q: &Self::Joints) -> Pose;

    /// Visits the frames of the links at `q`, `X_WL`, from the base to the flange, which comes last and stands at
    /// `forward(q)`: for pictures. The flange's alone unless a robot says more.
    fn frames(&self, q: &Self::Joints, visit: &mut dyn FnMut(&Pose)) {
        visit(&self.forward(q));
    }

    /// Inverse kinematics: the joint positions that put the flange at `X_WF`, on the branch nearest to `near`.
    ///
    /// Positions may lie outside the joint limits: those are checked where the demand is accepted.
    ///
    /// # Errors
    /// [`NoInverse`] when the pose is out of reach or of a kind that the joints cannot give, or when a singularity leaves
    /// no continuous answer.
    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &Self::Joints) -> Result<Self::Joints, NoInverse>;

    /// Inverse kinematics of a redundant robot with its redundancy at a value: a track's position \[m\], an elbow's angle
    /// \[rad\]; the kind says what it is. On the branch nearest to `near`.
    ///
    /// # Errors
    /// [`NoInverse`], as of [`inverse`](Robot::inverse); `NotRedundant` unless a robot says more.
    #[allow(non_snake_case)]
    fn inverse_at(
        &self,
        _X_WF: &Pose,
        _redundancy: f64,
        _near: &Self::Joints,
    ) -> Result<Self::Joints, NoInverse> {
        Err(NoInverse::NotRedundant)
    }
}

/// A limit that several joints share, broken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoupledLimit {
    /// The joint that the message names, from 0.
    pub joint: usize,
    /// What exceeds the limit, for the message: `"angle of motor V"`.
    pub what: &'static str,
    /// The value asked for, and the value allowed.
    pub excess: Excess,
}

/// How a joint moves, and with it the units of its coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// About an axis \[rad\].
    Revolute,
    /// Along an axis \[m\].
    Prismatic,
}

impl JointKind {
    /// The unit of the position's derivative of this order, 0 to 3: `rad`, `rad/s`, `rad/s²`, `rad/s³`.
    #[must_use]
    pub const fn unit(self, order: usize) -> &'static str {
        let units = match self {
            JointKind::Revolute => ["rad", "rad/s", "rad/s²", "rad/s³"],
            JointKind::Prismatic => ["m", "m/s", "m/s²", "m/s³"],
        };
        units[if order < 4 { order } else { 3 }]
    }
}

/// Why a pose has no joint positions.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoInverse {
    /// The wrist centre lies farther from the shoulder than the arm is long, or nearer than it can fold.
    #[error(
        "the pose is out of reach: the wrist lies {distance:.4} m from the shoulder, the arm reaches {min:.4} to {max:.4} m"
    )]
    OutOfReach {
        /// Distance of the wrist centre from the shoulder \[m\].
        distance: f64,
        /// Smallest distance that the arm reaches \[m\].
        min: f64,
        /// Largest distance that the arm reaches \[m\].
        max: f64,
    },
    /// The pose lies on a singularity where the joints are not determined and cannot be continued.
    #[error("the pose is at the {name} singularity")]
    Singular {
        /// Which singularity: `"wrist"`, `"shoulder"` ..
        name: &'static str,
    },
    /// The joints move the flange in fewer directions than the pose asks for, or not on to it: a tool that leans out of
    /// the plane of an arm with five joints, a pose beside the line of a gripper's finger.
    #[error(
        "the pose is not attainable: {what} is {actual:.6} {unit}, the robot takes {tolerance:.6} {unit}"
    )]
    NotAttainable {
        /// What is too much: `"lean out of the arm's plane"`.
        what: &'static str,
        /// How much it is.
        actual: f64,
        /// How much of it the robot takes.
        tolerance: f64,
        /// The unit of both: `"m"` or `"rad"`.
        unit: &'static str,
    },
    /// A value of its redundancy was chosen for a robot that has none.
    #[error("the robot has no redundancy to choose")]
    NotRedundant,
    /// Iteration from the joint positions to stay near came to none that give the pose: there may be some elsewhere.
    #[error(
        "no joint positions were found from here: the pose nearest to the demanded one is off by {error:.1e}"
    )]
    NotConverged {
        /// The least error that it came to [parts of the robot's reach, and rad], > `tolerance`.
        error: f64,
        /// The largest error that counts as none [parts of the robot's reach, and rad].
        tolerance: f64,
    },
}

/// What a robot may be asked to do, joint by joint. All values finite; `velocity`, `acceleration`, `jerk` > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits<J> {
    /// Lower position limit [rad or m].
    pub lower: J,
    /// Upper position limit [rad or m], above `lower`.
    pub upper: J,
    /// Largest speed [rad/s or m/s].
    pub velocity: J,
    /// Largest acceleration [rad/s² or m/s²].
    pub acceleration: J,
    /// Largest jerk [rad/s³ or m/s³]; `None` for a robot without a documented jerk limit: then jerk is not checked.
    pub jerk: Option<J>,
}

/// Where an EDP interpolates between the demands of two steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InterpolationSpace {
    /// In joint positions: it never asks for more than the demands did.
    #[default]
    Joints,
    /// In poses of the flange, where the demands are poses or displacements: a straight line of the flange stays straight
    /// between demands that are far apart, at the price of one inverse kinematics in each servo period. For robots whose
    /// joints the pose determines, and cells in which a step has several servo periods. A pose between two demands that
    /// has no joints, or joints that would exceed a velocity limit on the way, is a fault.
    Task,
}
