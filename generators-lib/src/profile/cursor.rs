//! A profile followed in increments of path time.

use super::{Profile, ProfilePoint, Trapezoid};

/// A walk along a [`Profile`] in increments of path time, which may differ from step to step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileCursor<P = Trapezoid> {
    profile: P,
    time: f64,
    ended: bool,
}

impl<P: Profile> ProfileCursor<P> {
    /// At the start of `profile`.
    #[must_use]
    pub fn new(profile: P) -> Self {
        ProfileCursor { profile, time: 0.0, ended: false }
    }

    /// Advances by `dt` \[s\], >= 0. The exact end is emitted once, then `None`.
    pub fn advance(&mut self, dt: f64) -> Option<ProfilePoint> {
        if self.ended {
            return None;
        }
        self.time += dt;
        // The sum of n increments may miss n * dt by rounding; that must not cost a step.
        if self.profile.duration() - self.time <= 1e-9 * dt {
            self.ended = true;
            return Some(self.profile.at(self.profile.duration()));
        }
        Some(self.profile.at(self.time))
    }

    /// Path time so far \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The profile being walked.
    #[must_use]
    pub fn profile(&self) -> &P {
        &self.profile
    }
}
