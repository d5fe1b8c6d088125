//! Motion of one axis in phases of constant jerk.

use super::{AxisState, AxisTarget};

/// Most phases: two profiles of seven, merged, behind a brake of two.
pub(super) const PHASES: usize = 16;

/// A duration \[s\] and a jerk [m/s^3] each.
pub(super) type Phases = [(f64, f64); 7];

/// An axis at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisPoint {
    /// Position \[m\].
    pub position: f64,
    /// Velocity [m/s].
    pub velocity: f64,
    /// Acceleration [m/s^2].
    pub acceleration: f64,
    /// Jerk [m/s^3]; where it jumps, that of the later phase.
    pub jerk: f64,
}

/// The extreme values that a profile takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peaks {
    /// Largest and least velocity [m/s].
    pub velocity: (f64, f64),
    /// Largest and least acceleration [m/s^2].
    pub acceleration: (f64, f64),
    /// Largest and least jerk [m/s^3].
    pub jerk: (f64, f64),
}

/// Where a phase begins, and its jerk.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Knot {
    pub time: f64,
    pub point: AxisPoint,
}

impl AxisPoint {
    /// The same motion `t` later, at this point's jerk.
    #[inline]
    fn after(&self, t: f64) -> AxisPoint {
        let AxisPoint { position, velocity, acceleration, jerk } = *self;
        AxisPoint {
            position: position + t * (velocity + t * (0.5 * acceleration + t * jerk / 6.0)),
            velocity: velocity + t * (acceleration + t * 0.5 * jerk),
            acceleration: acceleration + t * jerk,
            jerk,
        }
    }

    /// `share` of one motion and the rest of another.
    #[inline]
    fn mixed(&self, other: &AxisPoint, share: f64) -> AxisPoint {
        // What both agree on stays as it is.
        let mix = |a: f64, b: f64| b + share * (a - b);
        AxisPoint {
            position: mix(self.position, other.position),
            velocity: mix(self.velocity, other.velocity),
            acceleration: mix(self.acceleration, other.acceleration),
            jerk: mix(self.jerk, other.jerk),
        }
    }
}

/// Motion of one axis in phases of constant jerk, over path time; immutable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JerkProfile {
    knots: [Knot; PHASES + 1],
    phases: usize,
}

impl Default for JerkProfile {
    /// Rest at 0, without duration.
    fn default() -> Self {
        JerkProfile { knots: [Knot::default(); PHASES + 1], phases: 0 }
    }
}

impl JerkProfile {
    /// Rest at `position` for `duration` \[s\].
    pub(super) fn resting(position: f64, duration: f64) -> Self {
        let start = AxisState { position, ..AxisState::default() };
        let mut phases = [(0.0, 0.0); 7];
        phases[0].0 = duration;
        JerkProfile::through(&start, &phases)
    }

    /// From `start` through phases of a duration and a jerk each; those without duration are left out.
    pub(super) fn through(start: &AxisState, phases: &Phases) -> Self {
        let mut profile = JerkProfile::default();
        let AxisState { position, velocity, acceleration } = *start;
        let (mut time, mut point) = (0.0, AxisPoint { position, velocity, acceleration, jerk: 0.0 });
        for &(duration, jerk) in phases {
            if duration > 0.0 {
                point.jerk = jerk;
                profile.knots[profile.phases] = Knot { time, point };
                profile.phases += 1;
                point = point.after(duration);
                time += duration;
            }
        }
        point.jerk = 0.0;
        profile.knots[profile.phases] = Knot { time, point };
        profile
    }

    /// `share` of `self` and the rest of `other`, which lasts as long: within the limits if both are, since limits bound
    /// a convex set.
    pub(super) fn mixed(&self, other: &JerkProfile, share: f64) -> Self {
        let mut merged = JerkProfile::default();
        let (mut i, mut k) = (0, 0);
        while i < self.phases && k < other.phases {
            let (ours, theirs) = (&self.knots[i], &other.knots[k]);
            let time = ours.time.max(theirs.time);
            let point =
                ours.point.after(time - ours.time).mixed(&theirs.point.after(time - theirs.time), share);
            let (our_end, their_end) = (self.knots[i + 1].time, other.knots[k + 1].time);
            if our_end.min(their_end) > time {
                merged.knots[merged.phases] = Knot { time, point };
                merged.phases += 1;
            }
            (i, k) = (i + usize::from(our_end <= their_end), k + usize::from(their_end <= our_end));
        }
        merged.knots[merged.phases] =
            Knot { time: self.duration(), point: self.last().point.mixed(&other.last().point, share) };
        merged
    }

