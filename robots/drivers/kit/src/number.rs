//! A number that two threads share.

use core::sync::atomic::{AtomicU64, Ordering};

/// A number that two threads share. Nothing else is ordered by it: see [`Times`](crate::Times).
#[derive(Debug, Default)]
pub struct Number(AtomicU64);

impl Number {
    /// The value that was set last; 0 before.
    #[must_use]
    pub fn get(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }

    /// Sets the value.
    pub fn set(&self, number: f64) {
        self.0.store(number.to_bits(), Ordering::Relaxed);
    }
}
