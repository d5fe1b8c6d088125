//! Moves the tool through poses on a smooth spline without a stop, with limited jerk, from rest to rest.

use core::marker::PhantomData;

use mrroc::prelude::*;

use mrroc_generators::curve::{CurveError, PoseSpline};
use mrroc_generators::line::SmoothToolLimits;
use mrroc_generators::profile::{JerkLimits, ProfileCursor, SevenPhase};
use mrroc_generators::waypoints::PointsError;

/// Displacement of the tool that counts like a turn of 1 rad \[m\].
const TURN: f64 = 0.1;

/// Moves the tool from where it is exactly through all poses, on a spline without jumps of linear or angular
/// acceleration.
///
/// The speed along the spline keeps the tool within its velocities and accelerations: with `|x'|`, `|x''|` the largest on it,
/// `u' <= V / |x'|` and `u'^2 |x''| + u'' |x'| <= A`, half of it for either. Jerk is limited along the spline.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::PoseSplineMove;
/// use mrroc_generators::line::SmoothToolLimits;
/// use mrroc_generators::profile::JerkLimits;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::Irp6;
///
/// let irp6 = Irp6::nominal();
/// let limits = JerkLimits { velocity: 0.1, acceleration: 0.5, jerk: 5.0 };
/// let limits = SmoothToolLimits { translation: limits, rotation: limits };
/// let at = |x, y| irp6.forward(&Irp6::READY) * Pose::translation(x, y, 0.0);
/// let motion = PoseSplineMove::through(vec![at(0.08, 0.0), at(0.08, 0.08)], limits);
/// let demands = rehearse(motion, &irp6, Irp6::READY, 0.002)?;
/// // It passes the first pose within half a step at 0.1 m/s, and ends at the last one.
/// let off = |pose: Pose, x, y| (pose.translation.vector - at(x, y).translation.vector).norm();
/// assert!(demands.iter().filter_map(Demand::as_pose).any(|pose| off(pose, 0.08, 0.0) <= 1e-4));
/// assert!(demands.last().and_then(Demand::as_pose).is_some_and(|pose| off(pose, 0.08, 0.08) < 1e-9));
/// # Ok::<(), Fault>(())
/// ```
pub struct PoseSplineMove<R> {
    poses: Vec<Pose>,
    limits: SmoothToolLimits,
    path: Option<(PoseSpline, ProfileCursor<SevenPhase>)>,
    /// Where it leads, the end last: told one in each step.
    goals: Vec<Pose>,
    of: PhantomData<R>,
}

impl<R: Robot> PoseSplineMove<R> {
    /// Through `poses` `X_WE` of the tool in the world within `limits`.
    #[must_use]
    pub fn through(poses: Vec<Pose>, limits: SmoothToolLimits) -> Self {
        PoseSplineMove { poses, limits, path: None, goals: Vec::new(), of: PhantomData }
    }

    fn advance(&mut self, t: Tick) -> Step<R> {
        let Some((spline, cursor)) = &mut self.path else { return Step::Done };
        let Some(point) = cursor.advance(t.dt) else { return Step::Done };
        let step = Step::Next(Demand::pose(spline.at(point.s)));
        match self.goals.pop() {
            Some(goal) => step.with_goal(Demand::pose(goal)),
            None => step,
        }
    }
}

/// Limits of the spline's parameter.
fn along(spline: &PoseSpline, limits: SmoothToolLimits) -> JerkLimits {
    let bounds = spline.bounds();
    let shares = [(bounds.translation, limits.translation), (bounds.rotation, limits.rotation)];
    let mut unit = JerkLimits { velocity: f64::MAX, acceleration: f64::MAX, jerk: f64::MAX };
    for ((first, second), JerkLimits { velocity, acceleration, jerk }) in shares {
        let half = 0.5 * acceleration;
        // A limit that is not a number must stay so, to be refused: `f64::min` would drop it.
        let least = |a: f64, b: f64| if a <= b { a } else { b };
        unit.velocity = least(least(unit.velocity, velocity / first), (half / second).sqrt());
        unit.acceleration = least(unit.acceleration, half / first);
        unit.jerk = least(unit.jerk, jerk / first);
    }
    unit
}

#[generator(ecp)]
impl<R: Robot> PoseSplineMove<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        self.goals.clone_from(&self.poses);
        self.poses.insert(0, e.demanded().pose);
        let spline = match PoseSpline::by_chords(&self.poses, TURN) {
            // It is there.
            Err(CurveError::Points(PointsError::Coincident)) => return Ok(Step::Done),
            spline => spline.map_err(|error| Fault::thrown(&error.to_string()))?,
        };
        let length = spline.range().1;
        let profile = SevenPhase::new(length, along(&spline, self.limits));
        let profile = profile.map_err(|error| Fault::thrown(&error.to_string()))?;
        self.path = Some((spline, ProfileCursor::new(profile)));
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
    use nalgebra::Vector3;

    #[test]
    fn every_pose_is_passed_within_the_limits_of_the_tool() {
        let robot = Irp6::nominal();
        let q = Irp6::READY;
        let start = robot.forward(&q);
        let by =
            |x: f64, y: f64, z: f64| start * Pose::new(Vector3::new(x, y, z), Vector3::new(y, z, x) * 5.0);
        let poses = vec![by(0.1, 0.0, 0.05), by(0.1, 0.1, 0.0), by(0.0, 0.1, -0.05), by(0.0, 0.0, -0.1)];
        let limits = JerkLimits { velocity: 0.3, acceleration: 1.0, jerk: 10.0 };
        let limits =
            SmoothToolLimits { translation: limits, rotation: JerkLimits { velocity: 1.0, ..limits } };
        let state = RobotState { joints: q, velocity: Six::zeros(), pose: start };
        let mut motion = PoseSplineMove::<Irp6>::through(poses.clone(), limits);
        let tick = Tick { step: 0, dt: 1e-3, duration: 1e-3 };
        let mut step = motion.first_step(&State::new(RobotImage::new(state, state)), tick).expect("a spline");
        let mut trace = vec![start, start];
        while let Step::Next(demand) = step {
            trace.push(demand.as_pose().expect("a pose"));
            step = motion.next_step(tick);
        }
        assert_eq!(trace.last(), poses.last());
        for x in trace.windows(3) {
            let v = [0, 1].map(|i| (x[i + 1].translation.vector - x[i].translation.vector) / 1e-3);
            let w = [0, 1].map(|i| (x[i + 1].rotation * x[i].rotation.inverse()).scaled_axis() / 1e-3);
            assert!(v[1].norm() < 0.3 + 1e-9 && (v[1] - v[0]).norm() / 1e-3 < 1.0 + 1e-6);
            assert!(w[1].norm() < 1.0 + 1e-9 && (w[1] - w[0]).norm() / 1e-3 < 1.0 + 1e-3);
        }
        for pose in &poses {
            let off = |x: &Pose| (x.translation.vector - pose.translation.vector).norm();
            let nearest = trace.iter().min_by(|a, b| off(a).total_cmp(&off(b))).expect("a trace");
            assert!(off(nearest) < 3e-4 && nearest.rotation.angle_to(&pose.rotation) < 2e-3);
        }
    }
}
