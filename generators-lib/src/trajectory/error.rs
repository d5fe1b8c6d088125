//! Why a trajectory is refused.

use core::fmt;

use thiserror::Error;

use crate::curve::CurveError;

/// What of a joint has a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// [rad or m].
    Position,
    /// [rad/s or m/s].
    Velocity,
    /// [rad/s² or m/s²].
    Acceleration,
    /// [rad/s³ or m/s³].
    Jerk,
    /// A change of the acceleration from one instant to the next [rad/s² or m/s²], in a joint whose jerk has a limit.
    StepOfAcceleration,
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Quantity::Position => "position",
            Quantity::Velocity => "velocity",
            Quantity::Acceleration => "acceleration",
            Quantity::Jerk => "jerk",
            Quantity::StepOfAcceleration => "step of the acceleration",
        })
    }
}

/// Why a trajectory is refused. Joints and points are counted from 1; the joints of several robots are one behind the other.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TrajectoryError {
    /// There are limits of 1 to [`MOST_JOINTS`](super::MOST_JOINTS) joints, all above 0.
    #[error(
        "limits of {joints} joints: there must be 1 to 32, each with a lower limit below its upper one, and all others above 0"
    )]
    Limits {
        /// Limits given.
        joints: usize,
    },
    /// It has no points.
    #[error("the trajectory has no points")]
    Empty,
    /// A point has more or fewer values than there are joints.
    #[error("point {point} has {actual} values for {expected} joints")]
    Values {
        /// Which point.
        point: usize,
        /// Joints.
        expected: usize,
        /// Values.
        actual: usize,
    },
    /// A value is infinite, or no number.
    #[error("point {point} has a value that is no finite number, for joint {joint}")]
    NotFinite {
        /// Which point.
        point: usize,
        /// Which joint.
        joint: usize,
    },
    /// Some points have velocities or accelerations and others have not, or there are accelerations without velocities.
    #[error(
        "point {point}: either all points have velocities, or none; and so accelerations, which need velocities"
    )]
    Mixed {
        /// Which point.
        point: usize,
    },
    /// Times must rise from point to point, from 0 or later.
    #[error("point {point} is at {time} s: times must rise from point to point, the first one from 0")]
    Time {
        /// Which point.
        point: usize,
        /// Its time \[s\].
        time: f64,
    },
    /// The robots would still move at the last point.
    #[error(
        "joint {joint} has a velocity of {velocity:.6} at the last point: the robots must be at rest there"
    )]
    MovingEnd {
        /// Which joint.
        joint: usize,
        /// [rad/s or m/s].
        velocity: f64,
    },
    /// All points are of the past.
    #[error("the last point is at {duration} s, of which {passed} s have passed")]
    Past {
        /// The time of the last point \[s\].
        duration: f64,
        /// What has passed of it \[s\].
        passed: f64,
    },
    /// The robots are not where the trajectory begins.
    #[error(
        "joint {joint} is at {position:.6}, the trajectory begins at {start:.6}: plan from where the robot is"
    )]
    Start {
        /// Which joint.
        joint: usize,
        /// Where it is [rad or m].
        position: f64,
        /// The first point [rad or m].
        start: f64,
    },
    /// Bare positions have no spline through them: times that are too close, or values that are too large.
    #[error("no spline goes through the positions: {0}")]
    Spline(#[from] CurveError),
    /// A joint would exceed a limit on the way to a point.
    #[error("joint {joint}: {quantity} {value:.4} on the way to point {point}, at most {limit:.4}")]
    Limit {
        /// What of it.
        quantity: Quantity,
        /// Which joint.
        joint: usize,
        /// The point at the end of the way.
        point: usize,
        /// What it would be.
        value: f64,
        /// What it may be: [`SHARE`](super::SHARE) of the joint's acceleration, [`JERK_SHARE`](super::JERK_SHARE) of its jerk.
        limit: f64,
    },
    /// States are of other joints than the trajectory.
    #[error("a trajectory of {expected} joints for {actual}")]
    Joints {
        /// Joints of the trajectory.
        expected: usize,
        /// Joints of the robots.
        actual: usize,
    },
    /// A group has no robot of that name, or it is named twice.
    #[error("`{0}` is no robot of the group, or is named twice")]
    Robot(String),
    /// A robot has not begun to follow trajectories, or has another number of joints than its generator.
    #[error("`{0}` does not follow trajectories now")]
    NotFollowing(String),
    /// A robot moves by a trajectory that it shares with others.
    #[error(
        "`{0}` moves by a trajectory of other robots, too: cancel that one, or replace it for all of them"
    )]
    Shared(String),
}
