//! Moves all joints past via points within a deviation and without a stop, with limited jerk or parabolic blends.

use mrroc::prelude::*;

use mrroc_generators::jerk::JointLimits;
use mrroc_generators::via::{ViaError, ViaJoints};
use mrroc_generators::waypoints::PointsError;

/// Moves the joints from where they are along straight legs past all points, to rest at the last one.
///
/// Each joint passes a point at a distance of at most the deviation; the smaller the deviation, the slower the corner.
///
/// [`through`](JointVia::through) plans in the first step of the motion, and must finish before the next step: it plans
/// about ten points in a millisecond. For more points in real time, plan before the Move, while the robots hold, and
/// use [`along`](JointVia::along).
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::JointVia;
/// use mrroc_generators::jerk::JointLimits;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::{Irp6, Six};
///
/// let limits = JointLimits { velocity: Six::repeat(0.4), acceleration: Six::repeat(0.8), jerk: Six::repeat(8.0) };
/// // There, and on at a right angle: past the via point within 0.01 rad.
/// let via = Irp6::READY + Six::x() * 0.2;
/// let goal = via + Six::y() * 0.2;
/// let motion = JointVia::through(vec![via, goal], Six::repeat(0.01), limits);
/// let demands = rehearse(motion, &Irp6::nominal(), Irp6::READY, 0.002)?;
/// let off = demands.iter().filter_map(Demand::as_joints).map(|q| (q - via).amax()).fold(1.0, f64::min);
/// // Of the positions demanded, the nearest may be half a step at 0.4 rad/s before or behind the nearest of the path.
/// assert!(off > 1e-4 && off <= 0.01 + 4e-4, "{off}");
/// let end = demands.last().and_then(Demand::as_joints);
/// assert!(end.is_some_and(|end| (end - goal).amax() < 1e-12));
/// # Ok::<(), Fault>(())
/// ```
pub struct JointVia<R: Robot> {
    plan: Plan<R::Joints>,
    time: f64,
    /// Where it leads, the end last: told one in each step.
    goals: Vec<R::Joints>,
}

enum Plan<J> {
    /// To be planned in the first step.
    Asked {
        points: Vec<J>,
        limits: JointLimits<J>,
        deviation: J,
    },
    Ready(ViaJoints<J>),
}

impl<R: Robot> JointVia<R> {
    /// Through `points` within a `deviation` [rad or m] per joint, > 0, and within `limits`; an infinite jerk makes parabolic
    /// blends. Leave a tenth of the robot's limits to the operator's feed rate.
    #[must_use]
    pub fn through(points: Vec<R::Joints>, deviation: R::Joints, limits: JointLimits<R::Joints>) -> Self {
        JointVia { plan: Plan::Asked { points, limits, deviation }, time: 0.0, goals: Vec::new() }
    }

    /// Along a motion that is planned already, whose first point is where the robot is demanded to be.
    #[must_use]
    pub fn along(motion: ViaJoints<R::Joints>) -> Self {
        JointVia { plan: Plan::Ready(motion), time: 0.0, goals: Vec::new() }
    }

    fn advance(&mut self, t: Tick) -> Step<R> {
        let Plan::Ready(motion) = &self.plan else { return Step::Done };
        if self.time >= motion.duration() {
            return Step::Done;
        }
        self.time += t.dt;
        // The sum of n increments may miss n * dt by rounding; that must not cost a step.
        if motion.duration() - self.time <= 1e-9 * t.dt {
            self.time = motion.duration();
        }
        let demand = Demand::joints(motion.at(self.time));
        Step::Next(match self.goals.pop() {
            Some(goal) => demand.with_goal(Demand::joints(goal)),
            None => demand,
        })
    }
}

#[generator(ecp)]
impl<R: Robot> JointVia<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        if let Plan::Asked { points, limits, deviation } = &mut self.plan {
            self.goals.clone_from(points);
            points.insert(0, e.demanded().joints);
            let motion = match ViaJoints::new(points, limits, deviation) {
                // It is there.
                Err(ViaError::Points(PointsError::Coincident)) => return Ok(Step::Done),
                motion => motion.map_err(|error| Fault::thrown(&error.to_string()))?,
            };
            self.plan = Plan::Ready(motion);
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
    fn via_points_are_passed_within_the_deviation_and_all_limits_kept() {
        let robot = Irp6::nominal();
        let start = Irp6::READY;
        let at = |x: f64, y: f64| start + Six::new(x, y, -0.5 * x, 0.0, y * x, 0.3 * x);
        let points = vec![at(0.2, 0.1), at(0.4, -0.1), at(0.3, 0.2), at(0.0, 0.1)];
        let limits = JointLimits {
            velocity: Six::repeat(0.5),
            acceleration: Six::repeat(2.0),
            jerk: Six::repeat(20.0),
        };
        let state = RobotState { joints: start, velocity: Six::zeros(), pose: robot.forward(&start) };
        let mut motion = JointVia::<Irp6>::through(points.clone(), Six::repeat(0.01), limits);
        let tick = Tick { step: 0, dt: 1e-3, duration: 1e-3 };
        let mut step = motion.first_step(&State::new(RobotImage::new(state, state)), tick).expect("a motion");
        let mut trace = vec![start; 3];
        while let Step::Next(demand) = step {
            trace.push(demand.as_joints().expect("joints"));
            step = motion.next_step(tick);
        }
        assert_eq!(trace.last(), points.last());
        for q in trace.windows(4) {
            let v = (q[3] - q[2]) / 1e-3;
            let a = (q[3] - q[2] * 2.0 + q[1]) / 1e-6;
            let j = (q[3] - q[2] * 3.0 + q[1] * 3.0 - q[0]) / 1e-9;
            assert!(v.amax() < 0.5 + 1e-9 && a.amax() < 2.0 + 1e-6 && j.amax() < 20.0 + 1e-3, "{v} {a} {j}");
        }
        let mut planned = JointVia::<Irp6>::along(
            ViaJoints::new(&[&[start][..], &points].concat(), &limits, &Six::repeat(0.01)).expect("a motion"),
        );
        let step = planned.first_step(&State::new(RobotImage::new(state, state)), tick).expect("a motion");
        let Step::Next(demand) = step else { panic!("it moves") };
        assert_eq!(demand.as_joints(), Some(trace[3]), "the same motion, planned before");
        for point in &points {
            let nearest = trace.iter().map(|q| (q - point).amax()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.01 + 1e-3, "{nearest}");
        }
    }
}
