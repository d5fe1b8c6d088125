//! One axis: the shortest duration, which longer ones are impossible, and a profile of any that is possible.
//!
//! The positions that an axis can reach in `T`, arriving with the target's velocity, are an interval, since states
//! and limits are convex; its ends are the extremal motions. So `T` is possible if the target lies between them:
//!
//! ```text
//! D_min(T) <= D <= D_max(T)
//! ```
//!
//! All durations from the shortest on are possible, except in a few open intervals: they are too long to go straight to the
//! target and too short to turn round before it. For a duration longer than the shortest, `D` lies between the ends of
//! the two extremal motions in some ratio; the mixture of both motions in that ratio ends at `D` and is within the limits.

use super::extremal::Extremal;
use super::profile::{End, Phase, Phases, mixed};
use super::recovery::{Recovery, recovery};
use super::rest::rest_to_rest;
use super::{AxisLimits, AxisState, AxisTarget, JerkError, JerkProfile};

/// Most blocked intervals; three are known to occur.
const BLOCKED: usize = 6;

/// How an axis reaches its target.
#[derive(Clone, Copy, Debug)]
pub struct AxisPlan {
    origin: AxisState,
    recovery: Recovery,
    /// How long the recovery takes \[s\].
    delay: f64,
    /// The state that the recovery leads to.
    start: AxisState,
    target: AxisTarget,
    limits: AxisLimits,
    fastest: Phases,
    least: f64,
    blocked: [(f64, f64); BLOCKED],
    blocked_count: usize,
}

/// The farthest motion forwards, or backwards as that of the mirrored axis.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    Forwards,
    Backwards,
}

impl Side {
    fn sign(self) -> f64 {
        if self == Side::Forwards { 1.0 } else { -1.0 }
    }

    #[inline]
    fn extreme(self, start: &AxisState, target: &AxisTarget, limits: &AxisLimits) -> Extremal {
        if self == Side::Forwards {
            return Extremal::new(start, target, limits);
        }
        let AxisState { position, velocity, acceleration } = *start;
        let mirrored = AxisState { position, velocity: -velocity, acceleration: -acceleration };
        let AxisTarget { position, velocity, acceleration } = *target;
        let arriving = AxisTarget { position, velocity: -velocity, acceleration: -acceleration };
        Extremal::new(&mirrored, &arriving, &limits.mirrored())
    }
}

impl AxisPlan {
    /// From `start` to `target` within `limits`.
    ///
    /// # Errors
    /// A limit of the wrong sign, a number that is not finite, a target outside the limits or only to be reached from there.
    pub fn new(start: &AxisState, target: &AxisTarget, limits: &AxisLimits) -> Result<Self, JerkError> {
        limits.validate()?;
        limits.check(start, target)?;
        let origin = start;
        let (recovery, start) = &recovery(origin, limits);
        let mut plan = AxisPlan {
            origin: *origin,
            recovery: *recovery,
            delay: recovery[0].duration + recovery[1].duration,
            start: *start,
            target: *target,
            limits: limits.around(start),
            fastest: [Phase::NONE; 7],
            least: 0.0,
            blocked: [(0.0, 0.0); BLOCKED],
            blocked_count: 0,
        };
        let displacement = target.position - start.position;
        if plan.rests() {
            // Nothing is impossible from rest to rest.
            if displacement != 0.0 {
                let side = if displacement > 0.0 { Side::Forwards } else { Side::Backwards };
                plan.fastest = rest_to_rest(displacement.abs(), side.sign(), limits).unwrap_or_else(|| {
                    let extreme = side.extreme(start, target, limits);
                    let place = extreme.gaps(displacement.abs(), false).items[0]
                        .map_or(extreme.beginning(), |gap| gap.1);
                    extreme.phases(&place, side.sign())
                });
                plan.least = plan.fastest.iter().map(|phase| phase.duration).sum();
            }
        } else {
            plan.plan_moving(displacement);
        }
        check_end(start, target, &End::of(start, &plan.fastest))?;
        if !plan.delay.is_finite() {
            return Err(JerkError::Precision(f64::INFINITY));
        }
        Ok(plan)
    }

    fn rests(&self) -> bool {
        let AxisPlan { start, target, .. } = self;
        [start.velocity, start.acceleration, target.velocity, target.acceleration] == [0.0; 4]
    }