    /// The same way from rest to rest, `k` >= 1 times slower: velocities shrink by `k`, accelerations by `k^2`.
    pub(super) fn slowed(mut self, k: f64) -> Self {
        for knot in &mut self.knots[..=self.phases] {
            knot.time *= k;
            knot.point.velocity /= k;
            knot.point.acceleration /= k * k;
            knot.point.jerk /= k * k * k;
        }
        self
    }

    /// The way from `start`, `scale` times as far.
    pub(super) fn scaled(mut self, start: f64, scale: f64) -> Self {
        let origin = self.knots[0].point.position;
        for knot in &mut self.knots[..=self.phases] {
            knot.point.position = start + (knot.point.position - origin) * scale;
            knot.point.velocity *= scale;
            knot.point.acceleration *= scale;
            knot.point.jerk *= scale;
        }
        self
    }

    /// The same, with its end replaced by one that differs by rounding.
    pub(super) fn ending_at(mut self, duration: f64, end: &AxisTarget) -> Self {
        let AxisTarget { position, velocity, acceleration } = *end;
        self.knots[self.phases] =
            Knot { time: duration, point: AxisPoint { position, velocity, acceleration, jerk: 0.0 } };
        self
    }

    /// The same behind phases that lead from `start` to where it begins.
    pub(super) fn after(&self, start: &AxisState, phases: &[(f64, f64); 2]) -> Self {
        let mut all: Phases = Default::default();
        all[..2].copy_from_slice(phases);
        let mut joined = JerkProfile::through(start, &all);
        let (first, time) = (joined.phases, joined.duration());
        for (knot, later) in joined.knots[first..].iter_mut().zip(&self.knots[..=self.phases]) {
            *knot = Knot { time: time + later.time, point: later.point };
        }
        joined.phases = first + self.phases;
        joined
    }

    /// A length of the order of the ways on this motion \[m\].
    pub(super) fn size(&self) -> f64 {
        let fastest =
            self.knots[..=self.phases].iter().map(|knot| knot.point.velocity.abs()).fold(0.0, f64::max);
        fastest * self.duration()
    }

    pub(super) fn last(&self) -> &Knot {
        &self.knots[self.phases]
    }

    /// Duration \[s\].
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.last().time
    }

    /// The axis at path time `t` \[s\]. At the end it is exactly at its target, and goes on from there as the target's velocity
    /// and acceleration say; before 0 it is at its start.
    #[must_use]
    #[inline]
    pub fn at(&self, t: f64) -> AxisPoint {
        let mut knot = &self.knots[0];
        for later in &self.knots[1..=self.phases] {
            if t < later.time {
                break;
            }
            knot = later;
        }
        knot.point.after((t - knot.time).max(0.0))
    }

    /// The extreme values on the way, exact: at the ends of phases, and where the acceleration passes zero.
    #[must_use]
    pub fn peaks(&self) -> Peaks {
        let first = self.knots[0].point;
        let both = |x: f64| (x, x);
        let mut peaks = Peaks {
            velocity: both(first.velocity),
            acceleration: both(first.acceleration),
            jerk: both(first.jerk),
        };
        let widen = |(high, low): &mut (f64, f64), x: f64| (*high, *low) = (high.max(x), low.min(x));
        for (knot, next) in self.knots[..self.phases].iter().zip(&self.knots[1..]) {
            let (here, there) = (knot.point, next.point);
            widen(&mut peaks.velocity, there.velocity);
            widen(&mut peaks.acceleration, there.acceleration);
            widen(&mut peaks.jerk, here.jerk);
            if here.acceleration * there.acceleration < 0.0 {
                widen(&mut peaks.velocity, here.after(-here.acceleration / here.jerk).velocity);
            }
        }
        peaks
    }
}
