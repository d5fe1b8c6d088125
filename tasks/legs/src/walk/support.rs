//! The support polygon and the static margin: how far the centre of mass is within it, from above.

use nalgebra::Vector2;

/// How far `centre` is within the convex hull of `feet`, along the level \[m\]: the distance of the nearest edge, negative outside; minus
/// infinity where fewer than three feet stand.
///
/// ```
/// use legs::walk::support::margin;
/// use nalgebra::Vector2;
///
/// let feet = [(0.0, 0.0), (0.4, 0.0), (0.0, 0.3)].map(|(x, y)| Vector2::new(x, y));
/// // The circle in a triangle with the sides 3, 4, 5 has the radius 1.
/// assert!((margin(&feet, &Vector2::new(0.1, 0.1)) - 0.1).abs() < 1e-15);
/// assert!((margin(&feet, &Vector2::new(0.1, -0.02)) + 0.02).abs() < 1e-15);
/// ```
#[must_use]
pub fn margin(feet: &[Vector2<f64>], centre: &Vector2<f64>) -> f64 {
    let (hull, count) = hull(feet);
    if count < 3 {
        return f64::NEG_INFINITY;
    }
    let hull = &hull[..count];
    let edges = hull.iter().zip(hull.iter().cycle().skip(1));
    let inside = |(a, b): (&Vector2<f64>, &Vector2<f64>)| (b - a).normalize().perp(&(centre - a));
    edges.map(inside).fold(f64::INFINITY, f64::min)
}

/// The corners of the convex hull of up to four points, anticlockwise, and how many there are.
#[must_use]
pub fn hull(feet: &[Vector2<f64>]) -> ([Vector2<f64>; 8], usize) {
    let mut sorted = [Vector2::zeros(); 4];
    let count = feet.len().min(4);
    sorted[..count].copy_from_slice(&feet[..count]);
    let sorted = &mut sorted[..count];
    sorted.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let (mut chain, mut length) = ([Vector2::zeros(); 8], 0);
    // Andrew's monotone chain: the lower side, then the upper one.
    for upper in [false, true] {
        let base = length;
        for i in 0..count {
            let point = if upper { sorted[count - 1 - i] } else { sorted[i] };
            while length >= base + 2
                && (chain[length - 1] - chain[length - 2]).perp(&(point - chain[length - 1])) <= 0.0
            {
                length -= 1;
            }
            chain[length] = point;
            length += 1;
        }
        // The last point of one side is the first of the other.
        length = length.saturating_sub(1);
    }
    (chain, length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_foot_within_the_triangle_of_the_others_is_no_corner() {
        let feet = [(0.0, 0.0), (0.4, 0.0), (0.1, 0.1), (0.0, 0.4)].map(|(x, y)| Vector2::new(x, y));
        assert_eq!(hull(&feet).1, 3);
        let centre = Vector2::new(0.1, 0.05);
        assert!((margin(&feet, &centre) - 0.05).abs() < 1e-15);
    }

    #[test]
    fn two_feet_or_three_in_a_line_hold_nothing() {
        let line = [(0.0, 0.0), (0.1, 0.1), (0.2, 0.2)].map(|(x, y)| Vector2::new(x, y));
        assert!(margin(&line, &Vector2::new(0.1, 0.1)) <= 0.0);
        assert!(margin(&line[..2], &Vector2::zeros()) == f64::NEG_INFINITY);
    }
}
