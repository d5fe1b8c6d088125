//! How a robot comes back onto its path after demands were late.
//!
//! In: a demand that is off where bridging has brought the robot. Out: where it is at the end of the step, within the
//! limits, on the fastest return that the path's own acceleration leaves. A demand after n bridged steps is up to
//! (n + 1)(n + 2)/2 times the path's acceleration away: no limit takes that in one step, and none has to.

use crate::model::joints::JointVector;
use crate::model::robot::{Limits, POSITION_ROUND_OFF};

/// The least share of an acceleration limit that is planned with for coming back.
const LEAST_SHARE: f64 = 0.05;
/// How far a robot may be off its path, in parts of what the acceleration limit makes of the longest time between two
/// demands, `a t²`. A path that brakes with 0.9 of the limit takes it `0.9²/(2 (1 - 0.9)) + 0.9/2 = 4.5` off.
pub(super) const FARTHEST: f64 = 8.0;

/// What is known of a path while the robot is not on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct CatchingUp<J> {
    /// The path's velocity at the end of its last step.
    pub velocity: J,
    /// The path's acceleration meanwhile.
    pub acceleration: J,
    /// The longest time between two demands since the robot left the path \[s\].
    pub gap: f64,
}

/// A demand that is to be reached, and what the robot was told last.
pub(super) struct Late<'a, J> {
    pub position: &'a J,
    pub velocity: &'a J,
    /// Demanded now, and before the time without demands.
    pub demand: &'a J,
    pub before: &'a J,
    /// The path's mean velocity and acceleration until here.
    pub path_velocity: &'a J,
    pub path_acceleration: &'a J,
    /// The time between the two demands \[s\], of which the last `duration` is the step.
    pub time: f64,
    pub duration: f64,
}

impl<J: JointVector> CatchingUp<J> {
    /// Where the robot is at the end of the step, and what is known of the path if it is not on the path then.
    ///
    /// `None` if the robot would be too far off its path.
    pub fn next(known: Option<&Self>, late: &Late<'_, J>, limits: &Limits<J>) -> Option<(J, Option<Self>)> {
        let h = late.duration;
        let t = late.time;
        let gap = known.map_or(t, |known| known.gap.max(t));
        let path_velocity = Self::velocity_at_end(late.path_velocity, late.path_acceleration, t - h, limits);
        let mut position = *late.demand;
        let mut is_on_path = true;
        for i in 0..J::LEN {
            let limit = limits.acceleration[i];
            let fastest = limits.velocity[i];
            let round_off = POSITION_ROUND_OFF * late.demand[i].abs().max(1.0);
            // In time, the path's last step began at the demand before.
            let began = if t > h { late.demand[i] - path_velocity[i] * h } else { late.before[i] };
            let offset = late.position[i] - began;
            let usable = (limit - late.path_acceleration[i].abs()).max(LEAST_SHARE * limit);
            let wanted = path_velocity[i] + velocity_back(offset, usable, h);
            let slower = late.velocity[i] - limit * h;
            let faster = late.velocity[i] + limit * h;
            let velocity = wanted.clamp(slower, faster).clamp(-fastest, fastest);
            let off = late.position[i] + velocity * h - late.demand[i];
            if off.abs() > FARTHEST * limit * gap * gap {
                return None;
            }
            if off.abs() > round_off {
                position[i] = late.demand[i] + off;
            }
            // Where an offset ends in this step, its velocity ends in the next one.
            is_on_path &= off.abs() <= round_off && offset.abs() <= round_off;
        }
        let left = CatchingUp { velocity: path_velocity, acceleration: *late.path_acceleration, gap };
        Some((position, (!is_on_path).then_some(left)))
    }

    /// The path's velocity in its last step, where `mean` is that of a time which is longer than a step by so much \[s\].
    pub fn velocity_at_end(mean: &J, acceleration: &J, longer: f64, limits: &Limits<J>) -> J {
        J::from_joints(|i| {
            let fastest = limits.velocity[i];
            (mean[i] + acceleration[i] * 0.5 * longer).clamp(-fastest, fastest)
        })
    }
}

/// The velocity with which an offset becomes 0 in the fewest steps of `h` \[s\] with `a`: in each of them it falls by `a h`,
/// and what the last one leaves is at most that.
pub(super) fn velocity_back(offset: f64, a: f64, h: f64) -> f64 {
    // Steps with velocities of x, x - 1, .., x - m > 0 cover (m + 1) x - m (m + 1)/2.
    let covered = offset.abs() / (a * h * h);
    let m = (0.5 * ((1.0 + 8.0 * covered).sqrt() - 3.0)).ceil().max(0.0);
    let x = (covered + 0.5 * m * (m + 1.0)) / (m + 1.0);
    -(x * a * h).copysign(offset)
}
