//! Splines against scipy, and against another implementation.

use crate::usage::reference::*;
use mrroc_generators::bspline::*;

/// Positions to 1e-9 of the size, derivatives to 1e-8 relative (of the largest met).
fn assert_equal(span: &Span, u: f64, expected: &[f64], size: f64, what: &str) {
    let at = span.at(u * span.knot_span());
    let vector = |k: usize| Point::new(expected[k], expected[k + 1], expected[k + 2]);
    let h = span.knot_span();
    assert!((at.position - vector(0)).norm() <= 1e-9 * size, "{what}: position");
    assert!((at.first - vector(3)).norm() <= 1e-8 * (vector(3).norm() + size / h * 1e-3), "{what}: slope");
    assert!(
        (at.second - vector(6)).norm() <= 1e-8 * (vector(6).norm() + size / (h * h) * 1e-3),
        "{what}: S''"
    );
}

#[test]
fn first_spans_of_windows_equal_scipy_for_every_end_condition() {
    let sets = datasets();
    for (label, n) in rows("windows.csv", 3) {
        let (points, p) = (&sets[&label[0]], parametrisation(&label[1]));
        let h = &knot_spans(points, p)[..7];
        let w = &points[..8];
        let (first, last) = ((w[1] - w[0]) / h[0], (w[7] - w[6]) / h[6]);
        let (start, end) = match label[2].as_str() {
            "natural" => (EndCondition::Natural, EndCondition::Natural),
            "not-a-knot" => (EndCondition::NotAKnot, EndCondition::NotAKnot),
            "slope/natural" => (EndCondition::Slope(first), EndCondition::Natural),
            _ => (EndCondition::Slope(first), EndCondition::Slope(last)),
        };
        let (m0, m1) = first_slopes(w, h, start, end).unwrap();
        let span = Span::cubic(w[0], w[1], m0, m1, h[0]);
        assert_equal(&span, n[1], &n[2..], size(points), &label.join(" "));
    }
}

#[test]
fn the_literal_method_uses_the_first_span_of_every_window() {
    let sets = datasets();
    for (label, n) in rows("windows.csv", 3) {
        let ends = match label[2].as_str() {
            "natural" => EndCondition::Natural,
            "not-a-knot" => EndCondition::NotAKnot,
            _ => continue,
        };
        let (points, p) = (&sets[&label[0]], parametrisation(&label[1]));
        let all = spans(settings(Method::Literal(ends), p, 8), points);
        assert_eq!(all.len(), points.len() - 1);
        assert_equal(&all[0], n[1], &n[2..], size(points), &label.join(" "));
    }
}

#[test]
fn the_interpolating_method_equals_the_chain_of_scipy() {
    let sets = datasets();
    let mut chains = std::collections::BTreeMap::new();
    for (label, n) in rows("chain.csv", 3) {
        let points = &sets[&label[0]];
        let chain = chains
            .entry((label[0].clone(), label[1].clone()))
            .or_insert_with(|| spans(settings(Method::Interpolating, parametrisation(&label[1]), 8), points));
        assert_eq!(chain.len(), points.len() - 1);
        assert_equal(&chain[n[0] as usize], n[1], &n[2..], size(points), &format!("{label:?} {}", n[0]));
    }
}

/// Basis of the non-uniform cubic B-spline by the recursion of Cox and de Boor: another method than the code's.
fn de_boor(t: &[f64], c: &[Point], span: usize, at: f64) -> Point {
    // Control c[k] belongs to the knots t[k]..t[k+4]; the span is t[span+3]..t[span+4].
    let mut d: Vec<Point> = c[span..span + 4].to_vec();
    for r in 1..4 {
        for j in (r..4).rev() {
            let (low, high) = (t[span + j], t[span + j + 4 - r]);
            let a = (at - low) / (high - low);
            d[j] = d[j - 1] * (1.0 - a) + d[j] * a;
        }
    }
    d[3]
}

