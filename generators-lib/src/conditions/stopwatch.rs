//! Seconds counted step by step.

use mrroc::prelude::*;

/// The time that has passed in so many steps, and the time that is to pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stopwatch {
    /// What is to pass \[s\].
    goal: f64,
    passed: f64,
    /// What rounding took away from `passed`: a sum of a million steps must not miss one.
    lost: f64,
}

impl Stopwatch {
    /// One that stands at 0.
    pub const fn until(goal: f64) -> Self {
        Stopwatch { goal, passed: 0.0, lost: 0.0 }
    }

    /// Refuses a time that cannot pass.
    pub fn check(&self) -> Result<(), Fault> {
        if self.goal.is_finite() && self.goal >= 0.0 {
            return Ok(());
        }
        Err(Fault::thrown("the time of a condition must be finite and >= 0"))
    }

    /// A step more.
    pub const fn advance(&mut self, t: Tick) {
        let more = t.duration + self.lost;
        let sum = self.passed + more;
        self.lost = more - (sum - self.passed);
        self.passed = sum;
    }

    /// From 0 again.
    pub const fn reset(&mut self) {
        *self = Stopwatch::until(self.goal);
    }

    /// Whether the time has passed, up to rounding: `n` steps of T / n are T.
    pub fn is_over(&self, t: Tick) -> bool {
        self.passed >= self.goal - 1e-9 * t.duration - 2.0 * f64::EPSILON * self.goal
    }
}
