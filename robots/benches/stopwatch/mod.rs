//! How the benchmarks of this crate take a time.

use std::time::Instant;

/// Nanoseconds of one call: the best of the means of so many measurements, of so many calls each.
pub fn best_mean(measurements: u32, calls: u32, mut call: impl FnMut(u32)) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..measurements {
        let start = Instant::now();
        (0..calls).for_each(&mut call);
        best = best.min(start.elapsed().as_secs_f64() / f64::from(calls));
    }
    best * 1e9
}
