//! Whether every arm can follow a body, asked before anything moves; and arms that have fewer joints than a pose has
//! coordinates.
//!
//! An arm follows pose by pose, each on the branch nearest to the one before. With a [`FreeDirection`], in which the grasp
//! transmits nothing (a turn about the tool's own axis, say), the tool may turn or slide in it, by `x`, to where the joints
//! can put it:
//!
//! ```text
//! X_WF(q) X_FE = X_WE Exp(a x)                            to be solved for q and x
//! (q, x) += (J, -a)^T [(J, -a) (J, -a)^T]^-1 e,           e = Log of the error, in the tool's axes
//! ```
//!
//! Least changes of `q` and `x` (Gauss-Newton, lengths in metres and angles in radians alike), so that redundant arms are
//! resolved as well; `J` is the Jacobian of the tool, from central differences of the direct kinematics. The direction in
//! which an arm fails is the one that `J` gives least: the eigenvector of the smallest eigenvalue of `J J^T` (Yoshikawa 1985),
//! with a turn of 1 rad counted like a distance of 0.1 m, about the size of a gripper: what is asked of a grasp is first its place.

use core::fmt;

use mrroc::fault::Name;
use mrroc::prelude::*;
use mrroc::robot::{JointVector, NoInverse, RobotState};
use nalgebra::{Matrix6, SymmetricEigen, Translation3, Unit, UnitQuaternion, Vector3, Vector6};
use thiserror::Error;

use super::{BodyFrame, BodyPath};

/// Half a difference of the Jacobian [rad or m]: errors of the order of its square.
const DIFFERENCE: f64 = 1e-5;
/// What remains of an error of the pose when it is solved [m, rad].
const SOLVED: f64 = 1e-11;
/// The distance that counts like a turn of 1 rad \[m\].
const GRIPPER: f64 = 0.1;
/// Iterations, from the step before: two or three are needed.
const ITERATIONS: usize = 30;

/// A direction in the tool's frame E in which a grasp transmits nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FreeDirection {
    /// A turn about an axis of E through its origin.
    Turn(Unit<Vector3<f64>>),
    /// A slide along a direction of E.
    Slide(Unit<Vector3<f64>>),
}

impl FreeDirection {
    /// The pose of the tool turned or slid by `x` [rad or m].
    fn pose(&self, x: f64) -> Pose {
        match self {
            FreeDirection::Turn(axis) => Pose::rotation(axis.into_inner() * x),
            FreeDirection::Slide(axis) => {
                Pose::from_parts(Translation3::from(axis.into_inner() * x), UnitQuaternion::identity())
            }
        }
    }

    fn twist(&self) -> Vector6<f64> {
        match self {
            FreeDirection::Turn(axis) => twist(&Vector3::zeros(), axis),
            FreeDirection::Slide(axis) => twist(axis, &Vector3::zeros()),
        }
    }
}

fn twist(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

/// The twist that leads from one pose to another, in the axes of the first.
fn difference(from: &Pose, to: &Pose) -> Vector6<f64> {
    let by = from.inv_mul(to);
    twist(&by.translation.vector, &by.rotation.scaled_axis())
}

/// A direction of motion of a tool, in its own axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Of the origin, per unit of the direction.
    pub moving: Vector3<f64>,
    /// Of turning, per unit of the direction.
    pub turning: Vector3<f64>,
}

/// `turning about (0.00, 1.00, 0.00)`, or what is the greater part of it.
impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (how, v) = if self.turning.norm() * GRIPPER >= self.moving.norm() {
            ("turning about", self.turning.normalize())
        } else {
            ("moving along", self.moving.normalize())
        };
        // The sign of an eigenvector is by chance: the largest component is shown as positive.
        let v = if v[v.iamax()] < 0.0 { -v } else { v };
        // Adding zero shows -0 as 0.
        let [x, y, z] = [v.x, v.y, v.z].map(|c| (c * 100.0).round() / 100.0 + 0.0);
        write!(f, "{how} ({x:.2}, {y:.2}, {z:.2})")
    }
}

/// What keeps an arm from a pose.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Cause {
    /// The pose has no joint positions.
    #[error(transparent)]
    NoInverse(#[from] NoInverse),
    /// The joint positions of the pose break a limit.
    #[error("joint {joint} at {actual:.4} {unit} is beyond {limit:.4} {unit}")]
    Limit {
        /// The joint, counted from 1.
        joint: usize,
        /// The value asked for.
        actual: f64,
        /// The value allowed.
        limit: f64,
        /// The unit of both.
        unit: &'static str,
    },
    /// No joint positions give the pose, and no amount of the free direction either.
    #[error("joints and free direction leave an error of {0:.1e} m and rad")]
    NotSolved(f64),
}

