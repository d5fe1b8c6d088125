//! Motion of one axis in phases of constant jerk.

use super::{AxisState, AxisTarget};

/// Most phases: two profiles of seven, merged, behind a recovery of two.
pub(super) const PHASES: usize = 16;

/// A time of constant jerk.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Phase {
    /// How long it takes \[s\], >= 0.
    pub duration: f64,
    /// The jerk [m/s^3].
    pub jerk: f64,
}

impl Phase {
    /// One without duration.
    pub const NONE: Phase = Phase::new(0.0, 0.0);

    #[inline]
    pub const fn new(duration: f64, jerk: f64) -> Self {
        Phase { duration, jerk }
    }
}

/// The phases of a profile.
pub(super) type Phases = [Phase; 7];

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
            position: position + t * (velocity + t * (0.5 * acceleration + t * jerk * (1.0 / 6.0))),
            velocity: velocity + t * (acceleration + t * 0.5 * jerk),
            acceleration: acceleration + t * jerk,
            jerk,
        }
    }
}

impl AxisState {
    #[inline]
    fn point(&self) -> AxisPoint {
        let AxisState { position, velocity, acceleration } = *self;
        AxisPoint { position, velocity, acceleration, jerk: 0.0 }
    }
}

/// Where phases lead.
#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    pub time: f64,
    pub point: AxisPoint,
    /// The largest speed at the ends of phases [m/s].
    pub fastest: f64,
}

impl End {
    /// From `start` through all phases.
    #[inline]
    pub fn of(start: &AxisState, phases: &[Phase]) -> Self {
        let mut end = End { time: 0.0, point: start.point(), fastest: start.velocity.abs() };
        for &Phase { duration, jerk } in phases {
            if duration > 0.0 {
                end.point.jerk = jerk;
                end.advance(duration);
            }
        }
        end
    }

    #[inline]
    fn advance(&mut self, duration: f64) {
        self.point = self.point.after(duration);
        self.time += duration;
        self.fastest = self.fastest.max(self.point.velocity.abs());
    }

    /// A length of the order of this motion's displacements \[m\].
    pub fn size(&self) -> f64 {
        self.fastest * self.time
    }
}

/// The phases, and how many they are, of a mixture of two motions of one duration: `share` of the one and the rest of the
/// other. It is within the limits if both are, since limits bound a convex set.
pub(super) fn mixed(ours: &Phases, theirs: &Phases, share: f64) -> ([Phase; 14], usize) {
    let mut merged = [Phase::NONE; 14];
    let mut count = 0;
    let mut i = 0;
    let mut k = 0;
    let mut left = ours[0].duration;
    let mut right = theirs[0].duration;
    loop {
        // What is left of each phase. In each turn of the loop one of them ends, or both at once.
        while left <= 0.0 {
            i += 1;
            let Some(phase) = ours.get(i) else { return (merged, count) };
            left = phase.duration;
        }
        while right <= 0.0 {
            k += 1;
            let Some(phase) = theirs.get(k) else { return (merged, count) };
            right = phase.duration;
        }
        let a = ours[i].jerk;
        let b = theirs[k].jerk;
        let duration = left.min(right);
        // Where both have the same jerk, it stays exactly that.
        merged[count] = Phase::new(duration, b + share * (a - b));
        count += 1;
        left -= duration;
        right -= duration;
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
    /// Goes on, or begins, at `time` in the state `start`, through `phases`; those without duration are left out.
    /// Returns where that leads.
    #[inline]
    pub(super) fn append(&mut self, time: f64, start: &AxisState, phases: &[Phase]) -> End {
        let mut count = self.phases;
        let mut end = End { time, point: start.point(), fastest: start.velocity.abs() };
        for &Phase { duration, jerk } in phases {
            if duration > 0.0 {
                end.point.jerk = jerk;
                self.knots[count] = Knot { time: end.time, point: end.point };
                count += 1;
                end.advance(duration);
            }
        }
        end.point.jerk = 0.0;
        self.knots[count] = Knot { time: end.time, point: end.point };
        self.phases = count;
        end
    }

    /// Becomes the motion of `other`, `scale` times as far and from `start`.
    #[inline]
    pub(super) fn set_scaled(&mut self, other: &JerkProfile, start: f64, scale: f64) {
        let origin = other.knots[0].point.position;
        self.phases = other.phases;
        for (knot, Knot { time, point }) in self.knots.iter_mut().zip(&other.knots[..=other.phases]) {
            *knot = Knot {
                time: *time,
                point: AxisPoint {
                    position: start + (point.position - origin) * scale,
                    velocity: point.velocity * scale,
                    acceleration: point.acceleration * scale,
                    jerk: point.jerk * scale,
                },
            };
        }
    }

    /// Replaces its end by one that differs by rounding.
    #[inline]
    pub(super) fn end_at(&mut self, duration: f64, end: &AxisTarget) {
        let AxisTarget { position, velocity, acceleration } = *end;
        self.knots[self.phases] =
            Knot { time: duration, point: AxisPoint { position, velocity, acceleration, jerk: 0.0 } };
    }

    fn last(&self) -> &Knot {
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

    /// The extreme values during the motion, exact: at the ends of phases, and where the acceleration passes zero.
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
            let here = knot.point;
            let there = next.point;
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
