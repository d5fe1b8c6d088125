//! Joint positions at times, as other programs plan them: what `trajectory_msgs/JointTrajectory` says.
//!
//! In: points of all joints with their times, the joints' limits, and where the robots are. Out: a [`TimedPath`] through the points,
//! checked as a whole; and robots that follow one, alone or several on one path time, each of which may be given another one
//! while it moves, or be brought to rest on its path ([`TrajectoryGroup`]).
//!
//! | a point has | between two points |
//! |---|---|
//! | positions, velocities and accelerations | polynomials of degree 5 |
//! | positions and velocities | polynomials of degree 3: the acceleration has steps at the points |
//! | positions | the cubic spline through all points, whose acceleration is continuous; at both ends it begins and ends without acceleration |
//!
//! The first two are what the joint trajectory controller of ROS 2 does. Between bare positions that one goes in straight lines, with
//! a step of velocity at each point, which no robot can do.

mod error;
mod group;
mod halt;
mod path;
mod piece;

use mrroc::observe::layout::JointLayout;
use mrroc::robot::{JointVector, Limits};

pub use error::{Quantity, TrajectoryError};
pub use group::{Outcome, TrajectoryGroup};
pub use path::{JointState, TimedPath};

/// The share of a limit of acceleration that a trajectory may use: what is left brings the robots to rest on their path. It is less than a
/// generator may [plan with](mrroc::cell::PATH_SHARE), which is what a trajectory uses that is halted.
pub const SHARE: f64 = 0.8;

/// The share of a limit of jerk that a trajectory may use: the less it is, the sooner its robots can be brought to rest.
pub const JERK_SHARE: f64 = 0.5;

/// How far a joint may be from a trajectory that has begun [rad or m], unless [`JointTrajectory::tolerance`] says otherwise.
pub const TOLERANCE: f64 = 0.01;

/// The most joints that one trajectory is for: those of four robots.
pub const MOST_JOINTS: usize = 32;

/// The limits of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointBounds {
    /// Lower position limit [rad or m].
    pub lower: f64,
    /// Upper position limit [rad or m].
    pub upper: f64,
    /// Largest speed [rad/s or m/s].
    pub velocity: f64,
    /// Largest acceleration [rad/s² or m/s²].
    pub acceleration: f64,
    /// Largest jerk [rad/s³ or m/s³]; infinite where it is not limited.
    pub jerk: f64,
}

impl JointBounds {
    /// Those of the joints of a robot.
    #[must_use]
    pub fn of<J: JointVector>(limits: &Limits<J>) -> Vec<JointBounds> {
        let of = |i: usize| JointBounds {
            lower: limits.lower[i],
            upper: limits.upper[i],
            velocity: limits.velocity[i],
            acceleration: limits.acceleration[i],
            jerk: limits.jerk.map_or(f64::INFINITY, |jerk| jerk[i]),
        };
        (0..J::LEN).map(of).collect()
    }

    /// Whether they are limits.
    fn are_sound(&self) -> bool {
        let largest = [self.velocity, self.acceleration, self.jerk];
        largest.iter().all(|&limit| limit > 0.0) && self.lower <= self.upper
    }
}

impl From<&JointLayout> for JointBounds {
    fn from(joint: &JointLayout) -> JointBounds {
        JointBounds {
            lower: joint.lower,
            upper: joint.upper,
            velocity: joint.velocity,
            acceleration: joint.acceleration,
            jerk: joint.jerk.unwrap_or(f64::INFINITY),
        }
    }
}

/// Where all joints are to be at a time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrajectoryPoint {
    /// Since the beginning of the trajectory \[s\].
    pub time: f64,
    /// [rad or m].
    pub positions: Vec<f64>,
    /// [rad/s or m/s]; empty where they are not told.
    pub velocities: Vec<f64>,
    /// [rad/s² or m/s²]; empty where they are not told.
    pub accelerations: Vec<f64>,
}