/// Why a motion of a body is refused: an arm cannot follow.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("{} cannot follow in {direction} at {time:.3} s: {cause}", arm.as_ref().map_or("the arm", Name::as_str))]
pub struct Unattainable {
    /// The robot, if its model has a name.
    pub arm: Option<Name>,
    /// Path time \[s\]; 0 at the start.
    pub time: f64,
    /// The direction of its tool that its joints give least where it fails; where one has come to a limit, the others.
    pub direction: Direction,
    /// Why.
    pub cause: Cause,
}

/// Why a dry run failed.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DryRunError {
    /// An arm cannot follow.
    #[error(transparent)]
    Unattainable(#[from] Box<Unattainable>),
    /// The path itself is faulty.
    #[error(transparent)]
    Path(#[from] Fault),
    /// The increment of path time is not positive.
    #[error("a dry run needs an increment of path time greater than 0, not {0} s")]
    Increment(f64),
}

/// The motion is refused by a fault of the program, which names the arm and the direction.
impl From<DryRunError> for Fault {
    fn from(error: DryRunError) -> Fault {
        match error {
            DryRunError::Path(fault) => fault,
            DryRunError::Unattainable(refused) => Fault::from(&*refused),
            DryRunError::Increment(_) => Fault::thrown(&error.to_string()),
        }
    }
}

/// A fault of the program; its text is short, so a limit's numbers go beside it.
impl From<&Unattainable> for Fault {
    fn from(refused: &Unattainable) -> Fault {
        let Unattainable { direction, time, cause, .. } = refused;
        match *cause {
            Cause::Limit { joint, actual, limit, unit } => {
                let arm = refused.arm.as_ref().map_or("the arm", Name::as_str);
                let text = format!("{arm} cannot follow in {direction} at {time:.3} s: joint {joint}");
                Fault::thrown(&text).exceeds(actual, limit, unit)
            }
            Cause::NoInverse(_) | Cause::NotSolved(_) => Fault::thrown(&refused.to_string()),
        }
    }
}

/// A model of an arm that is led through poses of its tool before the arm itself moves.
pub trait ArmModel {
    /// Where its tool is.
    fn tool(&self) -> Pose;

    /// Moves its tool to `X_WE`, in the free direction as far as needed.
    ///
    /// # Errors
    /// It cannot; it stays where it was.
    #[allow(non_snake_case)]
    fn follow(&mut self, X_WE: &Pose) -> Result<(), Box<Unattainable>>;
}

/// An arm's kinematics, its joint positions and its tool.
#[derive(Clone, Debug)]
#[allow(non_snake_case)]
pub struct Arm<R: Robot> {
    name: Option<Name>,
    robot: R,
    start: Pose,
    joints: R::Joints,
    X_FE: Pose,
    free: Option<(FreeDirection, f64)>,
}

#[allow(non_snake_case)]
impl<R: Robot> Arm<R> {
    /// The arm with these kinematics in this state, such as `rnt.demanded()` of a handle; a handle knows it from the first
    /// Move or Wait on that names the robot.
    #[must_use]
    pub fn new(robot: R, state: &RobotState<R>) -> Self {
        let X_FE = robot.forward(&state.joints).inv_mul(&state.pose);
        Arm { name: None, robot, start: state.pose, joints: state.joints, X_FE, free: None }
    }

    /// The same arm with a name for messages, such as `rnt.name()` of a handle.
    #[must_use]
    pub fn named(self, name: Name) -> Self {
        Arm { name: Some(name), ..self }
    }

    /// The same arm with a grasp that transmits nothing in this direction.
    #[must_use]
    pub fn free_in(self, direction: FreeDirection) -> Self {
        Arm { free: Some((direction, 0.0)), ..self }
    }

    /// Its joint positions [rad or m].
    #[must_use]
    pub const fn joints(&self) -> &R::Joints {
        &self.joints
    }

    /// `X_WE` of its tool in the state that it was made from.
    #[must_use]
    pub const fn start(&self) -> &Pose {
        &self.start
    }

    /// How far its tool is in its free direction [rad or m].
    #[must_use]
    pub fn freely(&self) -> f64 {
        self.free.map_or(0.0, |(_, x)| x)
    }

    fn pose_at(&self, q: &R::Joints) -> Pose {
        self.robot.forward(q) * self.X_FE
    }

    /// Column `i` of the tool's Jacobian, in the tool's axes.
    fn column(&self, q: &R::Joints, i: usize) -> Vector6<f64> {
        let at = |x: f64| self.pose_at(&R::Joints::from_joints(|j| if i == j { q[j] + x } else { q[j] }));
        difference(&at(-DIFFERENCE), &at(DIFFERENCE)) / (2.0 * DIFFERENCE)
    }

    /// `J J^T`, without the column of a joint that has come to its limit.
    fn mobility(&self, q: &R::Joints, stopped: Option<usize>) -> Matrix6<f64> {
        (0..R::Joints::LEN)
            .filter(|&i| Some(i) != stopped)
            .map(|i| self.column(q, i))
            .fold(Matrix6::zeros(), |sum, c| sum + c * c.transpose())
    }

    /// The direction that the joints give least, without one that is `stopped`.
    fn weakest(&self, q: &R::Joints, stopped: Option<usize>) -> Direction {
        let scale = Matrix6::from_diagonal(&Vector6::new(GRIPPER, GRIPPER, GRIPPER, 1.0, 1.0, 1.0));
        let unscale = Matrix6::from_diagonal(&scale.diagonal().map(f64::recip));
        let eigen = SymmetricEigen::new(unscale * self.mobility(q, stopped) * unscale);
        let v = scale * eigen.eigenvectors.column(eigen.eigenvalues.imin());
        Direction { moving: v.fixed_rows::<3>(0).into(), turning: v.fixed_rows::<3>(3).into() }
    }

    /// Joint positions and the amount of the free direction that give the pose, from those that it has.
    fn solve(&self, X_WE: &Pose, direction: &FreeDirection, x: f64) -> Result<(R::Joints, f64), Cause> {
        let mut q = self.joints;
        let mut x = x;
        let a = direction.twist();
        let mut left = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let error = difference(&self.pose_at(&q), &(X_WE * direction.pose(x)));
            left = error.amax();
            if left <= SOLVED {
                return Ok((q, x));
            }
            let Some(inverse) = (self.mobility(&q, None) + a * a.transpose()).try_inverse() else { break };
            let y = inverse * error;
            q = R::Joints::from_joints(|i| q[i] + self.column(&q, i).dot(&y));
            x -= a.dot(&y);
        }
        Err(Cause::NotSolved(left))
    }

    fn within_limits(&self, q: &R::Joints) -> Result<(), Cause> {
        let limits = self.robot.limits();
        for i in 0..R::Joints::LEN {
            let limit = q[i].clamp(limits.lower[i], limits.upper[i]);
            if limit != q[i] {
                return Err(Cause::Limit {
                    joint: i + 1,
                    actual: q[i],
                    limit,
                    unit: self.robot.joint(i).unit(0),
                });
            }
        }
        let shared = self.robot.check_coupled(q, q, 1.0);
        shared.map_err(|over| Cause::Limit {
            joint: over.joint + 1,
            actual: over.excess.actual,
            limit: over.excess.limit,
            unit: over.excess.unit,
        })
    }

    fn moved(&self, X_WE: &Pose) -> Result<(R::Joints, f64), Cause> {
        let (q, x) = match &self.free {
            Some((direction, x)) => self.solve(X_WE, direction, *x)?,
            None => (self.robot.inverse(&(X_WE * self.X_FE.inverse()), &self.joints)?, 0.0),
        };
        self.within_limits(&q)?;
        Ok((q, x))
    }
}

