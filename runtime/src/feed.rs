//! The feed rate: how fast path time passes, from 0 (suspended) to 1 (as planned).
//!
//! The MP alone changes it, by a bounded amount per second and within what every robot of the instruction
//! reported as its headroom; the path time of a step travels in every order, so all robots slow down in the
//! same step.

use crate::limits::RateHeadroom;

/// The rate and its change.
#[derive(Clone, Debug)]
pub(crate) struct Feed {
    rate: f64,
    /// Largest change of the rate [1/s].
    change: f64,
    headroom: RateHeadroom,
}

/// From full speed to a standstill in 0.2 s, when the robots leave room for it.
pub(crate) const DEFAULT_CHANGE: f64 = 5.0;

const UNLIMITED: RateHeadroom = RateHeadroom { rise: f64::INFINITY, fall: f64::INFINITY };

impl Feed {
    pub fn new(change: f64) -> Feed {
        Feed { rate: 1.0, change, headroom: UNLIMITED }
    }

    /// The rate now, 0 ..= 1.
    pub const fn rate(&self) -> f64 {
        self.rate
    }

    /// A robot's report of the step that ended.
    pub fn limit(&mut self, headroom: RateHeadroom) {
        self.headroom.rise = self.headroom.rise.min(headroom.rise.max(0.0));
        self.headroom.fall = self.headroom.fall.min(headroom.fall.max(0.0));
    }

    /// The rate of the next step, of `duration` \[s\], on the way to `wanted`.
    pub fn advance(&mut self, wanted: f64, duration: f64) -> f64 {
        let rise = self.change.min(self.headroom.rise) * duration;
        let fall = self.change.min(self.headroom.fall) * duration;
        self.rate = wanted.clamp(0.0, 1.0).clamp(self.rate - fall, self.rate + rise);
        self.headroom = UNLIMITED;
        self.rate
    }

    /// At a standstill nothing needs a ramp: a new motion starts at the wanted rate.
    pub fn reset(&mut self, wanted: f64) {
        self.rate = wanted;
        self.headroom = UNLIMITED;
    }
}
