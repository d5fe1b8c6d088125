//! Lines with few points that look the same.
//!
//! In: points on the page \[px\]. Out: a subset of them, the ends among them: Ramer, Douglas and Peucker's within
//! [`FINE`], coarser or, for a curve that is all zigzag, the lowest and highest of each column, when too many are left.

use nalgebra::Vector2;

/// Distance that nobody sees \[px\].
pub(crate) const FINE: f64 = 0.12;

/// The points of a line that keep it within `tolerance`, in the page's unit, of all of them (Ramer 1972; Douglas and
/// Peucker 1973).
#[must_use]
pub fn thinned(points: &[Vector2<f64>], tolerance: f64) -> Vec<Vector2<f64>> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let mut keep = vec![false; points.len()];
    let mut open = vec![(0, points.len() - 1)];
    while let Some((first, last)) = open.pop() {
        keep[first] = true;
        keep[last] = true;
        let between = (first + 1..last).map(|i| (i, distance(points[i], points[first], points[last])));
        match between.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((worst, off)) if off > tolerance => open.extend([(first, worst), (worst, last)]),
            Some(_) | None => {}
        }
    }
    points.iter().zip(keep).filter(|(_, keep)| *keep).map(|(point, _)| *point).collect()
}

/// At most about `most` points of a curve over time (x never decreases).
pub(crate) fn curve(points: &[Vector2<f64>], most: usize) -> Vec<Vector2<f64>> {
    for tolerance in [FINE, 2.0 * FINE, 4.0 * FINE, 8.0 * FINE] {
        let line = thinned(points, tolerance);
        if line.len() <= most {
            return line;
        }
    }
    envelope(points, most)
}

/// The lowest and the highest point of each of `most / 2` columns, in order of time.
fn envelope(points: &[Vector2<f64>], most: usize) -> Vec<Vector2<f64>> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Vec::new() };
    let column = points.len().div_ceil((most / 2).max(1));
    let mut line = vec![*first];
    for column in points.chunks(column) {
        let by_height = |a: &(usize, &Vector2<f64>), b: &(usize, &Vector2<f64>)| a.1.y.total_cmp(&b.1.y);
        let low = column.iter().enumerate().min_by(by_height);
        let high = column.iter().enumerate().max_by(by_height);
        if let (Some(low), Some(high)) = (low, high) {
            let (a, b) = if low.0 <= high.0 { (low.1, high.1) } else { (high.1, low.1) };
            line.extend([*a, *b]);
        }
    }
    line.push(*last);
    line.dedup();
    line
}

/// Of a point from a segment \[px\].
fn distance(point: Vector2<f64>, a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    let along = b - a;
    let square = along.norm_squared();
    let share = if square > 0.0 { ((point - a).dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 };
    (point - a - along * share).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_keeps_its_ends_and_a_corner_stays() {
        let line: Vec<_> = (0..=100).map(|i| Vector2::new(f64::from(i), 2.0 * f64::from(i))).collect();
        assert_eq!(thinned(&line, 0.1), [line[0], line[100]]);
        let corner: Vec<_> =
            (0..=100).map(|i| Vector2::new(f64::from(i), f64::from((i - 50_i32).abs()))).collect();
        assert_eq!(thinned(&corner, 0.1), [corner[0], corner[50], corner[100]]);
    }

    #[test]
    fn every_point_of_a_sine_stays_within_the_tolerance() {
        let sine: Vec<_> =
            (0..2000).map(|i| Vector2::new(f64::from(i) * 0.4, 60.0 * (f64::from(i) * 0.01).sin())).collect();
        let line = thinned(&sine, 0.2);
        assert!(line.len() < 200);
        for point in &sine {
            let nearest = line.windows(2).map(|w| distance(*point, w[0], w[1])).fold(f64::INFINITY, f64::min);
            assert!(nearest <= 0.2 + 1e-12);
        }
    }

    #[test]
    fn a_zigzag_keeps_its_envelope_and_few_points() {
        let zigzag: Vec<_> = (0..4000)
            .map(|i| Vector2::new(f64::from(i) * 0.2, if i % 2 == 0 { 0.0 } else { 100.0 }))
            .collect();
        let line = curve(&zigzag, 300);
        assert!(line.len() <= 302, "{}", line.len());
        assert!(line.windows(2).all(|w| w[0].x <= w[1].x));
        assert!(line.windows(2).all(|w| (w[0].y - w[1].y).abs() > 99.0 || w[1].x - w[0].x > 1.0));
    }
}
