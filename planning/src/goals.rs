//! Goals of a plan from poses.

use mrroc::pose::Pose;
use mrroc_robots::Kinematics;
use nalgebra::SVector;

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
