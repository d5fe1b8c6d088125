//! Demanded poses become joint positions here, or faults that say why not.
//!
//! In: a pose of the tool or the flange. Out: joints, by the robot's inverse kinematics; or the pose, the singularity, the
//! reach.

use nalgebra::{Translation3, UnitQuaternion};

use crate::model::demand::{Coordinates, Demand};
use crate::model::fault::{Fault, FaultKind};
use crate::model::pose::Pose;
use crate::model::robot::{NoInverse, Robot};

/// Deviation of a quaternion's norm from 1 below which a rotation is taken, normalised.
const FRAME_TOLERANCE: f64 = 1e-6;

/// How far from a demanded pose `forward` of its `inverse` may be \[m\].
const AGREEMENT: f64 = 1e-3;

/// The message of a robot whose `inverse` and `forward` do not belong to one arm.
pub(crate) const DISAGREEMENT: &str = "`forward` of the joints that `inverse` gives is another pose";

/// How the message of [`NoInverse::NotAttainable`] begins.
pub(crate) const NOT_ATTAINABLE: &str = "not attainable";

/// The message of [`NoInverse::NotRedundant`].
pub(crate) const NOT_REDUNDANT: &str = "a redundancy is demanded of a robot that has none";

/// How the message of [`NoInverse::NotConverged`] begins.
pub(crate) const NOT_FOUND: &str = "no joints found from here";

/// A pose of the tool that is demanded, and how.
#[derive(Clone, Copy)]
pub(super) struct ToolPose<'a> {
    /// `X_WE`.
    pub pose: &'a Pose,
    /// `X_FE`.
    pub tool: &'a Pose,
    /// The value of the robot's redundancy that is asked for.
    pub redundancy: Option<f64>,
}

/// The joints that put the tool there, on the branch nearest to `near`.
pub(super) fn joints_at<R: Robot>(
    robot: &R,
    at: &ToolPose<'_>,
    near: &R::Joints,
) -> Result<R::Joints, Fault> {
    let flange = at.pose * at.tool.inverse();
    let joints = match at.redundancy {
        None => robot.inverse(&flange, near),
        Some(value) if value.is_finite() => robot.inverse_at(&flange, value, near),
        Some(_) => return Err(Fault::new(FaultKind::DemandNotFinite).text("the redundancy")),
    };
    joints.map_err(|error| no_inverse(&error, at.pose, "tool"))
}

/// The joints that put the flange at `pose`, on the branch nearest to `near`.
pub(super) fn flange_joints<R: Robot>(robot: &R, pose: &Pose, near: &R::Joints) -> Result<R::Joints, Fault> {
    robot.inverse(pose, near).map_err(|error| no_inverse(&error, pose, "flange"))
}

/// Whether a pose that breaks a limit does so because the robot's `inverse` does not belong to its `forward`: `q` is what
/// `inverse` gave.
pub(super) fn disagreement<R: Robot>(
    robot: &R,
    demand: &Demand<R>,
    q: &R::Joints,
    tool: &Pose,
) -> Option<Fault> {
    let Coordinates::Pose(pose) = &demand.coordinates else { return None };
    let off = (robot.forward(q) * tool).translation.vector - pose.translation.vector;
    (off.norm() > AGREEMENT).then(|| {
        Fault::new(FaultKind::NoInverseKinematics).text(DISAGREEMENT).exceeds(off.norm(), AGREEMENT, "m")
    })
}

/// Names the singularity beside which a demanded pose asks too much of the joints, which are at `q`.
pub(super) fn beside_singularity<R: Robot>(
    robot: &R,
    demand: &Demand<R>,
    q: &R::Joints,
    fault: Fault,
) -> Fault {
    match (&demand.coordinates, robot.near_singularity(q)) {
        (Coordinates::Pose(_) | Coordinates::Displacement(_), Some(name)) if fault.message().is_empty() => {
            fault.text(name)
        }
        (Coordinates::Pose(_) | Coordinates::Displacement(_), Some(name)) => {
            let text = format!("{}, {name}", fault.message());
            fault.text(&text)
        }
        (Coordinates::Hold | Coordinates::Joints(_), _) | (_, None) => fault,
    }
}

/// The fault of a pose that has no joint positions; `frame` is what was to go there.
pub(super) fn no_inverse(error: &NoInverse, pose: &Pose, frame: &str) -> Fault {
    let fault = Fault::new(FaultKind::NoInverseKinematics);
    let Translation3 { vector: p } = pose.translation;
    let at = format!("{frame} demanded at ({:.4}, {:.4}, {:.4}) m", p.x, p.y, p.z);
    match *error {
        NoInverse::OutOfReach { distance, min, max } => {
            let limit = if distance > max { max } else { min };
            let text = format!("out of reach, {at}: wrist to shoulder");
            fault.text(&text).exceeds(distance, limit, "m")
        }
        NoInverse::Singular { name } => fault.text(&format!("at a singularity ({name}), {at}")),
        NoInverse::NotAttainable { what, actual, tolerance, unit } => {
            fault.text(&format!("{NOT_ATTAINABLE}, {at}: {what}")).exceeds(actual, tolerance, unit)
        }
        NoInverse::NotRedundant => fault.text(NOT_REDUNDANT),
        NoInverse::NotConverged { error, tolerance } => {
            fault.text(&format!("{NOT_FOUND}, {at}: off by {error:.1e}, at most {tolerance:.0e}"))
        }
    }
}

/// A pose whose numbers are finite and whose quaternion is a rotation, normalised.
pub(super) fn valid_frame(pose: &Pose) -> Result<Pose, Fault> {
    let q = pose.rotation.coords;
    if !(pose.translation.vector.iter().chain(q.iter()).all(|x| x.is_finite())) {
        return Err(Fault::new(FaultKind::DemandNotFinite));
    }
    let norm = q.norm();
    if (norm - 1.0).abs() > FRAME_TOLERANCE {
        let fault =
            Fault::new(FaultKind::DemandInvalidFrame).text("the norm of its quaternion differs from 1");
        return Err(fault.exceeds((norm - 1.0).abs(), FRAME_TOLERANCE, ""));
    }
    Ok(Pose::from_parts(pose.translation, UnitQuaternion::new_normalize(pose.rotation.into_inner())))
}
