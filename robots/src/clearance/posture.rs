//! A robot of any kind as the clearance sees it, without its type.
//!
//! In: an [`Outline`]. Out: a [`Shape`], whose joints are the first of eight numbers.

use mrroc::prelude::*;
use mrroc::robot::{JointKind, JointVector, Limits, MAX_JOINTS};
use nalgebra::SVector;

use super::stopping::{Pace, Stopping};
use crate::models::{Capsule, Chain, Link, Motion, Outline};

/// Joint positions or velocities of a robot of any kind, as the runtime passes them.
pub type Joints = [f64; MAX_JOINTS];

/// Where the joints of a robot are on a stretch of a path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stretch {
    /// Positions in the middle of the stretch [rad or m], which the robot passes.
    pub middle: Joints,
    /// By how much each joint is off them at most, either way [rad or m], >= 0.
    pub half: Joints,
}

/// An [`Outline`] without its type: joints are the first of eight numbers.
pub trait Shape: Send + Sync {
    /// As [`Outline::links`].
    fn links(&self) -> Vec<Link>;
    /// As [`Outline::capsules`].
    fn capsules(&self, q: &Joints, visit: &mut dyn FnMut(Capsule));
    /// As [`Outline::rigid`].
    fn rigid(&self) -> Option<Vec<(usize, Capsule)>>;
    /// As [`Outline::link_frames`].
    fn link_frames(&self, q: &Joints, visit: &mut dyn FnMut(&Pose));
    /// As [`Outline::motions`].
    fn motions(&self, q: &Joints, distances: &Joints, visit: &mut dyn FnMut(Motion));
    /// As [`Outline::flange_motions`].
    fn flange_motions(&self) -> u32;
    /// As [`Outline::chain`].
    fn chain(&self) -> Option<Chain>;
    /// Pose of the flange in the world at `q` [rad or m].
    fn flange(&self, q: &Joints) -> Pose;
    /// The robot's limits; those beyond its joints are 0.
    fn limits(&self) -> Limits<SVector<f64, MAX_JOINTS>>;
    /// What kind each joint is, in their order.
    fn kinds(&self) -> Vec<JointKind>;
    /// Whether joints share limits, so that not every position within the limits is possible.
    fn is_coupled(&self) -> bool;
    /// Whether the position keeps the limits that joints share.
    fn is_possible(&self, q: &Joints) -> bool;
    /// The position that lies `part` (0 to 1 each) of the way between the limits; endless joints within a turn.
    fn between_limits(&self, part: &dyn Fn(usize) -> f64) -> Joints;
    /// The largest `v/a` of its joints, of which the slowest decides how long a stop of the cell takes.
    fn pace(&self, stopping: &Stopping, velocity: &Joints) -> Pace;
    /// How far each joint still moves in such a stop [rad or m].
    fn stopping_distances(&self, stopping: &Stopping, velocity: &Joints, cell: &Pace) -> Joints;
    /// How much of these distances each joint may go against its velocity [rad or m].
    fn backwards(&self, stopping: &Stopping, velocity: &Joints, distances: &Joints, cell: &Pace) -> Joints;
}

impl<O: Outline> Shape for O {
    fn links(&self) -> Vec<Link> {
        Outline::links(self)
    }

    fn capsules(&self, q: &Joints, visit: &mut dyn FnMut(Capsule)) {
        Outline::capsules(self, &JointVector::from_joints(|i| q[i]), visit);
    }

    fn rigid(&self) -> Option<Vec<(usize, Capsule)>> {
        Outline::rigid(self)
    }

    fn link_frames(&self, q: &Joints, visit: &mut dyn FnMut(&Pose)) {
        Outline::link_frames(self, &JointVector::from_joints(|i| q[i]), visit);
    }

    fn motions(&self, q: &Joints, distances: &Joints, visit: &mut dyn FnMut(Motion)) {
        let joints = |values: &Joints| JointVector::from_joints(|i| values[i]);
        Outline::motions(self, &joints(q), &joints(distances), visit);
    }

    fn chain(&self) -> Option<Chain> {
        Outline::chain(self)
    }

    fn limits(&self) -> Limits<SVector<f64, MAX_JOINTS>> {
        let limits = self.robot().limits();
        let padded = |joints: &<O::Robot as Robot>::Joints| SVector::from(padded(joints));
        Limits {
            lower: padded(&limits.lower),
            upper: padded(&limits.upper),
            velocity: padded(&limits.velocity),
            acceleration: padded(&limits.acceleration),
            jerk: limits.jerk.as_ref().map(padded),
        }
    }

    fn kinds(&self) -> Vec<JointKind> {
        (0..<O::Robot as Robot>::Joints::LEN).map(|i| self.robot().joint(i)).collect()
    }

    fn is_coupled(&self) -> bool {
        !self.robot().coupled_limits().is_empty()
    }

    fn flange(&self, q: &Joints) -> Pose {
        self.robot().forward(&JointVector::from_joints(|i| q[i]))
    }

    fn flange_motions(&self) -> u32 {
        Outline::flange_motions(self)
    }

    fn pace(&self, stopping: &Stopping, velocity: &Joints) -> Pace {
        stopping.pace(self.robot().limits(), velocity)
    }

    fn stopping_distances(&self, stopping: &Stopping, velocity: &Joints, cell: &Pace) -> Joints {
        let stopping_distances: <O::Robot as Robot>::Joints =
            stopping.stopping_distances(self.robot().limits(), velocity, cell);
        padded(&stopping_distances)
    }

    fn backwards(&self, stopping: &Stopping, velocity: &Joints, distances: &Joints, cell: &Pace) -> Joints {
        let distances: <O::Robot as Robot>::Joints = JointVector::from_joints(|i| distances[i]);
        padded(&stopping.backwards(self.robot().limits(), velocity, &distances, cell))
    }

    fn between_limits(&self, part: &dyn Fn(usize) -> f64) -> Joints {
        const TURN: f64 = core::f64::consts::PI;
        let limits = self.robot().limits();
        let q: <O::Robot as Robot>::Joints = JointVector::from_joints(|i| {
            let mut lower = limits.lower[i];
            let mut upper = limits.upper[i];
            if self.robot().joint(i) == JointKind::Revolute && lower < -TURN && upper > TURN {
                lower = -TURN;
                upper = TURN;
            }
            lower + (upper - lower) * part(i)
        });
        padded(&q)
    }

    fn is_possible(&self, q: &Joints) -> bool {
        let q = JointVector::from_joints(|i| q[i]);
        self.robot().check_coupled(&q, &q, 1.0).is_ok()
    }
}

fn padded<J: JointVector>(joints: &J) -> Joints {
    let mut all = [0.0; MAX_JOINTS];
    for (place, value) in all.iter_mut().zip(joints.as_slice()) {
        *place = *value;
    }
    all
}
