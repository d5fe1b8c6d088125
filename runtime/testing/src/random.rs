//! Seeded random numbers: the same seed gives the same faults.

use mrroc_core::random;

/// Random bits, and whole numbers from them.
#[derive(Clone, Debug)]
pub(super) struct Random(random::Random);

impl Random {
    pub const fn new(seed: u64) -> Random {
        Random(random::Random::seeded(seed))
    }

    pub const fn next(&mut self) -> u64 {
        self.0.bits()
    }

    /// A whole number from 0 to `end - 1`; `end` is at least 1.
    pub const fn below(&mut self, end: u64) -> u64 {
        ((self.next() as u128 * end as u128) >> 64) as u64
    }
}
