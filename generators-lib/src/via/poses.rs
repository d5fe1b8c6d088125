//! The tool through via poses.

use mrroc::pose::Pose;
use mrroc::robot::MAX_JOINTS;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use super::ViaError;
use super::legs::{Group, LegVector, plan};
use super::times::Times;
use crate::line::SmoothToolLimits;
use crate::waypoints;

/// How far from a via pose the tool may pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseDeviation {
    /// Distance of the tool's origin \[m\], finite, > 0.
    pub distance: f64,
    /// Angle of its orientation \[rad\], finite, > 0.
    pub angle: f64,
}

/// Straight lines of the tool through via poses, from rest to rest, over path time; immutable.
///
/// On each leg the origin moves straight and the orientation turns about a constant axis, through the smaller angle. Round a
/// via pose both change as the via point's own rotation vector does: the angular velocity is continuous.
#[derive(Clone, Debug, PartialEq)]
pub struct ViaPoses {
    poses: Vec<Pose>,
    /// Displacement of the origin in the common frame, and turn in the axes of the moving frame, of each leg.
    displacements: Vec<(Vector3<f64>, Vector3<f64>)>,
    times: Times,
}

impl ViaPoses {
    /// Through `poses` in one common frame \[m\], each passed within `deviation`, and within `limits`, of which jerk may be
    /// infinite. The limit of angular jerk is that of the rotation vector. Poses count by the rule of [`waypoints`].
    ///
    /// # Errors
    /// No two poses that differ; numbers out of range.
    pub fn new(poses: &[Pose], limits: SmoothToolLimits, deviation: PoseDeviation) -> Result<Self, ViaError> {
        let poses = waypoints::poses(poses)?;
        let leg = |leg: &[Pose]| {
            let displacement = leg[1].translation.vector - leg[0].translation.vector;
            (displacement, (leg[0].rotation.inverse() * leg[1].rotation).scaled_axis())
        };
        let displacements: Vec<_> = poses.windows(2).map(leg).collect();
        let group = |first: usize, limits, deviation, turns| Group {
            axes: first..first + 3,
            limits,
            deviation,
            turns,
        };
        let groups = [
            group(0, limits.translation, deviation.distance, false),
            group(3, limits.rotation, deviation.angle, true),
        ];
        let coordinates: Vec<LegVector> = displacements
            .iter()
            .map(|(displacement, turn)| {
                let mut all = [0.0; MAX_JOINTS];
                all[..3].copy_from_slice(displacement.as_slice());
                all[3..6].copy_from_slice(turn.as_slice());
                all
            })
            .collect();
        let times = plan(&coordinates, &groups)?;
        Ok(ViaPoses { poses, displacements, times })
    }

    /// Duration \[s\].
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.times.duration()
    }

    /// The pose at path time `t` \[s\]: before 0 the first one, from the duration on exactly the last.
    #[must_use]
    pub fn at(&self, t: f64) -> Pose {
        let last = self.poses.len() - 1;
        if t >= self.duration() {
            return self.poses[last];
        }
        let at = self.times.at(t);
        let leg = |(k, share): (usize, f64)| {
            let (displacement, turn) = self.displacements[k.min(last - 1)];
            (displacement * share, turn * share)
        };
        let (k, share) = at.place;
        let from = self.poses[k];
        // On a leg the turns are about one axis: they add up.
        let on_leg = leg((k, share));
        let before = leg(at.before);
        let after = leg(at.after);
        let displacement = on_leg.0 + before.0 + after.0;
        let turn =
            UnitQuaternion::from_scaled_axis(on_leg.1) * UnitQuaternion::from_scaled_axis(before.1 + after.1);
        Pose::from_parts(Translation3::from(from.translation.vector + displacement), from.rotation * turn)
    }
}
