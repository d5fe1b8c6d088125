//! The slopes at the first two points of one window: all that a moving segment uses of it.

use nalgebra::Vector3;

/// What holds at an end of a window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum EndCondition {
    /// No second derivative: `2 m_0 + m_1 = 3 D_0`.
    #[default]
    Natural,
    /// The first two spans are one cubic; a parabola or a line where points are too few.
    NotAKnot,
    /// The slope is given [m per unit of the parameter].
    Slope(Vector3<f64>),
}

/// Slopes at the first and second point of the cubic spline through `points` (2 or more) with knot spans
/// `h` (one fewer). Slices that do not fit give `None`.
///
/// Thomas elimination from the far end: `m_{k+1} = r_{k+1} - f_{k+1} m_k` holds at the far end and is carried back to
/// the second point; the start condition then gives the first slope. No array is needed.
#[must_use]
pub fn first_slopes(
    points: &[Vector3<f64>],
    h: &[f64],
    start: EndCondition,
    end: EndCondition,
) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let h = h.get(..points.len().checked_sub(1)?)?;
    slopes_of_chords(h, |k| (points[k + 1] - points[k]) / h[k], start, end)
}

/// As [`first_slopes`], from the knot spans and the chord slopes `D_k`.
#[inline]
pub(super) fn slopes_of_chords(
    h: &[f64],
    chord: impl Fn(usize) -> Vector3<f64>,
    start: EndCondition,
    end: EndCondition,
) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let first = h.first()?;
    let n = h.len() + 1;
    let mut later = chord(n - 2);
    let (mut r, mut f) = far_end(end, n, h, &later, &chord);
    for k in (1..n - 1).rev() {
        let before = h[k - 1];
        let after = h[k];
        let earlier = chord(k - 1);
        let pivot = 1.0 / (2.0 * (before + after) - before * f);
        r = ((earlier * after + later * before) * 3.0 - r * before) * pivot;
        f = after * pivot;
        later = earlier;
    }
    let m0 = match start {
        EndCondition::Slope(slope) => slope,
        EndCondition::Natural => (later * 3.0 - r) / (2.0 - f),
        EndCondition::NotAKnot if n == 2 => (later * 3.0 - r) / (2.0 - f),
        EndCondition::NotAKnot if n == 3 => (later * 2.0 - r) / (1.0 - f),
        EndCondition::NotAKnot => {
            let second = h[1];
            let both = first + h[1];
            let rhs = (later * ((first + 2.0 * both) * second) + chord(1) * (first * first)) / both;
            (rhs - r * both) / (second - both * f)
        }
    };
    Some((m0, r - m0 * f))
}

/// `(r, f)` of the far end's `m_last = r - f m_before`; `d` is its chord slope.
#[inline]
fn far_end(
    end: EndCondition,
    n: usize,
    h: &[f64],
    d: &Vector3<f64>,
    chord: &impl Fn(usize) -> Vector3<f64>,
) -> (Vector3<f64>, f64) {
    match end {
        EndCondition::Slope(slope) => (slope, 0.0),
        EndCondition::Natural => (d * 1.5, 0.5),
        EndCondition::NotAKnot if n == 2 => (d * 1.5, 0.5),
        EndCondition::NotAKnot if n == 3 => (d * 2.0, 1.0),
        EndCondition::NotAKnot => {
            let last = h[n - 2];
            let before = h[n - 3];
            let both = last + before;
            let rhs = (d * ((last + 2.0 * both) * before) + chord(n - 3) * (last * last)) / both;
            (rhs / before, both / before)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_points_are_a_line_under_any_condition_and_three_a_parabola() {
        let line = [Vector3::zeros(), Vector3::x() * 2.0];
        for condition in [EndCondition::Natural, EndCondition::NotAKnot] {
            let (m0, m1) = first_slopes(&line, &[2.0], condition, condition).unwrap();
            assert!((m0 - Vector3::x()).norm() < 1e-15 && (m1 - Vector3::x()).norm() < 1e-15);
        }
        // y = t^2 at t = 0, 1, 3: slopes 0 and 2.
        let parabola = [Vector3::zeros(), Vector3::new(1.0, 1.0, 0.0), Vector3::new(3.0, 9.0, 0.0)];
        let (m0, m1) =
            first_slopes(&parabola, &[1.0, 2.0], EndCondition::NotAKnot, EndCondition::NotAKnot).unwrap();
        assert!((m0 - Vector3::new(1.0, 0.0, 0.0)).norm() < 1e-14);
        assert!((m1 - Vector3::new(1.0, 2.0, 0.0)).norm() < 1e-14);
        assert!(first_slopes(&line[..1], &[], EndCondition::Natural, EndCondition::Natural).is_none());
    }
}
