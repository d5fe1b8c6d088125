//! What the runtime must know about a robot: its kinematics and its limits.

use std::path::PathBuf;

use nalgebra::Vector3;

use crate::model::excess::Excess;
use crate::model::joints::JointVector;
use crate::model::load::Tool;
use crate::model::pose::Pose;

/// Round-off of a position of order 1 [rad or m]. The error of an n-th difference of positions is up to 2^n times this:
/// 4 times for an acceleration, 8 times for a jerk.
pub const POSITION_ROUND_OFF: f64 = 1e-12;

/// The file of the visible shape of a link, which is fixed in one of the [frames](Robot::frames) of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkMesh {
    /// The file: triangles as STL.
    pub file: PathBuf,
    /// The frame, by its place among those that are visited, the base's first.
    pub frame: usize,
    /// The pose of the shape in that frame, `X_LM` \[m\].
    pub pose: Pose,
    /// What the numbers of the file are multiplied by, to be metres.
    pub scale: [f64; 3],
}

/// A kind of robot. A value holds the geometry (nominal or calibrated, and the place of the base) and the limits.
///
/// Its values are plain data, which a recorder may use in a thread of its own.
///
/// To add a robot, write one file: implement this trait, and [`Driver`](crate::robot::Driver) for its drives.
pub trait Robot: Clone + Send + Sync + 'static {
    /// The kind's name, for messages: `"irp6"`.
    const KIND: &'static str;

    /// Whether a state can be demanded of it: of a cell none can.
    #[doc(hidden)]
    const MOVES: bool = true;

    /// Joint coordinates, `SVector<f64, N>`.
    type Joints: JointVector;

    /// The kind of joint `i`, from 0; revolute by default.
    fn joint(&self, _i: usize) -> JointKind {
        JointKind::Revolute
    }

    /// The limits that every demand is checked against.
    fn limits(&self) -> &Limits<Self::Joints>;

    /// Checks limits that cannot be expressed joint by joint, such as those of motors that several joints share, on the
    /// displacement from `from` to `to` \[rad or m\] in `duration` \[s\]. By default there are no such limits.
    ///
    /// # Errors
    /// The first [`CoupledLimit`] that the displacement breaks.
    fn check_coupled(
        &self,
        _from: &Self::Joints,
        _to: &Self::Joints,
        _duration: f64,
    ) -> Result<(), CoupledLimit> {
        Ok(())
    }

    /// The same on the displacement from `from` and on that from its end to a standstill, each with its time \[s\], > 0: for robots
    /// that compute something of each of the three positions.
    ///
    /// # Errors
    /// The first [`CoupledLimit`] that a displacement breaks.
    fn check_coupled_to_stop(
        &self,
        from: &Self::Joints,
        (to, duration): (&Self::Joints, f64),
        (stop, time): (&Self::Joints, f64),
    ) -> Result<(), CoupledLimit> {
        self.check_coupled(from, to, duration)?;
        self.check_coupled(to, stop, time)
    }

    /// The limits that [`check_coupled`](Robot::check_coupled) checks, in words, one in each line: what is limited, by what, and the unit.
    /// `--check` prints them. By default there are none.
    fn coupled_limits(&self) -> Vec<String> {
        Vec::new()
    }

    /// The name of the singularity near which `q` lies, if there is one: joints must turn fast there even if the tool
    /// moves slowly. If a demanded pose asks too much of the joints there, the fault gives this name. `None` by
    /// default.
    fn near_singularity(&self, _q: &Self::Joints) -> Option<&'static str> {
        None
    }

    /// Direct kinematics: `X_WF`, the pose of the flange in the world, for joint positions `q` [rad, m].
    fn forward(&self, q: &Self::Joints) -> Pose;

    /// Visits the frames of the links at `q`, `X_WL`, from the base to the flange, for pictures. The last frame is that
    /// of the flange, `forward(q)`. By default it is the only one.
    fn frames(&self, q: &Self::Joints, visit: &mut dyn FnMut(&Pose)) {
        visit(&self.forward(q));
    }

    /// Visits the capsules that stand for the links at `q`, in the world, for recordings: the ends of a capsule's segment
    /// \[m\], and its radius \[m\], finite, > 0. By default there are none, and a viewer is given bars between the
    /// [frames](Robot::frames).
    fn capsules_of_links(&self, _q: &Self::Joints, _visit: &mut dyn FnMut([Vector3<f64>; 2], f64)) {}

    /// The files of the links' visible shapes, for panels. By default there are none, and links are drawn as
    /// [capsules](Robot::capsules_of_links).
    fn meshes(&self) -> &[LinkMesh] {
        &[]
    }

    /// The robot as a URDF for programs of others: a `<robot>` of this name, from the world to the tool, with what a URDF
    /// cannot say of it in a comment. `None` by default.
    fn urdf(&self, _name: &str, _tool: &Tool) -> Option<String> {
        None
    }

    /// Inverse kinematics: the joint positions that put the flange at `X_WF`, on the branch nearest to `near`.
    ///
    /// Positions may lie outside the joint limits, which are checked when the demand is accepted.
    ///
    /// # Errors
    /// [`NoInverse`] when the pose is out of reach, when the joints cannot produce such a pose, or when there is no
    /// continuous solution at a singularity.
    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &Self::Joints) -> Result<Self::Joints, NoInverse>;

    /// Inverse kinematics of a redundant robot for a value of its redundancy, on the branch nearest to `near`. Each
    /// kind documents this value, such as a track's position \[m\] or an elbow's angle \[rad\].
    ///
    /// # Errors
    /// [`NoInverse`], as for [`inverse`](Robot::inverse); by default `NotRedundant`.
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

/// A broken limit that several joints share.
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
    /// The joints cannot produce such a pose, because they move the flange in fewer directions than the pose asks for:
    /// a tool that leans out of the plane of an arm with five joints, a pose beside the line of a gripper's finger.
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
    /// The demand gives a value of the redundancy, but the robot has no redundancy.
    #[error("the robot has no redundancy to choose")]
    NotRedundant,
    /// The iteration, which begins at the joint positions to stay near, found none that give the pose. There may be
    /// some elsewhere.
    #[error(
        "no joint positions were found from here: the pose nearest to the demanded one is off by {error:.1e}"
    )]
    NotConverged {
        /// The least error that it reached [parts of the robot's reach, and rad], > `tolerance`.
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
    /// In joint positions: the interpolation never asks for more than the demands did.
    #[default]
    Joints,
    /// In poses of the flange, where the demands are poses or displacements: a straight line of the flange stays
    /// straight between demands that are far apart, at the price of one inverse kinematics in each servo period. For
    /// robots whose joints are determined by the pose, in cells whose step has several servo periods. It is a fault if
    /// a pose between two demands has no joint positions, or if a joint would exceed its velocity limit in between.
    Task,
}
