//! Moves the joints through positions in the least time, from rest to rest.

use mrroc::prelude::*;
use mrroc::robot::JointVector;

use mrroc_generators::curve::{CubicSpline, CurveError};
use mrroc_generators::profile::ProfileCursor;
use mrroc_generators::timing::{PathLimits, TimeOptimal, grid};
use mrroc_generators::waypoints::PointsError;

/// Moves the joints from where they are through all points without a stop, on the natural cubic spline, as fast as the
/// velocity and acceleration limits of all joints allow at every place: one of them is always reached. Jerk is not
/// limited.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::TimeOptimalJoints;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_generators::timing::PathLimits;
/// use mrroc_robots::{Irp6, Six};
///
/// let limits = PathLimits { velocity: Six::repeat(1.0), acceleration: Six::repeat(0.8), speed: f64::INFINITY };
/// let goal = Irp6::READY + Six::x() * 0.2;
/// let motion = TimeOptimalJoints::through(vec![goal], limits);
/// let demands = rehearse(motion, &Irp6::nominal(), Irp6::READY, 0.002)?;
/// // One joint, from rest to rest: 2 sqrt(D / A) = 1 s, within what the grid of the plan costs.
/// assert!((500..=510).contains(&demands.len()), "{}", demands.len());
/// assert!(demands.last().and_then(Demand::as_joints).is_some_and(|q| (q - goal).amax() < 1e-9));
/// # Ok::<(), Fault>(())
/// ```
pub struct TimeOptimalJoints<R: Robot> {
    points: Vec<R::Joints>,
    limits: PathLimits<R::Joints>,
    path: Option<(CubicSpline<R::Joints>, ProfileCursor<TimeOptimal>)>,
    /// Where it leads, the end last: told one in each step.
    goals: Vec<R::Joints>,
}

impl<R: Robot> TimeOptimalJoints<R> {
    /// Through `points` [rad or m] within `limits`, of which `speed` is that along the chords between the points. Leave a
    /// tenth of the robot's limits to the operator's feed rate.
    #[must_use]
    pub fn through(points: Vec<R::Joints>, limits: PathLimits<R::Joints>) -> Self {
        TimeOptimalJoints { points, limits, path: None, goals: Vec::new() }
    }

    /// Along a `path` that begins where the joints are, by a `plan` that was made before, for example with torque
    /// limits.
    #[must_use]
    pub fn planned(path: CubicSpline<R::Joints>, plan: TimeOptimal) -> Self {
        let zeros = R::Joints::zeros();
        let limits = PathLimits { velocity: zeros, acceleration: zeros, speed: f64::INFINITY };
        let goals = vec![path.at(path.range().1).value];
        TimeOptimalJoints { points: Vec::new(), limits, path: Some((path, ProfileCursor::new(plan))), goals }
    }

    /// Plans the motion from `start` through the points.
    fn plan(&mut self, start: R::Joints) -> Result<(), Fault> {
        self.goals.clone_from(&self.points);
        self.points.insert(0, start);
        let path = match CubicSpline::by_chords(&self.points) {
            // It is there.
            Err(CurveError::Points(PointsError::Coincident)) => return Ok(()),
            path => path.map_err(|error| Fault::thrown(&error.to_string()))?,
        };
        let plan = TimeOptimal::plan(&path, &grid(&path, 200), &self.limits, [0.0; 2]);
        let plan = plan.map_err(|error| Fault::thrown(&error.to_string()))?;
        self.path = Some((path, ProfileCursor::new(plan)));
        Ok(())
    }

    fn advance(&mut self, t: Tick) -> Step<R> {
        let Some((path, cursor)) = &mut self.path else { return Step::Done };
        let Some(point) = cursor.advance(t.dt) else { return Step::Done };
        let step = Step::Next(Demand::joints(path.at(path.range().0 + point.s).value));
        match self.goals.pop() {
            Some(goal) => step.with_goal(Demand::joints(goal)),
            None => step,
        }
    }
}

#[generator(ecp)]
impl<R: Robot> TimeOptimalJoints<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        let start = e.demanded().joints;
        match &self.path {
            None => self.plan(start)?,
            Some((path, _)) => {
                let off = path.at(path.range().0).value - start;
                if !off.as_slice().iter().all(|x| x.abs() <= 1e-6) {
                    return Err(Fault::thrown("the path does not begin where the joints are"));
                }
            }
        }
        Ok(self.advance(t))
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        self.advance(t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc_robots::{Irp6, Six};

    #[test]
    fn some_joint_is_at_a_limit_throughout_and_none_beyond() {
        let robot = Irp6::nominal();
        let start = Irp6::READY;
        let at = |x: f64, y: f64| start + Six::new(x, y, -0.5 * x, 0.0, y * x, 0.3 * x);
        let points = vec![at(0.2, 0.1), at(0.4, -0.1), at(0.3, 0.2), at(0.0, 0.1)];
        let limits =
            PathLimits { velocity: Six::repeat(0.5), acceleration: Six::repeat(2.0), speed: f64::INFINITY };
        let state = RobotState { joints: start, velocity: Six::zeros(), pose: robot.forward(&start) };
        let mut motion = TimeOptimalJoints::<Irp6>::through(points.clone(), limits);
        let tick = Tick { step: 0, dt: 1e-3, duration: 1e-3 };
        let mut step = motion.first_step(&State::new(RobotImage::new(state, state)), tick).expect("a plan");
        let mut trace = vec![start, start];
        while let Step::Next(demand) = step {
            trace.push(demand.as_joints().expect("joints"));
            step = motion.next_step(tick);
        }
        assert_eq!(trace.last(), points.last());
        let mut at_limit = 0;
        for q in trace.windows(3) {
            let v0 = (q[1] - q[0]) / 1e-3;
            let v1 = (q[2] - q[1]) / 1e-3;
            let share = (v1.amax() / 0.5).max((v1 - v0).amax() / 1e-3 / 2.0);
            assert!(share < 1.0 + 1e-6, "{share}");
            at_limit += usize::from(share > 0.97);
        }
        assert!(at_limit * 10 > trace.len() * 9, "at a limit in {at_limit} of {} steps", trace.len());
    }
}
