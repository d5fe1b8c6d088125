//! The feed rate: how fast path time passes, from 0 (suspended) to 1 (as planned).
//!
//! The MP alone changes it, by a bounded amount per second and within what every robot of the instruction
//! reported as its headroom; the path time of a step travels in every order, so all robots slow down in the
//! same step.

/// How fast the rate may change without breaking a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateHeadroom {
    /// Largest rise \[1/s\].
    pub rise: f64,
    /// Largest fall \[1/s\].
    pub fall: f64,
    /// Largest change of rise and fall \[1/s²\]; infinite where jerk has no limit.
    pub bend: f64,
}

impl RateHeadroom {
    /// The headroom of a robot that stands: nothing limits the rate.
    pub const UNLIMITED: RateHeadroom =
        RateHeadroom { rise: f64::INFINITY, fall: f64::INFINITY, bend: f64::INFINITY };

    /// The headroom of two robots together: the smaller of each value.
    #[must_use]
    pub fn and(self, other: RateHeadroom) -> RateHeadroom {
        RateHeadroom {
            rise: self.rise.min(other.rise),
            fall: self.fall.min(other.fall),
            bend: self.bend.min(other.bend),
        }
    }
}

/// The rate and its change.
#[derive(Clone, Debug)]
pub(crate) struct Feed {
    rate: f64,
    /// The present change of the rate [1/s].
    slope: f64,
    /// Largest change of the rate [1/s].
    change: f64,
    headroom: RateHeadroom,
}

/// From full speed to a standstill in 0.2 s, when the robots leave room for it.
pub(crate) const DEFAULT_CHANGE: f64 = 5.0;

impl Feed {
    pub fn new(change: f64) -> Feed {
        Feed { rate: 1.0, slope: 0.0, change, headroom: RateHeadroom::UNLIMITED }
    }

    /// The rate now, 0 ..= 1.
    pub const fn rate(&self) -> f64 {
        self.rate
    }

    /// A robot's report of the step that ended.
    pub fn limit(&mut self, headroom: RateHeadroom) {
        self.headroom = self.headroom.and(headroom);
    }

    /// The rate of the next step, of `duration` \[s\], on the way to `wanted`.
    pub fn advance(&mut self, wanted: f64, duration: f64) -> f64 {
        if duration <= 0.0 {
            return self.rate;
        }
        let wanted = wanted.clamp(0.0, 1.0);
        let RateHeadroom { rise, fall, bend } = self.headroom;
        let left = wanted - self.rate;
        let largest = if left < 0.0 { -self.change.min(fall) } else { self.change.min(rise) };
        let slope = landing(left.abs(), bend, duration).min(largest.abs()).copysign(left);
        let low = self.slope - bend * duration;
        let high = self.slope + bend * duration;
        let last = core::mem::replace(&mut self.slope, slope.clamp(low, high));
        let next = self.rate + self.slope * duration;
        // Within a step of the end, and slow enough to end there: exactly at it.
        let lands = (next - wanted) * left >= 0.0 || (wanted - next).abs() <= f64::EPSILON;
        let arrives = lands && (last.abs() <= 2.0 * bend * duration || bend.is_infinite());
        self.rate = if arrives { wanted } else { next.clamp(0.0, 1.0) };
        if self.rate == wanted {
            self.slope = 0.0;
        }
        self.headroom = RateHeadroom::UNLIMITED;
        self.rate
    }

    /// The rate that a step of `duration` \[s\] had, changed elsewhere.
    pub fn follow(&mut self, rate: f64, duration: f64) {
        self.slope = if duration > 0.0 { (rate - self.rate) / duration } else { 0.0 };
        self.rate = rate;
        self.headroom = RateHeadroom::UNLIMITED;
    }

    /// At a standstill nothing needs a ramp: a new motion starts at the wanted rate.
    pub fn reset(&mut self, wanted: f64) {
        self.rate = wanted;
        self.slope = 0.0;
        self.headroom = RateHeadroom::UNLIMITED;
    }
}

/// The largest slope from which the rate can come to rest after `left`, one step of it included: the root of
/// `slope T + slope² / 2 bend = left`.
fn landing(left: f64, bend: f64, duration: f64) -> f64 {
    if bend.is_infinite() || left <= bend * duration * duration {
        return left / duration;
    }
    bend * ((duration * duration + 2.0 * left / bend).sqrt() - duration)
}
