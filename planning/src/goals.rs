//! Goals of a plan from poses, and from regions of them.

use core::f64::consts::PI;

use mrroc::pose::Pose;
use mrroc_robots::Kinematics;
use nalgebra::{SVector, Unit, UnitQuaternion, Vector3};

/// All joint positions [rad or m] within the limits at which the flange of `robot` stands at `X_WF`, as near to `near` as full turns
/// allow: any of them will do as a goal. Empty where there is none. An arm that is solved by iteration has one at most.
///
/// ```
/// use mrroc::robot::Robot;
/// use mrroc_planning::goals_at;
/// use mrroc_robots::Irp6;
///
/// let robot = Irp6::nominal();
/// let pose = robot.forward(&Irp6::READY);
/// let goals = goals_at(&robot, &pose, Irp6::READY.as_slice());
/// assert!(goals.iter().any(|q| (q[0] - Irp6::READY[0]).abs() < 1e-9));
/// ```
#[must_use]
#[allow(non_snake_case)]
pub fn goals_at<const N: usize, R: Kinematics<N>>(robot: &R, X_WF: &Pose, near: &[f64]) -> Vec<Vec<f64>> {
    let mut goals = Vec::new();
    let near = SVector::from_fn(|i, _| near.get(i).copied().unwrap_or_default());
    // Where there is no solution nothing is visited.
    let _ = robot.attainable(X_WF, &near, &mut |q| goals.push(q.as_slice().to_vec()));
    goals
}

/// The largest turn from one pose of a region to the next [rad].
const TURN: f64 = PI / 12.0;

/// As [`goals_at`], of all poses that are turned about an axis of the flange through its origin by up to `tolerance` \[rad\], 0 to pi, either
/// way: for a tool that may be turned about its own axis. `axis_F` is in the flange's frame, of any length but 0. Poses at most 15° apart are
/// looked at, the least turned first.
///
/// ```
/// use mrroc::robot::Robot;
/// use mrroc_planning::{goals_at, goals_turned};
/// use mrroc_robots::Irp6;
///
/// let robot = Irp6::nominal();
/// let (pose, near) = (robot.forward(&Irp6::READY), Irp6::READY.as_slice());
/// let all = goals_turned(&robot, &pose, nalgebra::Vector3::z(), 0.3, near);
/// assert!(all.len() > goals_at(&robot, &pose, near).len());
/// ```
#[must_use]
#[allow(non_snake_case)]
pub fn goals_turned<const N: usize, R: Kinematics<N>>(
    robot: &R,
    X_WF: &Pose,
    axis_F: Vector3<f64>,
    tolerance: f64,
    near: &[f64],
) -> Vec<Vec<f64>> {
    let Some(axis) = Unit::try_new(axis_F, 0.0) else { return goals_at(robot, X_WF, near) };
    let tolerance = tolerance.clamp(0.0, PI);
    let steps = (tolerance / TURN).ceil();
    let mut goals = goals_at(robot, X_WF, near);
    for k in 1..=steps as u32 {
        let turn = tolerance * f64::from(k) / steps;
        for turn in [turn, -turn] {
            let X_FG = UnitQuaternion::from_axis_angle(&axis, turn);
            goals.extend(goals_at(robot, &(X_WF * X_FG), near));
        }
    }
    goals
}
