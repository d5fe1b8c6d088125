//! Grids on paths.

use crate::curve::Parametric;

/// A grid of about `cells` cells on `path`, with its knots: between two of them cells are equally long.
#[must_use]
pub fn grid<P: Parametric>(path: &P, cells: usize) -> Vec<f64> {
    let (first, last) = path.range();
    let inner = path.knots().iter().copied().filter(|knot| *knot > first && *knot < last);
    let mut grid = vec![first];
    let mut from = first;
    for to in inner.chain([last]) {
        let share = ((to - from) / (last - first) * cells as f64).round().max(1.0);
        // A share that is not a number comes from a range that is not finite, which the plan refuses.
        let count = if share.is_finite() { share as usize } else { 1 };
        grid.extend((1..count).map(|i| from + (to - from) * i as f64 / count as f64));
        grid.push(to);
        from = to;
    }
    grid
}
