//! Goals of motions, which are looked at before the motions come to them.
//!
//! In: where a motion leads, as its first demand says. Out: a fault if the robot certainly cannot be there. Nothing is refused
//! for a search that did not find joints from here: from nearer it may.

use crate::model::beside::{GOAL_ROUND_OFF, Goal};
use crate::model::fault::{Fault, FaultKind};
use crate::model::joints::JointVector;
use crate::model::pose::Pose;
use crate::model::robot::{NoInverse, Robot};

use super::poses::no_inverse;

/// How the message about a goal begins.
pub(crate) const GOAL: &str = "its goal";

/// The motion that has a goal, as the robot knows it at its start.
pub(super) struct Setting<'a, J> {
    /// The pose of the flange at its start, `X_WF`.
    pub start: Pose,
    /// The tool of the demand that names the goal, `X_FE`.
    pub tool: &'a Pose,
    /// The value of the robot's redundancy that this demand asks for.
    pub redundancy: Option<f64>,
    /// The joint positions at the start [rad or m].
    pub near: &'a J,
}

/// Whether the robot can be where its motion leads, as far as that is certain.
///
/// # Errors
/// It cannot.
pub(super) fn check<R: Robot>(
    robot: &R,
    goal: &Goal<R::Joints>,
    setting: &Setting<'_, R::Joints>,
) -> Result<(), Fault> {
    let (pose, frame) = match goal {
        Goal::Joints(q) => return check_joints(robot, q),
        Goal::Pose(pose) => (*pose, "tool"),
        Goal::Displacement(displacement) => (setting.start * setting.tool * displacement, "tool"),
    };
    if !pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite()) {
        return Err(Fault::new(FaultKind::DemandNotFinite).text(GOAL));
    }
    let flange = pose * setting.tool.inverse();
    let found = match setting.redundancy {
        None => robot.inverse(&flange, setting.near),
        Some(value) => robot.inverse_at(&flange, value, setting.near),
    };
    let Err(error) = found else { return Ok(()) };
    let is_certain = match &error {
        NoInverse::OutOfReach { distance, min, max } => {
            let beyond = (distance - max).max(min - distance);
            beyond > GOAL_ROUND_OFF * max.max(1.0)
        }
        NoInverse::NotAttainable { actual, tolerance, .. } => *actual > tolerance + GOAL_ROUND_OFF,
        NoInverse::Singular { .. } | NoInverse::NotRedundant | NoInverse::NotConverged { .. } => false,
    };
    if !is_certain {
        return Ok(());
    }
    let fault = no_inverse(&error, &pose, frame);
    let text = format!("{GOAL}: {}", fault.message());
    Err(fault.text(&text))
}

fn check_joints<R: Robot>(robot: &R, q: &R::Joints) -> Result<(), Fault> {
    let limits = robot.limits();
    for i in 0..R::Joints::LEN {
        let fault = || Fault::new(FaultKind::DemandOutOfRange).at_joint(i).text(GOAL);
        let (at, lower, upper) = (q[i], limits.lower[i], limits.upper[i]);
        let round_off = GOAL_ROUND_OFF * at.abs().max(1.0);
        let unit = robot.joint(i).unit(0);
        if !at.is_finite() {
            return Err(Fault::new(FaultKind::DemandNotFinite).at_joint(i).text(GOAL));
        } else if at > upper + round_off {
            return Err(fault().exceeds(at, upper, unit));
        } else if at < lower - round_off {
            return Err(fault().exceeds(at, lower, unit));
        }
    }
    // The limits that joints share, of a robot that stands there.
    robot.check_coupled(q, q, 1.0).or_else(|limit| {
        let excess = limit.excess;
        let beyond = (excess.actual - excess.limit).abs();
        // By the numbers that were lost, a shared limit is missed by as many times more as its joints are geared.
        if beyond <= 1e3 * GOAL_ROUND_OFF * excess.limit.abs().max(1.0) {
            return Ok(());
        }
        let fault = Fault::new(FaultKind::DemandOutOfRange).at_joint(limit.joint);
        Err(fault.text(&format!("{GOAL}: {}", limit.what)).exceeds_by(excess))
    })
}
