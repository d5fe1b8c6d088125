//! The feed rate: how fast path time passes, from 0 (suspended) to 1 (as planned).
//!
//! The MP alone changes it, by a bounded amount per second and within what every robot of the instruction
//! reported as its rate margin; the path time of a step travels in every order, so all robots slow down in the
//! same step.

use crate::safety::ramp::steepest;

/// How fast the rate may change without breaking a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateMargin {
    /// Largest rise \[1/s\].
    pub rise: f64,
    /// Largest fall \[1/s\].
    pub fall: f64,
    /// Largest change of rise and fall \[1/s²\]; infinite where jerk has no limit.
    pub bend: f64,
    /// What a rate that rises comes to.
    pub full: FullRate,
    /// The highest rate that the robot goes at, 0 to 1: lower than 1 where its controller or a person at its pendant has slowed
    /// it down.
    pub most: f64,
}

/// How a rate that rises must come to 1, where a path leaves least: below it the square of the rise may be more by twice
/// the bend for what is left. A rise that keeps this needs nowhere to become slower by more than the bend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FullRate {
    /// Largest rise there \[1/s\].
    pub rise: f64,
    /// Largest change of the rise meanwhile \[1/s²\]; infinite where jerk has no limit.
    pub bend: f64,
}

impl FullRate {
    const UNLIMITED: FullRate = FullRate { rise: f64::INFINITY, bend: f64::INFINITY };

    /// The largest rise at this rate \[1/s\].
    fn rise_at(self, rate: f64) -> f64 {
        if self.bend.is_infinite() {
            return f64::INFINITY;
        }
        (self.rise * self.rise + 2.0 * self.bend * (1.0 - rate)).sqrt()
    }
}

impl RateMargin {
    /// The rate margin of a robot that stands: nothing limits the rate.
    pub const UNLIMITED: RateMargin = RateMargin {
        rise: f64::INFINITY,
        fall: f64::INFINITY,
        bend: f64::INFINITY,
        full: FullRate::UNLIMITED,
        most: 1.0,
    };

    /// The rate margin of two robots together: the smaller of each value.
    #[must_use]
    #[inline]
    pub fn and(self, other: RateMargin) -> RateMargin {
        RateMargin {
            rise: smaller(self.rise, other.rise),
            fall: smaller(self.fall, other.fall),
            bend: smaller(self.bend, other.bend),
            full: FullRate {
                rise: smaller(self.full.rise, other.full.rise),
                bend: smaller(self.full.bend, other.full.bend),
            },
            most: self.most.min(other.most),
        }
    }
}

/// The smaller of two numbers, neither of which is NaN: one instruction, where `f64::min` takes six.
#[inline]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger of two numbers, neither of which is NaN.
#[inline]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The rate and its change.
#[derive(Clone, Debug)]
pub(crate) struct Feed {
    rate: f64,
    /// The present change of the rate [1/s].
    slope: f64,
    /// Largest change of the rate [1/s].
    change: f64,
    margin: RateMargin,
}

/// From full speed to a standstill in 0.2 s, when the robots leave room for it.
pub(crate) const DEFAULT_CHANGE: f64 = 5.0;

impl Feed {
    pub fn new(change: f64) -> Feed {
        Feed { rate: 1.0, slope: 0.0, change, margin: RateMargin::UNLIMITED }
    }

    /// The rate now, 0 ..= 1.
    pub const fn rate(&self) -> f64 {
        self.rate
    }

    /// A robot's report of the step that ended.
    #[inline]
    pub fn limit(&mut self, margin: RateMargin) {
        self.margin = self.margin.and(margin);
    }

    /// The rate of the next step, of `duration` \[s\], in the change to `wanted`.
    pub fn advance(&mut self, wanted: f64, duration: f64) -> f64 {
        if duration <= 0.0 {
            return self.rate;
        }
        let RateMargin { rise, fall, bend, full, most } = self.margin;
        let wanted = wanted.min(most).clamp(0.0, 1.0);
        let left = wanted - self.rate;
        if left == 0.0 && self.slope == 0.0 {
            // As nearly always: it is there, and stays.
            self.margin = RateMargin::UNLIMITED;
            return self.rate;
        }
        // A rate that falls may bend by more, the lower it is; one that rises, by less.
        let largest = if left < 0.0 {
            self.change.min(fall).min(steepest(-left / duration, bend * duration))
        } else {
            let landing = steepest(left / duration, full.bend * duration);
            self.change.min(rise).min(full.rise_at(raised(self.rate, duration))).min(landing)
        };
        let low = self.slope - bend * duration;
        let high = self.slope + bend * duration;
        self.slope = largest.copysign(left).clamp(low, high);
        let next = self.rate + self.slope * duration;
        let arrives = (next - wanted).abs() <= 4.0 * f64::EPSILON;
        self.rate = if arrives { wanted } else { next.clamp(0.0, 1.0) };
        self.margin = RateMargin::UNLIMITED;
        self.rate
    }

    /// The rate that a step of `duration` \[s\] had, changed elsewhere.
    #[inline]
    pub fn follow(&mut self, rate: f64, duration: f64) {
        self.slope = if duration > 0.0 { (rate - self.rate) / duration } else { 0.0 };
        self.rate = rate;
        self.margin = RateMargin::UNLIMITED;
    }

    /// At a standstill nothing needs a ramp: a new motion starts at the wanted rate.
    pub fn reset(&mut self, wanted: f64) {
        self.rate = wanted;
        self.slope = 0.0;
        self.margin = RateMargin::UNLIMITED;
    }
}

/// The longest time in which a rate comes to 0 in steps of `period` \[s\], when it changes by at most `change` \[1/s\] and within
/// this rate margin at each rate: from 1, or from where it still rises.
pub(crate) fn path_stop_time(change: f64, period: f64, margin: impl Fn(f64) -> RateMargin) -> f64 {
    // From below three quarters less is left than a rise that is turned round takes.
    const RATES: u32 = 16;
    let rises = margin(1.0).bend.is_finite();
    let steps = (0..=if rises { RATES } else { 0 }).map(|part| {
        let rate = 1.0 - 0.25 * (f64::from(part) / f64::from(RATES)).powi(2);
        let RateMargin { rise, full, .. } = margin(rate);
        let landing = steepest((1.0 - rate) / period, full.bend * period);
        let slope = change.min(rise).min(full.rise_at(rate)).min(landing);
        let mut feed = Feed { rate, slope, ..Feed::new(change) };
        let mut steps = 0_u32;
        // What has a finite rate margin comes to 0; limits that are wrong are found elsewhere.
        while (feed.rate > 0.0 || feed.slope > 0.0) && steps < 100_000 {
            feed.limit(margin(feed.rate));
            feed.advance(0.0, period);
            steps += 1;
        }
        steps
    });
    f64::from(steps.max().unwrap_or(0)) * period
}

/// The highest that a rate can be at the end of a step of `duration` \[s\].
pub(crate) fn raised(rate: f64, duration: f64) -> f64 {
    (rate + DEFAULT_CHANGE * duration).min(1.0)
}
