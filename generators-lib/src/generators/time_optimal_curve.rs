//! Moves the tool along any curve in the least time that the joints allow, from rest to rest.

use mrroc::prelude::*;
use nalgebra::Translation3;

use mrroc_generators::curve::{CubicSpline, Curve};
use mrroc_generators::profile::ProfileCursor;
use mrroc_generators::timing::{PathLimits, TimeOptimal, grid, joint_spline};

/// Moves the tool from where it is along a curve, with a constant orientation, as fast as the velocity and acceleration
/// limits of all joints allow at every place, also near singularities. Jerk is not limited.
///
/// The displacements of the curve from its start are along the axes of the world. The demands are joint positions on a
/// spline, which is less than 1e-6 rad or m off the curve midway between its points.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::curve::Helix;
/// use mrroc_generators::generators::TimeOptimalCurve;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_generators::timing::PathLimits;
/// use mrroc_robots::{Irp6, Six};
/// use nalgebra::Vector3;
///
/// let helix = Helix::about(Vector3::zeros(), Vector3::x() * 0.05, Vector3::z_axis(), 3.0, 0.02);
/// let helix = helix.map_err(|bad| Fault::thrown(&bad.to_string()))?;
/// let limits = PathLimits { velocity: Six::repeat(0.2), acceleration: Six::repeat(1.0), speed: f64::INFINITY };
/// let irp6 = Irp6::nominal();
/// let demands = rehearse(TimeOptimalCurve::along(irp6.clone(), helix, limits), &irp6, Irp6::READY, 0.002)?;
/// // No joint is faster than its limit, and in the least time one of them is that fast.
/// let joints: Vec<Six> = demands.iter().filter_map(Demand::as_joints).collect();
/// let fastest = joints.windows(2).map(|q| (q[1] - q[0]).amax() / 0.002).fold(0.0, f64::max);
/// assert!(fastest <= 0.2 * (1.0 + 1e-6) && fastest > 0.199, "{fastest}");
/// # Ok::<(), Fault>(())
/// ```
pub struct TimeOptimalCurve<R: Robot, C> {
    robot: R,
    curve: C,
    limits: PathLimits<R::Joints>,
    path: Option<(CubicSpline<R::Joints>, ProfileCursor<TimeOptimal>)>,
}

impl<R: Robot, C: Curve> TimeOptimalCurve<R, C> {
    /// Along `curve` \[m\] with the joints of `robot` within `limits`, of which `speed` is the tool's [m/s]. Leave a tenth
    /// of the robot's limits to the operator's feed rate.
    #[must_use]
    pub fn along(robot: R, curve: C, limits: PathLimits<R::Joints>) -> Self {
        TimeOptimalCurve { robot, curve, limits, path: None }
    }

    fn advance(&mut self, t: Tick) -> Step<R> {
        let Some((path, cursor)) = &mut self.path else { return Step::Done };
        match cursor.advance(t.dt) {
            Some(point) => Step::Next(Demand::joints(path.at(point.s).value)),
            None => Step::Done,
        }
    }
}

#[generator(ecp)]
impl<R: Robot, C: Curve + 'static> TimeOptimalCurve<R, C> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        let here = e.demanded();
        let origin = self.curve.at(0.0).position;
        let pose = |s: f64| Translation3::from(self.curve.at(s).position - origin) * here.pose;
        let path = joint_spline(&self.robot, pose, self.curve.length(), &here.joints, 1e-6);
        let path = path.map_err(|error| Fault::thrown(&error.to_string()))?;
        let plan = TimeOptimal::plan(&path, &grid(&path, 200), &self.limits, [0.0; 2]);
        let plan = plan.map_err(|error| Fault::thrown(&error.to_string()))?;
        self.path = Some((path, ProfileCursor::new(plan)));
        Ok(self.advance(t))
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        self.advance(t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc_generators::curve::Helix;
    use mrroc_robots::{Irp6, SimulatedIrp6};
    use nalgebra::Vector3;
    use std::time::Duration;

    #[test]
    fn a_helix_is_executed_within_the_robots_own_limits() {
        let irp6 = Irp6::nominal();
        let start = Irp6::READY;
        let arm = SimulatedIrp6::new(irp6.clone(), &start);
        let shaft = arm.shaft();
        let turn = std::f64::consts::TAU;
        let helix = Helix::about(Vector3::x() * 0.05, Vector3::zeros(), Vector3::z_axis(), turn, 0.03);
        let helix = helix.expect("a helix");
        let of = *irp6.limits();
        let motion = irp6.clone();
        let limits = PathLimits { velocity: of.velocity, acceleration: of.acceleration, speed: 1.0 };
        let robot = RobotSetup::new("irp6", irp6.clone(), arm).program(move |ecp| {
            ecp.move_robot((), TimeOptimalCurve::along(motion.clone(), helix, limits)).map(drop)
        });
        let report = Cell::new(Duration::from_millis(1)).robot(robot).run().expect("within the limits");
        assert!(report.time.as_secs_f64() < 3.0, "{:?}", report.time);
        let up = irp6.forward(&shaft.state().position).translation.vector
            - irp6.forward(&start).translation.vector;
        // The simulated drives still settle.
        assert!((up - Vector3::z() * 0.03).norm() < 5e-3, "{up}");
    }
}
