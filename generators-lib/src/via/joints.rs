//! Joints through via points.

use mrroc::robot::JointVector;

use super::ViaError;
use super::legs::{Group, plan};
use super::times::Times;
use crate::jerk::JointLimits;
use crate::profile::JerkLimits;
use crate::waypoints;

/// Straight legs in joint space through via points, from rest to rest, over path time; immutable.
#[derive(Clone, Debug, PartialEq)]
pub struct ViaJoints<J> {
    points: Vec<J>,
    times: Times,
}

impl<J: JointVector> ViaJoints<J> {
    /// Through `points` [rad or m], which every joint passes within its `deviation` [rad or m], > 0, and within `limits`, of
    /// which jerk may be infinite. Points count by the rule of [`waypoints`].
    ///
    /// # Errors
    /// No two points that differ; numbers out of range.
    pub fn new(points: &[J], limits: &JointLimits<J>, deviation: &J) -> Result<Self, ViaError> {
        let points = waypoints::joints(points)?;
        let displacements: Vec<_> = points
            .windows(2)
            .map(|p| core::array::from_fn(|i| if i < J::LEN { p[1][i] - p[0][i] } else { 0.0 }))
            .collect();
        let group = |i: usize| Group {
            axes: i..i + 1,
            limits: JerkLimits {
                velocity: limits.velocity[i],
                acceleration: limits.acceleration[i],
                jerk: limits.jerk[i],
            },
            deviation: deviation[i],
            turns: false,
        };
        let times = plan(&displacements, &(0..J::LEN).map(group).collect::<Vec<_>>())?;
        Ok(ViaJoints { points, times })
    }

    /// Duration \[s\].
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.times.duration()
    }

    /// The joints at path time `t` \[s\]: before 0 at the first point, from the duration on exactly at the last.
    #[must_use]
    pub fn at(&self, t: f64) -> J {
        let last = self.points.len() - 1;
        if t >= self.duration() {
            return self.points[last];
        }
        let at = self.times.at(t);
        let leg = |k: usize| self.points[k.min(last - 1) + 1] - self.points[k.min(last - 1)];
        let (k, share) = at.place;
        let place = if share > 0.0 { self.points[k] + leg(k) * share } else { self.points[k] };
        place + leg(at.before.0) * at.before.1 + leg(at.after.0) * at.after.1
    }
}