    /// The fastest motion and the gaps behind it, of an axis that moves at its start or at its target.
    fn plan_moving(&mut self, displacement: f64) {
        let AxisPlan { start, target, limits, .. } = self;
        let sides = [Side::Forwards, Side::Backwards];
        let forwards = Side::Forwards.extreme(start, target, limits);
        let backwards = Side::Backwards.extreme(start, target, limits);
        let extremes = [&forwards, &backwards];
        let least_displacement = extremes[0].least_displacement();
        // On the fastest change of velocity: to the rounding of what it was computed from.
        let beginning = extremes[0].beginning();
        let a0 = start.acceleration;
        let a1 = target.acceleration;
        let speed = start.velocity.abs() + target.velocity.abs() + (a0 * a0 + a1 * a1) / limits.jerk;
        let rounding = 1e-11 * (displacement.abs() + least_displacement.abs())
            + 64.0 * f64::EPSILON * speed * beginning.duration
            + 8.0 * f64::EPSILON * (start.position.abs() + target.position.abs());
        let there = (displacement - least_displacement).abs() <= rounding;
        let all = [0, 1].map(|i| extremes[i].gaps(displacement * sides[i].sign(), there));
        let gaps = || {
            all.iter().enumerate().flat_map(|(i, gaps)| gaps.items.iter().flatten().map(move |gap| (i, gap)))
        };
        let mut fastest = (0, beginning);
        // Each gap is left once at most.
        for _ in 0..2 * BLOCKED {
            let least = fastest.1.duration;
            let Some((i, (_, end))) =
                gaps().find(|(_, (from, end))| from + 1e-12 * least < least && least < end.duration)
            else {
                break;
            };
            fastest = (i, *end);
        }
        let (i, place) = fastest;
        self.fastest = extremes[i].phases(&place, sides[i].sign());
        self.least = place.duration;
        let later = gaps().filter(|(_, (_, end))| end.duration > place.duration);
        for (slot, (_, (from, end))) in self.blocked.iter_mut().zip(later) {
            *slot = (from.max(place.duration), end.duration);
            self.blocked_count += 1;
        }
    }

    /// Shortest duration \[s\].
    #[must_use]
    pub fn least(&self) -> f64 {
        self.delay + self.least
    }

    /// How long the motion first takes to bring a start that is outside the limits, or cannot help leaving them, back within
    /// them \[s\]; 0 for any other start.
    #[must_use]
    pub fn recovery_time(&self) -> f64 {
        self.delay
    }

    /// Open intervals of longer durations \[s\] that are impossible, in no order; they may overlap or be empty.
    #[must_use]
    pub fn blocked(&self) -> [(f64, f64); BLOCKED] {
        self.blocked.map(|(from, until)| (self.delay + from, self.delay + until))
    }

    /// The shortest possible duration \[s\] that is not below `duration`.
    #[must_use]
    pub fn possible_from(&self, duration: f64) -> f64 {
        let mut duration = duration.max(self.least());
        let blocked = &self.blocked[..self.blocked_count];
        for _ in blocked {
            for (from, until) in blocked {
                if duration > self.delay + from && duration < self.delay + until {
                    duration = self.delay + until;
                }
            }
        }
        duration
    }

    /// The fastest motion.
    #[must_use]
    pub fn fastest(&self) -> JerkProfile {
        let mut profile = JerkProfile::default();
        self.write(&mut profile, &self.fastest, self.least());
        profile
    }

    /// A motion of exactly `duration` \[s\].
    ///
    /// # Errors
    /// A duration that is impossible.
    pub fn lasting(&self, duration: f64) -> Result<JerkProfile, JerkError> {
        let mut profile = JerkProfile::default();
        self.write_lasting(&mut profile, duration)?;
        Ok(profile)
    }

    /// The same, into a profile that is [`JerkProfile::default`].
    pub(super) fn write_lasting(&self, profile: &mut JerkProfile, duration: f64) -> Result<(), JerkError> {
        let next = self.possible_from(duration);
        if next != duration {
            return Err(JerkError::Duration { asked: duration, least: self.least(), next });
        }
        let start = &self.start;
        let target = &self.target;
        if duration == self.least() {
            self.write(profile, &self.fastest, duration);
            return Ok(());
        }
        let moving = duration - self.delay;
        let end = if self.rests() {
            let slower = moving / self.least;
            let phases = if self.least == 0.0 {
                let mut resting = [Phase::NONE; 7];
                resting[0].duration = moving;
                resting
            } else {
                self.fastest
                    .map(|phase| Phase::new(phase.duration * slower, phase.jerk / (slower * slower * slower)))
            };
            self.write(profile, &phases, duration)
        } else {
            let extreme = |side: Side| {
                let extreme = side.extreme(start, target, &self.limits);
                extreme.phases(&extreme.lasting(moving), side.sign())
            };
            let far = extreme(Side::Forwards);
            let near = extreme(Side::Backwards);
            let high = End::of(start, &far).point.position;
            let low = End::of(start, &near).point.position;
            let share = (target.position - low) / (high - low);
            // Not a number where both extremes are one motion.
            let share = if share >= 0.0 { share.min(1.0) } else { 0.0 };
            let (phases, count) = mixed(&far, &near, share);
            self.write(profile, &phases[..count], duration)
        };
        check_end(start, target, &end)
    }

    /// The recovery and then `phases`, of `duration` \[s\] together; returns where the phases lead without the correction of
    /// their rounding.
    fn write(&self, profile: &mut JerkProfile, phases: &[Phase], duration: f64) -> End {
        if self.delay > 0.0 {
            profile.append(0.0, &self.origin, &self.recovery);
        }
        let end = profile.append(self.delay, &self.start, phases);
        profile.end_at(duration, &self.target);
        End { time: end.time - self.delay, ..end }
    }
}

/// Double precision must be enough: never hand out a motion that jumps at its end.
fn check_end(start: &AxisState, target: &AxisTarget, end: &End) -> Result<(), JerkError> {
    let size = end.size() + start.position.abs() + target.position.abs();
    let miss = (end.point.position - target.position).abs();
    let enough = size.is_finite() && end.time.is_finite() && miss <= 1e-9 * size;
    if enough { Ok(()) } else { Err(JerkError::Precision(miss)) }
}
