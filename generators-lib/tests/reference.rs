//! The reference data, and splines to compare with.
#![allow(dead_code)]

use mrroc_generators::bspline::*;
use nalgebra::Vector3;
use std::collections::BTreeMap;

pub type Point = Vector3<f64>;

pub const PARAMETRISATIONS: [(&str, Parametrisation); 3] = [
    ("uniform", Parametrisation::Uniform),
    ("centripetal", Parametrisation::Centripetal),
    ("chord", Parametrisation::Chord),
];

/// Rows of a reference file: the first `labels` columns as text, the rest as numbers.
pub fn rows(file: &str, labels: usize) -> Vec<(Vec<String>, Vec<f64>)> {
    let path = format!("{}/tests/reference/{file}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let row = |line: &str| {
        let cells: Vec<_> = line.split(',').collect();
        let (text, numbers) = cells.split_at(labels);
        (
            text.iter().map(|s| s.to_string()).collect(),
            numbers.iter().map(|x| x.trim().parse().unwrap()).collect(),
        )
    };
    text.lines().skip(1).map(row).collect()
}

pub fn datasets() -> BTreeMap<String, Vec<Point>> {
    let mut sets: BTreeMap<String, Vec<Point>> = BTreeMap::new();
    for (label, n) in rows("points.csv", 1) {
        sets.entry(label[0].clone()).or_default().push(Point::new(n[1], n[2], n[3]));
    }
    sets
}

pub fn size(points: &[Point]) -> f64 {
    points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max)
}

/// No corners: one run.
pub fn settings(method: Method, parametrisation: Parametrisation, window: usize) -> SplineSettings {
    SplineSettings { method, parametrisation, window, corner: std::f64::consts::PI }
}

pub fn spans(settings: SplineSettings, points: &[Point]) -> Vec<Span> {
    SpanStream::new(settings, points.iter().copied()).unwrap().map(|span| span.unwrap().span).collect()
}

pub fn knot_spans(points: &[Point], p: Parametrisation) -> Vec<f64> {
    points.windows(2).map(|w| p.knot_span(&w[0], &w[1])).collect()
}

/// The natural spline through all points, solved as a whole.
pub fn global(points: &[Point], p: Parametrisation) -> Vec<Span> {
    let h = knot_spans(points, p);
    let mut slope = EndCondition::Natural;
    (0..h.len())
        .map(|i| {
            // The rest of the path as one window: the exact start slope, carried.
            let (m0, m1) = first_slopes(&points[i..], &h[i..], slope, EndCondition::Natural).unwrap();
            slope = EndCondition::Slope(m1);
            Span::cubic(points[i], points[i + 1], m0, m1, h[i])
        })
        .collect()
}