#[test]
fn the_frozen_control_points_equal_the_other_implementation() {
    let mut control = std::collections::BTreeMap::<(String, String), Vec<Point>>::new();
    for (label, n) in rows("frozen_cp.csv", 2) {
        let key = (label[0].clone(), label[1].clone());
        control.entry(key).or_default().push(Point::new(n[1], n[2], n[3]));
    }
    let sets = datasets();
    for ((set, param), c) in control {
        let (points, p) = (&sets[&set], parametrisation(&param));
        let h = knot_spans(points, p);
        let (first, last) = (h[0], h[h.len() - 1]);
        let mut t = vec![-3.0 * first, -2.0 * first, -first, 0.0];
        h.iter().for_each(|h| t.push(t[t.len() - 1] + h));
        (0..3).for_each(|_| t.push(t[t.len() - 1] + last));
        let all = spans(settings(Method::FrozenControlPoints, p, 8), points);
        assert_eq!(all.len(), points.len() - 1);
        for (j, span) in all.iter().enumerate() {
            for x in [0.0, 0.3, 0.7, 1.0] {
                let expected = de_boor(&t, &c, j, t[j + 3] + x * h[j]);
                let found = span.position(x * h[j]);
                assert!((found - expected).norm() < 1e-9 * size(points), "{set} {param} span {j} at {x}");
            }
        }
    }
}

#[test]
fn the_global_spline_of_these_tests_equals_scipy() {
    let sets = datasets();
    for (label, n) in rows("global.csv", 3) {
        let points = &sets[&label[0]];
        let all = global(points, parametrisation(&label[1]));
        assert_equal(&all[n[0] as usize], n[1], &n[2..], size(points), &format!("{label:?} {}", n[0]));
    }
}

/// Theory: 15 nm on the circle of R = 10 mm with 24 points, window 8; 26 nm for the quintics.
#[test]
fn windows_of_eight_come_near_the_global_spline() {
    let circle = &datasets()["circle24(R=10)"];
    let distance = |method, window| {
        let all = spans(settings(method, Parametrisation::Chord, window), circle);
        let pairs = all.iter().zip(global(circle, Parametrisation::Chord));
        pairs
            .flat_map(|(a, b)| (0..=10).map(move |k| (a, b, f64::from(k) / 10.0 * b.knot_span())))
            .map(|(a, b, u)| (a.position(u) - b.position(u)).norm())
            .fold(0.0, f64::max)
    };
    // In mm.
    assert!(distance(Method::Literal(EndCondition::Natural), 8) > 30e-3);
    assert!(distance(Method::Interpolating, 4) < 4e-3);
    assert!(distance(Method::Interpolating, 8) < 20e-6);
    assert!(distance(Method::Interpolating, 12) < 0.1e-6);
    assert!(distance(Method::C2, 8) < 30e-6);
}

#[test]
fn path_lengths_and_curvatures_equal_scipy() {
    let sets = datasets();
    for (label, n) in rows("arclength.csv", 2) {
        let (points, p) = (&sets[&label[0]], parametrisation(&label[1]));
        let all = global(points, p);
        let tolerance = if label[0].contains("corner") { 1e-7 } else { 1e-9 } * size(points);
        let (mut s, mut t) = (n[0], 0.0);
        for (i, span) in all.iter().enumerate() {
            let h = span.knot_span();
            let length = length_between(span, 0.0, h);
            if s > length && i + 1 < all.len() {
                (s, t) = (s - length, t + h);
                continue;
            }
            let u = parameter_at(span, 0.0, h, s);
            let at = span.at(u);
            assert!(
                (at.position - Point::new(n[2], n[3], n[4])).norm() < tolerance,
                "{label:?} s = {}",
                n[0]
            );
            assert!((t + u - n[1]).abs() < 1e-6 * (1.0 + n[1]), "{label:?} t = {}", n[1]);
            let bent = (at.curvature() - n[5]).abs();
            assert!(
                bent < 1e-5 * (n[5] + 1.0 / size(points)),
                "{label:?} s = {}: curvature off by {bent}",
                n[0]
            );
            break;
        }
    }
}

fn parametrisation(name: &str) -> Parametrisation {
    PARAMETRISATIONS.iter().find(|(n, _)| *n == name).unwrap().1
}