/// Points of all joints of one robot or of several, one behind the other.
///
/// ```
/// use mrroc_generators::trajectory::{JointBounds, JointState, JointTrajectory, TimedPath, TrajectoryPoint};
///
/// let slide = JointBounds { lower: -1.0, upper: 1.0, velocity: 0.5, acceleration: 2.0, jerk: f64::INFINITY };
/// let point = |time, position: f64| TrajectoryPoint {
///     time,
///     positions: vec![position],
///     velocities: vec![0.0],
///     accelerations: vec![],
/// };
/// let trajectory = JointTrajectory::new(vec![slide], vec![point(0.0, 0.1), point(2.0, 0.4)])?;
/// let path = TimedPath::from(&trajectory, &[JointState::resting(0.1)])?;
/// // A cubic from rest to rest: half the distance in half the time, at 3/2 of the mean speed.
/// let [position, velocity, _] = path.at(1.0, 0);
/// assert!((position - 0.25).abs() < 1e-12 && (velocity - 1.5 * 0.3 / 2.0).abs() < 1e-12);
///
/// // In half a second that takes an acceleration of 6 * 0.3 / 0.5^2, and more speed than the slide has.
/// let trajectory = JointTrajectory::new(vec![slide], vec![point(0.0, 0.1), point(0.5, 0.4)])?;
/// let refused = TimedPath::from(&trajectory, &[JointState::resting(0.1)]).expect_err("too fast");
/// assert!(refused.to_string().starts_with("joint 1: velocity"), "{refused}");
/// # Ok::<(), mrroc_generators::trajectory::TrajectoryError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct JointTrajectory {
    limits: Vec<JointBounds>,
    points: Vec<TrajectoryPoint>,
    /// How far a joint may be from the first point where that is at time 0 [rad or m].
    tolerance: f64,
    /// What part of its time has passed when it is begun \[s\].
    passed: f64,
}

impl JointTrajectory {
    /// Points of joints with these limits. The robots are at rest at the last one.
    ///
    /// # Errors
    /// What is wrong with the points by themselves: [`TrajectoryError::Empty`] and those up to [`TrajectoryError::MovingEnd`].
    pub fn new(limits: Vec<JointBounds>, points: Vec<TrajectoryPoint>) -> Result<Self, TrajectoryError> {
        let joints = limits.len();
        if joints == 0 || joints > MOST_JOINTS || !limits.iter().all(JointBounds::are_sound) {
            return Err(TrajectoryError::Limits { joints });
        }
        let last = points.last().ok_or(TrajectoryError::Empty)?;
        let told = |point: &TrajectoryPoint| {
            [point.velocities.len(), point.accelerations.len()].map(|told| told > 0)
        };
        let mut before = -1.0;
        for (place, point) in points.iter().enumerate() {
            let place = place + 1;
            for (values, may_miss) in
                [(&point.positions, false), (&point.velocities, true), (&point.accelerations, true)]
            {
                if values.len() != joints && !(may_miss && values.is_empty()) {
                    return Err(TrajectoryError::Values {
                        point: place,
                        expected: joints,
                        actual: values.len(),
                    });
                }
                if let Some(joint) = values.iter().position(|value| !value.is_finite()) {
                    return Err(TrajectoryError::NotFinite { point: place, joint: joint + 1 });
                }
            }
            if told(point) != told(last) || told(point) == [false, true] {
                return Err(TrajectoryError::Mixed { point: place });
            }
            if !(point.time.is_finite() && point.time >= 0.0 && point.time > before) {
                return Err(TrajectoryError::Time { point: place, time: point.time });
            }
            before = point.time;
        }
        if let Some(joint) = last.velocities.iter().position(|velocity| velocity.abs() > 1e-6) {
            return Err(TrajectoryError::MovingEnd { joint: joint + 1, velocity: last.velocities[joint] });
        }
        Ok(JointTrajectory { limits, points, tolerance: TOLERANCE, passed: 0.0 })
    }

    /// A joint may be so far from a trajectory that has begun [rad or m], [`TOLERANCE`] otherwise; it comes to it in half a second.
    #[must_use]
    pub fn starting_within(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// It is begun when so much of its time has passed \[s\]: where the first point is of the past, the robots must be about where it is at
    /// that time.
    #[must_use]
    pub fn passed(mut self, passed: f64) -> Self {
        self.passed = passed.max(0.0);
        self
    }

    /// How far a joint may be from the first point [rad or m].
    #[must_use]
    pub const fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// What part of its time has passed when it is begun \[s\].
    #[must_use]
    pub const fn has_passed(&self) -> f64 {
        self.passed
    }

    /// The limits of its joints.
    #[must_use]
    pub fn limits(&self) -> &[JointBounds] {
        &self.limits
    }

    /// Its points.
    #[must_use]
    pub fn points(&self) -> &[TrajectoryPoint] {
        &self.points
    }

    /// The time of the last point \[s\].
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.points.last().map_or(0.0, |last| last.time)
    }
}