impl<R: Robot> ArmModel for Arm<R> {
    fn tool(&self) -> Pose {
        self.pose_at(&self.joints)
    }

    #[allow(non_snake_case)]
    fn follow(&mut self, X_WE: &Pose) -> Result<(), Box<Unattainable>> {
        let (q, x) = self.moved(X_WE).map_err(|cause| {
            let stopped = match cause {
                Cause::Limit { joint, .. } => joint.checked_sub(1),
                Cause::NoInverse(_) | Cause::NotSolved(_) => None,
            };
            let direction = self.weakest(&self.joints, stopped);
            Box::new(Unattainable { arm: self.name, time: 0.0, direction, cause })
        })?;
        self.joints = q;
        if let Some((_, amount)) = &mut self.free {
            *amount = x;
        }
        Ok(())
    }
}

/// Leads the arms along the whole path in increments of `dt` \[s\], > 0, each with its grasp on the body: what a program
/// does before a Move. Returns the path's duration \[s\]. Not for step functions: it computes the whole motion at once.
///
/// # Errors
/// The first arm that cannot follow, with the path time and the direction; a faulty path.
#[allow(non_snake_case)]
pub fn dry_run(
    mut path: impl BodyPath,
    dt: f64,
    body: BodyFrame,
    arms: &mut [&mut dyn ArmModel],
) -> Result<f64, DryRunError> {
    if !(dt.is_finite() && dt > 0.0) {
        return Err(DryRunError::Increment(dt));
    }
    let mut tools = Vec::with_capacity(arms.len());
    tools.extend(arms.iter().map(|arm| arm.tool()));
    let X_WB = body.pose(&tools);
    let X_BE: Vec<Pose> = tools.iter().map(|X_WE| X_WB.inv_mul(X_WE)).collect();
    path.begin(&X_WB)?;
    let mut steps = 0_u32;
    while let Some(X_WB) = path.advance(dt)? {
        steps += 1;
        for (arm, X_BE) in arms.iter_mut().zip(&X_BE) {
            let time = f64::from(steps) * dt;
            arm.follow(&(X_WB * X_BE)).map_err(|mut refused| {
                refused.time = time;
                refused
            })?;
        }
    }
    Ok(f64::from(steps) * dt)
}
