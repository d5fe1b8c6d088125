//! Moves the joints along a cubic spline through positions with limited jerk, from rest to rest.

use mrroc::prelude::*;
use mrroc::robot::JointVector;

use mrroc_generators::curve::{CubicSpline, CurveError};
use mrroc_generators::profile::{JerkLimits, ProfileCursor, SevenPhase};
use mrroc_generators::waypoints::PointsError;

/// Moves the joints from where they are through all points without a stop, on the natural cubic spline.
///
/// The speed along the spline keeps every joint within its velocity and acceleration: with `|q'|`, `|q''|` the largest on
/// the spline, `u' <= V / |q'|` and `u'^2 |q''| + u'' |q'| <= A`, half of it for either.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::JointSpline;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::{Irp6, Six};
///
/// let points = vec![Irp6::READY + Six::repeat(0.1), Irp6::READY + Six::new(0.2, 0.1, 0.1, 0.0, -0.1, 0.3)];
/// let motion = JointSpline::through(points.clone(), Six::repeat(0.4), Six::repeat(0.8), 0.1);
/// let demands = rehearse(motion, &Irp6::nominal(), Irp6::READY, 0.002)?;
/// // It passes the first point within half a step at 0.4 rad/s, and ends at the last one.
/// let past = |point: Six| demands.iter().filter_map(Demand::as_joints).any(|q| (q - point).amax() <= 4e-4);
/// assert!(past(points[0]));
/// assert_eq!(demands.last().and_then(Demand::as_joints), Some(points[1]));
/// # Ok::<(), Fault>(())
/// ```
pub struct JointSpline<R: Robot> {
    points: Vec<R::Joints>,
    velocity: R::Joints,
    acceleration: R::Joints,
    ramp: f64,
    path: Option<(CubicSpline<R::Joints>, ProfileCursor<SevenPhase>)>,
    /// Where it leads, the end last: told one in each step.
    goals: Vec<R::Joints>,
}

impl<R: Robot> JointSpline<R> {
    /// Through `points` [rad or m] within a velocity and an acceleration per joint, all > 0; the acceleration along the
    /// spline builds up in `ramp` \[s\], > 0. Leave a tenth of the robot's limits to the operator's feed rate.
    #[must_use]
    pub fn through(points: Vec<R::Joints>, velocity: R::Joints, acceleration: R::Joints, ramp: f64) -> Self {
        JointSpline { points, velocity, acceleration, ramp, path: None, goals: Vec::new() }
    }

    fn advance(&mut self, t: Tick) -> Step<R> {
        let Some((spline, cursor)) = &mut self.path else { return Step::Done };
        let Some(point) = cursor.advance(t.dt) else { return Step::Done };
        let step = Step::Next(Demand::joints(spline.at(point.s).value));
        match self.goals.pop() {
            Some(goal) => step.with_goal(Demand::joints(goal)),
            None => step,
        }
    }
}

#[generator(ecp)]
impl<R: Robot> JointSpline<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        self.goals.clone_from(&self.points);
        self.points.insert(0, e.demanded().joints);
        let spline = match CubicSpline::by_chords(&self.points) {
            // It is there.
            Err(CurveError::Points(PointsError::Coincident)) => return Ok(Step::Done),
            spline => spline.map_err(|error| Fault::thrown(&error.to_string()))?,
        };
        let length = spline.range().1;
        let (first, second) = spline.peaks();
        let mut velocity = f64::MAX;
        let mut acceleration = f64::MAX;
        for i in 0..R::Joints::LEN {
            let v = self.velocity[i];
            let a = 0.5 * self.acceleration[i];
            velocity = velocity.min(v / first[i]).min((a / second[i]).sqrt());
            acceleration = acceleration.min(a / first[i]);
        }
        let limits = JerkLimits { velocity, acceleration, jerk: acceleration / self.ramp };
        let profile = SevenPhase::new(length, limits).map_err(|error| Fault::thrown(&error.to_string()))?;
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

    #[test]
    fn every_point_is_passed_within_the_limits_of_every_joint() {
        let robot = Irp6::nominal();
        let start = Irp6::READY;
        let at = |x: f64, y: f64| start + Six::new(x, y, -0.5 * x, 0.0, y * x, 0.3 * x);
        let points = vec![at(0.2, 0.1), at(0.4, -0.1), at(0.3, 0.2), at(0.0, 0.1)];
        let velocity = Six::repeat(0.5);
        let acceleration = Six::new(1.0, 2.0, 3.0, 1.0, 2.0, 3.0);
        let state = RobotState { joints: start, velocity: Six::zeros(), pose: robot.forward(&start) };
        let mut motion = JointSpline::<Irp6>::through(points.clone(), velocity, acceleration, 0.05);
        let tick = Tick { step: 0, dt: 1e-3, duration: 1e-3 };
        let mut step = motion.first_step(&State::new(RobotImage::new(state, state)), tick).expect("a spline");
        let mut trace = vec![start, start];
        while step != Step::Done {
            let (spline, cursor) = motion.path.as_ref().expect("made in the first step");
            let u = mrroc_generators::profile::Profile::at(cursor.profile(), cursor.time()).s;
            trace.push(spline.at(u).value);
            let at = spline.at(u).value;
            assert!(matches!(step, Step::Next(demand) if demand.as_joints() == Some(at)), "{step:?} {at}");
            step = motion.next_step(tick);
        }
        for q in trace.windows(3) {
            let v0 = (q[1] - q[0]) / 1e-3;
            let v1 = (q[2] - q[1]) / 1e-3;
            let a = (v1 - v0) / 1e-3;
            assert!(
                (0..6).all(|i| v1[i].abs() <= 0.5 + 1e-9 && a[i].abs() <= acceleration[i] + 1e-6),
                "{v1} {a}"
            );
        }
        for point in &points {
            let nearest = trace.iter().map(|q| (q - point).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-3, "{nearest}");
        }
        assert_eq!(trace.last(), points.last());
    }
}
