//! A value beyond its limit: of a demand, of a drive, of joints that share a limit.

/// A value beyond its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excess {
    /// The value met.
    pub actual: f64,
    /// The value allowed.
    pub limit: f64,
    /// The unit of both.
    pub unit: &'static str,
}

impl Excess {
    /// `actual`, where `limit` is allowed, both in `unit`.
    #[must_use]
    pub const fn new(actual: f64, limit: f64, unit: &'static str) -> Self {
        Excess { actual, limit, unit }
    }

    /// Which side of the limit is allowed, in words: `at least` it where the value is below it, else `at most` it.
    #[must_use]
    pub fn allowed(&self) -> &'static str {
        if self.actual < self.limit { "at least" } else { "at most" }
    }
}
