//! The steepest ramp in steps: what a value may be now that has to go to zero by bounded changes.

/// The largest first term of a sequence that falls to 0 by at most `change` from term to term and has this sum.
///
/// With `n` terms after it, `n d <= α < (n + 1) d`, the sum is `(n + 1) α - d n (n + 1) / 2`.
#[must_use]
pub fn steepest(sum: f64, change: f64) -> f64 {
    if change.is_infinite() {
        return sum;
    }
    let n = (0.5 * ((1.0 + 8.0 * sum / change).sqrt() - 1.0)).floor();
    sum / (n + 1.0) + 0.5 * n * change
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_has_its_sum_and_falls_by_its_change() {
        // 2.5 + 1.5 + 0.5, 3 + 2 + 1, one term, and none.
        assert_eq!(steepest(4.5, 1.0), 2.5);
        assert_eq!(steepest(6.0, 1.0), 3.0);
        assert_eq!(steepest(0.25, 1.0), 0.25);
        assert_eq!(steepest(0.0, 1.0), 0.0);
        assert_eq!(steepest(7.0, f64::INFINITY), 7.0);
    }
}
