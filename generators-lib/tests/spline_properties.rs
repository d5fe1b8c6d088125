//! What every moving segment keeps, whatever the points.

use crate::usage::reference::*;
use mrroc_generators::bspline::*;
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

const METHODS: [Method; 4] =
    [Method::Literal(EndCondition::NotAKnot), Method::Interpolating, Method::C2, Method::FrozenControlPoints];

/// Every method, parametrisation and some windows.
fn all_settings() -> impl Iterator<Item = SplineSettings> {
    METHODS.into_iter().flat_map(|method| {
        PARAMETRISATIONS
            .into_iter()
            .flat_map(move |(_, p)| [4, 5, 8, 16].into_iter().map(move |window| settings(method, p, window)))
    })
}

fn walks() -> impl Strategy<Value = Vec<Point>> {
    proptest::collection::vec((-1.0..1.0f64, -1.0..1.0f64, 0.1..1.0f64), 2..40).prop_map(|steps| {
        steps
            .iter()
            .scan(Point::zeros(), |p, (x, y, z)| {
                *p += Point::new(*x, *y, *z);
                Some(*p)
            })
            .collect()
    })
}

#[test]
fn the_c2_method_takes_slopes_and_second_derivatives_of_the_interpolating_one() {
    for points in datasets().values() {
        for (_, p) in PARAMETRISATIONS {
            let cubic = spans(settings(Method::Interpolating, p, 8), points);
            let quintic = spans(settings(Method::C2, p, 8), points);
            for (a, b) in cubic.iter().zip(&quintic) {
                assert!((a.first(0.0) - b.first(0.0)).norm() <= 1e-14 * a.first(0.0).norm());
                assert!((a.second(0.0) - b.second(0.0)).norm() <= 1e-12 * (1.0 + a.second(0.0).norm()));
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn joins_are_c0_c1_c2_as_the_method_promises(points in walks()) {
        for set in all_settings() {
            let all = spans(set, &points);
            prop_assert_eq!(all.len(), points.len() - 1);
            for pair in all.windows(2) {
                let (a, b) = (pair[0].at(pair[0].knot_span()), pair[1].at(0.0));
                let h = pair[0].knot_span().min(pair[1].knot_span());
                let scale = size(&points);
                prop_assert!((a.position - b.position).norm() <= 1e-13 * scale);
                if !matches!(set.method, Method::Literal(_)) {
                    prop_assert!((a.first - b.first).norm() <= 1e-10 * scale / h, "{:?}", set);
                }
                if matches!(set.method, Method::C2 | Method::FrozenControlPoints) {
                    prop_assert!((a.second - b.second).norm() <= 1e-9 * scale / (h * h), "{:?}", set);
                }
            }
        }
    }

    #[test]
    fn the_last_point_is_hit_exactly_and_all_others_by_interpolation(points in walks()) {
        for set in all_settings() {
            let all = spans(set, &points);
            prop_assert_eq!(all[all.len() - 1].position(f64::INFINITY), points[points.len() - 1]);
            if set.method != Method::FrozenControlPoints {
                for (span, ends) in all.iter().zip(points.windows(2)) {
                    prop_assert_eq!(span.start(), ends[0]);
                    prop_assert_eq!(span.end(), ends[1]);
                }
            }
        }
    }

    /// Rotation and translation for every parametrisation; any affine map for the uniform one.
    #[test]
    fn the_curve_of_moved_points_is_the_moved_curve(
        points in walks(),
        angles in proptest::array::uniform3(-3.0..3.0f64),
        shift in proptest::array::uniform3(-5.0..5.0f64),
        m in proptest::array::uniform9(-1.0..1.0f64),
    ) {
        let turn = *nalgebra::Rotation3::new(Vector3::from(angles)).matrix();
        let shift = Vector3::from(shift);
        for set in all_settings() {
            let map = if set.parametrisation == Parametrisation::Uniform {
                Matrix3::from_column_slice(&m) + Matrix3::identity() * 3.0
            } else {
                turn
            };
            let moved: Vec<_> = points.iter().map(|p| map * p + shift).collect();
            for (a, b) in spans(set, &points).iter().zip(spans(set, &moved)) {
                let u = 0.37 * a.knot_span();
                prop_assert!((map * a.position(u) + shift - b.position(u)).norm() < 1e-9 * (1.0 + size(&moved)));
            }
        }
    }

    #[test]
    fn a_changed_point_leaves_the_spans_a_window_before_it_as_they_were(points in walks(), at in 0..40usize) {
        let at = at % points.len();
        let mut changed = points.clone();
        changed[at] += Point::new(0.01, 0.02, 0.0);
        for set in all_settings() {
            let (a, b) = (spans(set, &points), spans(set, &changed));
            // The C2 methods look one and two windows' shifts further.
            let reach = set.window + 2;
            for i in 0..at.saturating_sub(reach) {
                prop_assert_eq!(a[i], b[i]);
            }
            if matches!(set.method, Method::Literal(_) | Method::Interpolating) {
                for i in 0..(at + 1).saturating_sub(set.window) {
                    prop_assert_eq!(a[i], b[i]);
                }
            }
        }
    }

    #[test]
    fn points_on_a_line_give_a_line(steps in proptest::collection::vec(0.01..3.0f64, 1..30)) {
        let direction = Vector3::new(0.48, -0.6, 0.64);
        let mut points = vec![Point::new(1.0, 2.0, 3.0)];
        steps.iter().for_each(|s| points.push(points[points.len() - 1] + direction * *s));
        for set in all_settings() {
            for span in spans(set, &points) {
                for k in 0..=8 {
                    let p = span.position(f64::from(k) / 8.0 * span.knot_span()) - points[0];
                    let off = (p - direction * p.dot(&direction)).norm();
                    prop_assert!(off < 1e-12 * (1.0 + size(&points)), "{:?} {}", set, off);
                }
            }
        }
    }

    #[test]
    fn points_one_by_one_give_the_same_as_all_at_once(points in walks()) {
        let set = SplineSettings::default();
        let stream: Vec<_> =
            SpanStream::new(set, points.iter().copied()).unwrap().map(Result::unwrap).collect();
        let mut segment = MovingSegment::new(set).unwrap();
        let mut out = Vec::new();
        for p in points.iter().copied() {
            while let Poll::Span(span) = segment.poll() {
                out.push(span);
            }
            prop_assert_eq!(segment.poll(), Poll::NeedPoint);
            segment.push(p.into()).unwrap();
        }
        while let Poll::Span(span) = segment.poll() {
            out.push(span);
        }
        segment.finish();
        while let Poll::Span(span) = segment.poll() {
            out.push(span);
        }
        prop_assert_eq!(segment.poll(), Poll::Done);
        prop_assert_eq!(out, stream);
    }
}

#[test]
fn a_corner_splits_the_path_into_runs_that_rest_there() {
    // An L of 3 + 3 points, then its corner smoothed by a mark, then a corner marked on a straight line.
    let legs = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (2.0, 2.0)];
    let points = |mark: Option<(usize, Junction)>| {
        legs.iter().enumerate().map(move |(i, (x, y))| {
            let junction = mark.filter(|(at, _)| *at == i).map_or(Junction::Auto, |(_, j)| j);
            SplinePoint { position: Point::new(*x, *y, 0.0), junction, part: Part::Drawn }
        })
    };
    for method in METHODS {
        let set = SplineSettings { method, ..SplineSettings::default() };
        let ends = |mark| -> Vec<_> {
            SpanStream::new(set, points(mark))
                .unwrap()
                .map(|span| span.unwrap())
                .enumerate()
                .filter(|(_, s)| s.end == SpanEnd::Rest)
                .map(|(i, _)| i)
                .collect()
        };
        assert_eq!(ends(None), [1, 3], "{method:?}");
        assert_eq!(ends(Some((2, Junction::Smooth))), [3]);
        assert_eq!(ends(Some((1, Junction::Corner))), [0, 1, 3]);
        // The legs are straight.
        for span in SpanStream::new(set, points(None)).unwrap().map(|s| s.unwrap().span) {
            let middle = span.position(0.5 * span.knot_span());
            assert!((middle - 0.5 * (span.start() + span.end())).norm() < 1e-12);
        }
    }
}

#[test]
fn coincident_points_are_dropped_and_a_single_point_is_no_path() {
    let p = |x: f64| Point::new(x, 0.3 * x * x, 0.0);
    let plain: Vec<_> = (0..12).map(|k| p(f64::from(k) * 0.1)).collect();
    let doubled: Vec<_> = plain.iter().flat_map(|p| [*p, p + Point::x() * 1e-12, *p]).collect();
    for set in all_settings() {
        assert_eq!(spans(set, &plain), spans(set, &doubled));
        assert!(spans(set, &plain[..1]).is_empty() && spans(set, &[]).is_empty());
        assert_eq!(spans(set, &plain[..2]).len(), 1);
    }
}

#[test]
fn a_closed_path_is_smooth_at_its_seam() {
    let n = 24;
    let circle: Vec<_> = (0..=n)
        .map(|k| 2.0 * std::f64::consts::PI * f64::from(k % n) / f64::from(n))
        .map(|a| Point::new(a.cos(), a.sin(), 0.1 * (3.0 * a).sin()))
        .collect();
    for set in all_settings() {
        // With and without the first point repeated at the end.
        let round = |points: &[Point]| -> Vec<_> {
            SpanStream::new(set, ClosedPoints::new(points)).unwrap().map(|s| s.unwrap().span).collect()
        };
        let all = round(&circle);
        assert_eq!(all, round(&circle[..n as usize]));
        assert_eq!(all.len(), n as usize);
        let (last, first) = (all[all.len() - 1], all[0]);
        let (a, b) = (last.at(last.knot_span()), first.at(0.0));
        assert!((a.position - b.position).norm() < 1e-9);
        if !matches!(set.method, Method::Literal(_)) {
            assert!((a.first - b.first).norm() < 1e-9 * b.first.norm());
        }
        if matches!(set.method, Method::C2 | Method::FrozenControlPoints) {
            assert!((a.second - b.second).norm() < 1e-8 * b.second.norm(), "{set:?}");
        }
    }
}

#[test]
fn bad_settings_and_bad_points_are_refused() {
    for window in [0, 3, 17] {
        let set = SplineSettings { window, ..SplineSettings::default() };
        assert_eq!(MovingSegment::new(set).unwrap_err(), SplineError::Window(window));
    }
    let set = SplineSettings { corner: f64::NAN, ..SplineSettings::default() };
    assert!(MovingSegment::new(set).is_err());
    let mut segment = MovingSegment::new(SplineSettings::default()).unwrap();
    assert!(segment.push(Point::new(0.0, f64::NAN, 0.0).into()).is_err());
    segment.finish();
    assert_eq!(segment.push(Point::zeros().into()), Err(SplineError::NotAsked));
}
