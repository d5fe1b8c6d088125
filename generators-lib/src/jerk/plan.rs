//! One axis: the shortest duration, which longer ones are impossible, and a profile of any that is possible.
//!
//! The positions that an axis can reach in `T`, arriving with the target's velocity, are an interval, since states
//! and limits are convex; its ends are the extremal motions. So `T` is possible if the target lies between them:
//!
//! ```text
//! D_min(T) <= D <= D_max(T)
//! ```
//!
//! From the shortest duration on all are possible, but for a few open intervals: too long to go straight there and too
//! short to turn round. Where the shortest is not asked for, `D` divides the extremal motions of the duration in a
//! ratio, and the same ratio of the motions themselves is a motion within the limits.

use super::extremal::{Extremal, Place};
use super::{AxisLimits, AxisState, AxisTarget, JerkError, JerkProfile};

/// Most blocked intervals; two are known to occur.
const BLOCKED: usize = 4;

/// How an axis reaches its target.
#[derive(Clone, Copy, Debug)]
pub struct AxisPlan {
    start: AxisState,
    target: AxisTarget,

    /// The farthest motions forwards, and backwards on the mirrored axis.
    extremes: [Extremal; 2],
    /// Which extreme is the fastest motion, and where on it.
    fastest: (usize, Place),
    blocked: [(f64, f64); BLOCKED],
}

impl AxisPlan {
    /// From `start` to `target` within `limits`.
    ///
    /// # Errors
    /// A limit of the wrong sign, a number that is not finite, a start that has left the limits or must leave them, a
    /// target's velocity outside the limits.
    pub fn new(start: &AxisState, target: &AxisTarget, limits: &AxisLimits) -> Result<Self, JerkError> {
        limits.validate()?;
        limits.check(start, target)?;
        let limits = limits.around(start);
        let mirrored = AxisState {
            position: start.position,
            velocity: -start.velocity,
            acceleration: -start.acceleration,
        };
        let extremes = [
            Extremal::new(start, target.velocity, &limits),
            Extremal::new(&mirrored, -target.velocity, &limits.mirrored()),
        ];
        let way = target.position - start.position;
        let off = way - extremes[0].least_way();
        // On the fastest change of velocity: to the rounding of what it was computed from.
        let (beginning, a0) = (extremes[0].beginning(), start.acceleration);
        let speed = start.velocity.abs() + target.velocity.abs() + a0 * a0 / limits.jerk;
        let rounding = 1e-11 * (way.abs() + extremes[0].least_way().abs())
            + 64.0 * f64::EPSILON * speed * beginning.duration
            + 8.0 * f64::EPSILON * (start.position.abs() + target.position.abs());
        let mut plan = AxisPlan {
            start: *start,
            target: *target,
            extremes,
            fastest: (0, beginning),
            blocked: [(0.0, 0.0); BLOCKED],
        };
        let sides = [0, 1].map(|side| {
            let way = if side == 0 { way } else { -way };
            extremes[side].gaps(way, off.abs() <= rounding)
        });
        let gaps = || {
            sides
                .iter()
                .enumerate()
                .flat_map(|(side, gaps)| gaps.items.iter().flatten().map(move |gap| (side, gap)))
        };
        // Each gap is left once at most.
        for _ in 0..2 * BLOCKED {
            let least = plan.least();
            let Some((side, (_, end))) =
                gaps().find(|(_, (from, end))| from + 1e-12 * least < least && least < end.duration)
            else {
                break;
            };
            plan.fastest = (side, *end);
        }
        let least = plan.least();
        let later = gaps().filter(|(_, (_, end))| end.duration > least);
        for (slot, (_, (from, end))) in plan.blocked.iter_mut().zip(later) {
            *slot = (from.max(least), end.duration);
        }
        let profile = plan.unended();
        plan.check_end(&profile)?;
        Ok(plan)
    }

    /// Shortest duration \[s\].
    #[must_use]
    pub fn least(&self) -> f64 {
        self.fastest.1.duration
    }

    /// Open intervals of longer durations \[s\] that are impossible, in no order; they may overlap or be empty.
    #[must_use]
    pub fn blocked(&self) -> [(f64, f64); BLOCKED] {
        self.blocked
    }

    /// The shortest possible duration \[s\] that is not below `duration`.
    #[must_use]
    pub fn possible_from(&self, duration: f64) -> f64 {
        let mut duration = duration.max(self.least());
        for _ in 0..BLOCKED {
            for (from, until) in self.blocked {
                if duration > from && duration < until {
                    duration = until;
                }
            }
        }
        duration
    }

    /// The fastest motion.
    #[must_use]
    pub fn fastest(&self) -> JerkProfile {
        self.unended().ending_at(self.least(), &self.target)
    }

    /// A motion of exactly `duration` \[s\].
    ///
    /// # Errors
    /// A duration that is impossible.
    pub fn lasting(&self, duration: f64) -> Result<JerkProfile, JerkError> {
        let next = self.possible_from(duration);
        if next != duration {
            return Err(JerkError::Duration { asked: duration, least: self.least(), next });
        }
        if duration == self.least() {
            return Ok(self.fastest());
        }
        let rests =
            self.start.velocity == 0.0 && self.start.acceleration == 0.0 && self.target.velocity == 0.0;
        let profile = if rests {
            if self.least() == 0.0 {
                return Ok(JerkProfile::resting(self.start.position, duration));
            }
            self.unended().slowed(duration / self.least())
        } else {
            let [far, near] = [0, 1].map(|side| self.profile(side, &self.extremes[side].lasting(duration)));
            let (high, low) = (far.last().point.position, near.last().point.position);
            let share = (self.target.position - low) / (high - low);
            // Not a number where both extremes are one motion.
            let share = if share >= 0.0 { share.min(1.0) } else { 0.0 };
            far.mixed(&near, share)
        };
        self.check_end(&profile)?;
        Ok(profile.ending_at(duration, &self.target))
    }

    fn unended(&self) -> JerkProfile {
        self.profile(self.fastest.0, &self.fastest.1)
    }

    fn profile(&self, side: usize, place: &Place) -> JerkProfile {
        self.extremes[side].profile(place, if side == 0 { 1.0 } else { -1.0 })
    }

    /// Double precision must be enough: never hand out a motion that jumps at its end.
    fn check_end(&self, profile: &JerkProfile) -> Result<(), JerkError> {
        let end = profile.last();
        let size = profile.size() + self.start.position.abs() + self.target.position.abs();
        let miss = (end.point.position - self.target.position).abs();
        if size.is_finite() && end.time.is_finite() && miss <= 1e-9 * size {
            Ok(())
        } else {
            Err(JerkError::Precision(miss))
        }
    }
}
