//! A robot that a person jogs: paths that are checked before the robot goes along them, and a motion along them that can stop at any time.
//!
//! In: what a person asks for, the robot's model. Out: joint positions, step by step. A [`JogPath`] says where the joints are after some
//! of it; [`Ahead`] finds out how much of it can be gone, and how fast; [`Run`] goes along it, within limits of velocity,
//! acceleration and jerk, so that it can always come to rest on what has been looked at.
//!
//! What bounds a path is told and is no fault: a joint near its limit, the end of the arm's reach, a singularity. So a person who
//! jogs against any of them sees the robot slow down and stand there, and can jog it back.

mod ahead;
mod path;
mod run;

pub use ahead::Ahead;
pub use path::JogPath;
pub use run::Run;

use mrroc::operator::REDUCED_SPEED;

/// How fast a robot is jogged at most, by an order of 100 %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JogLimits {
    /// Velocity of the tool [m/s], > 0. More than [`REDUCED_SPEED`] is refused by the cell.
    pub speed: f64,
    /// Angular velocity of the tool [rad/s], > 0.
    pub turn: f64,
    /// Acceleration of the tool [m/s²], > 0.
    pub acceleration: f64,
    /// Angular acceleration of the tool [rad/s²], > 0.
    pub turning_acceleration: f64,
    /// Share of each joint's limits of velocity, acceleration and jerk, > 0 and < 1: the rest is for the operator's rate.
    pub joints: f64,
    /// How near to its limits a joint is jogged [rad or m], >= 0.
    pub margin: f64,
}

impl Default for JogLimits {
    /// 0.238 m/s, 0.5 rad/s, 0.5 m/s², 1 rad/s², a quarter of what the joints can, up to 0.01 rad or m from their limits.
    fn default() -> Self {
        JogLimits {
            speed: 0.95 * REDUCED_SPEED,
            turn: 0.5,
            acceleration: 0.5,
            turning_acceleration: 1.0,
            joints: 0.25,
            margin: 0.01,
        }
    }
}

impl JogLimits {
    /// Whether all of them can be kept.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let JogLimits { speed, turn, acceleration, turning_acceleration, joints, margin } = *self;
        let positive = [speed, turn, acceleration, turning_acceleration, joints];
        positive.iter().all(|x| x.is_finite() && *x > 0.0)
            && joints < 1.0
            && margin.is_finite()
            && margin >= 0.0
    }
}
