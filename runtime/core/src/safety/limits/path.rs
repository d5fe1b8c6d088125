//! The path that a robot's demands describe, and what is known of it while the robot is not on it.
//!
//! In: demands, those that are missing, those that come too late. Out: where the path is, and where it ends if it goes no
//! farther.

use crate::model::joints::JointVector;
use crate::model::robot::{Limits, Robot};
use crate::safety::common_twist::{Bridging, Twist};

use super::catching_up::CatchingUp;
use super::rejoining::Rejoining;
use super::state::JointState;

/// The path as its demands tell it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path<J> {
    /// Demanded last.
    pub position: J,
    /// The mean velocity up to there.
    pub velocity: J,
    /// The time of which that is the mean \[s\].
    pub span: f64,
    /// For how long demands have been missing since \[s\]; below 0 where that demand was of a step that is still to come.
    pub missing: f64,
    /// Whether that time was bridged on a twist.
    pub on_twist: bool,
    /// Where the path went in that time, as a demand says that came too late to be followed.
    pub late: Option<J>,
}

impl<J> Path<J> {
    pub const fn after(position: J, velocity: J, span: f64) -> Self {
        Path { position, velocity, span, missing: 0.0, on_twist: false, late: None }
    }
}

/// What is known of the path while a robot is not on it, because demands came too late.
#[derive(Clone, Copy, Debug)]
pub(super) enum OffPath<J> {
    /// It comes back by its joints.
    Joints(CatchingUp<J>),
    /// It comes back with all robots that it moves together with.
    Together(Rejoining),
}

/// A robot's path, and its return to it if it is elsewhere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Track<J> {
    pub path: Path<J>,
    pub off_path: Option<OffPath<J>>,
}

impl<J: JointVector> Track<J> {
    /// A path that has come to `position` with the mean velocity of a step of `span` \[s\]; the robot is there.
    pub const fn at(position: J, velocity: J, span: f64) -> Self {
        Track { path: Path::after(position, velocity, span), off_path: None }
    }

    /// Whether the robot is where its path is.
    pub const fn is_followed(&self) -> bool {
        self.off_path.is_none()
    }

    /// Whether the robot is where its path is, and no demand is missing.
    pub fn is_in_step(&self) -> bool {
        self.is_followed() && self.path.missing == 0.0 && !self.path.on_twist
    }

    /// The path goes on to `demand` with this mean velocity in `span` \[s\], and the robot that is in step with it follows it
    /// there.
    #[inline]
    pub fn follow(&mut self, demand: &J, velocity: &J, span: f64) {
        self.path.position = *demand;
        self.path.velocity = *velocity;
        self.path.span = span;
        self.path.late = None;
    }

    /// Where the path is, and its velocity, for a robot in this state.
    pub fn demanded(&self, state: &JointState<J>) -> (J, J) {
        let velocity = match &self.off_path {
            Some(OffPath::Joints(path)) => {
                // Who made a late demand goes on from it, in whichever step it came.
                if let Some(late) = self.path.late {
                    return (late, path.velocity);
                }
                path.velocity
            }
            Some(OffPath::Together(_)) => self.path.velocity,
            None => return (state.position, state.velocity),
        };
        (self.path.position + velocity * self.path.missing, velocity)
    }

    /// Where a path ends that goes no farther, for a robot that is elsewhere: at its last demand, late or not. Robots with
    /// a jerk limit do not come back to a path of which demands are missing.
    pub fn end(&self, limits: &Limits<J>) -> Option<J> {
        let comes_back = !self.is_followed() || self.path.missing > 0.0 && limits.jerk.is_none();
        comes_back.then(|| self.path.late.unwrap_or(self.path.position))
    }

    /// The demand of a step of `duration` \[s\] is missing; that was bridged on a twist.
    pub fn bridge_on_twist(&mut self, duration: f64) {
        self.path.missing += duration;
        self.path.on_twist = true;
    }

    /// The path once it has come to `demand`, at the end of a step of `duration` \[s\].
    pub fn path_to(&self, demand: &J, duration: f64) -> Path<J> {
        let (velocity, span) = self.mean_to(demand, duration);
        Path::after(*demand, velocity, span)
    }

    /// The mean velocity with which the path comes to `demand` at the end of a step of `duration` \[s\], and the time of which
    /// that is the mean \[s\].
    #[inline]
    pub fn mean_to(&self, demand: &J, duration: f64) -> (J, f64) {
        // A path that ends before the step of its last demand ends there.
        let span = self.path.missing.max(0.0) + duration;
        ((*demand - self.path.position) * span.recip(), span)
    }

    /// How robots that move together go on from here, one of which is in this state.
    pub fn bridging<R: Robot<Joints = J>>(
        &self,
        state: &JointState<J>,
        robot: &R,
        duration: f64,
    ) -> Bridging {
        let twist = self.twist(robot, duration);
        // One that comes back by its own joints has a change of its own.
        let bend = match &self.off_path {
            Some(OffPath::Joints(_)) => Twist::NONE,
            Some(OffPath::Together(_)) | None => state.bend(robot, duration),
        };
        Bridging::after(twist, bend)
    }

    /// The displacement of the last step in the world: the path's, and that of the return to it.
    fn twist<R: Robot<Joints = J>>(&self, robot: &R, duration: f64) -> Twist {
        match &self.off_path {
            Some(OffPath::Together(rejoining)) => self.path_twist(robot, duration) + rejoining.change(),
            Some(OffPath::Joints(_)) | None => self.path_twist(robot, duration),
        }
    }

    /// The displacement of the path's last step in the world, as its mean velocity makes it.
    pub fn path_twist<R: Robot<Joints = J>>(&self, robot: &R, duration: f64) -> Twist {
        let before = self.path.position - self.path.velocity * duration;
        let of_joints = || Twist::between(&robot.forward(&before), &robot.forward(&self.path.position));
        match &self.off_path {
            Some(OffPath::Together(rejoining)) => rejoining.path_twist().unwrap_or_else(of_joints),
            Some(OffPath::Joints(_)) | None => of_joints(),
        }
    }
}
