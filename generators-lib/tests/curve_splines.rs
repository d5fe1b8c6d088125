//! Smoothing, rational and pose splines: closed forms, continuity, and what is refused.

use mrroc::pose::Pose;
use mrroc_generators::curve::*;
use nalgebra::{UnitQuaternion, Vector1, Vector3};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

#[test]
fn a_circle_as_a_rational_spline_is_a_circle() {
    let centre = Vector3::new(0.3, -0.2, 0.5);
    let circle = Nurbs::circle(centre, Vector3::x(), Vector3::z(), 0.25).unwrap();
    for i in 0..=1000 {
        let at = circle.at(4.0 * f64::from(i) / 1000.0);
        let out = at.value - centre;
        assert!((out.norm() - 0.25).abs() < 1e-15 && out.y.abs() < 1e-16, "{}", out.norm() - 0.25);
        assert!(out.dot(&at.first).abs() < 1e-15);
    }
    let curve = ByLength::new(circle).unwrap();
    assert!((curve.length() / (TAU * 0.25) - 1.0).abs() < 1e-11, "{}", curve.length());
    for i in 0..=1000 {
        let angle = TAU * f64::from(i) / 1000.0;
        let at = curve.at(0.25 * angle);
        let (s, c) = angle.sin_cos();
        assert!((at.position - centre - Vector3::new(c, 0.0, s) * 0.25).norm() < 1e-11, "{angle}");
        assert!((at.tangent - Vector3::new(-s, 0.0, c)).norm() < 1e-10);
        assert!((at.curvature + Vector3::new(c, 0.0, s) * 4.0).norm() < 1e-8, "{}", at.curvature);
    }
    assert_eq!(curve.at(9.0).position, curve.path().at(4.0).value);
}

#[test]
fn lengths_of_a_parabola_and_of_a_cusp_are_their_closed_forms() {
    // y = x^2 over 0..1: L = x sqrt(1 + 4 x^2) / 2 + asinh(2 x) / 4.
    let points = [Vector3::zeros(), Vector3::new(0.5, 0.0, 0.0), Vector3::new(1.0, 1.0, 0.0)];
    let parabola = Nurbs::new(2, &points, &[1.0; 3], vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0]).unwrap();
    let curve = ByLength::new(parabola).unwrap();
    let exact = |x: f64| 0.5 * x * (1.0 + 4.0 * x * x).sqrt() + 0.25 * (2.0 * x).asinh();
    assert!((curve.length() - exact(1.0)).abs() < 1e-11);
    for x in [1e-9, 1e-3, 0.3, 0.77, 0.999_999] {
        assert!((curve.parameter(exact(x)) - x).abs() < 1e-10, "{x}");
    }
    // (t^2, t^3) over -1..1: L = 2 (13^1.5 - 8) / 27, with a cusp in the middle.
    let points = [(1.0, -1.0), (-1.0 / 3.0, 1.0), (-1.0 / 3.0, -1.0), (1.0, 1.0)];
    let points = points.map(|(x, y)| Vector3::new(x, y, 0.0));
    let cusp = Nurbs::new(3, &points, &[1.0; 4], vec![-1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0]).unwrap();
    let curve = ByLength::new(cusp).unwrap();
    let length = 2.0 * (13.0_f64.powf(1.5) - 8.0) / 27.0;
    assert!((curve.length() / length - 1.0).abs() < 1e-9, "{}", curve.length());
    for i in 0..=100 {
        let at = curve.at(length * f64::from(i) / 100.0);
        assert!((at.tangent.norm() - 1.0).abs() < 1e-9 && at.position.iter().all(|x| x.is_finite()));
    }
}

#[test]
fn smoothing_goes_from_the_points_to_the_line_of_regression() {
    let knots = vec![0.0, 1.0, 2.5, 3.0, 5.0];
    let points = [0.0, 2.0, -1.0, 4.0, 3.0].map(Vector1::new);
    let smooth = |lambda| CubicSpline::smoothing(knots.clone(), &points, &[1.0; 5], lambda);
    for (knot, point) in knots.iter().zip(points) {
        assert!((smooth(0.0).unwrap().at(*knot).value - point).norm() < 1e-12);
    }
    // Least squares: slope sum (x - mx)(y - my) / sum (x - mx)^2, through the means 2.3 and 1.6.
    let pairs = || knots.iter().zip(points).map(|(x, y)| (x - 2.3, y.x - 1.6));
    let slope = pairs().map(|(x, y)| x * y).sum::<f64>() / pairs().map(|(x, _)| x * x).sum::<f64>();
    let line = smooth(1e9).unwrap();
    for u in [0.0, 1.7, 5.0] {
        assert!((line.at(u).value.x - 1.6 - slope * (u - 2.3)).abs() < 1e-6, "{u}");
    }
    assert!(CubicSpline::smoothing(vec![0.0, 1.0], &points[..2], &[1.0; 2], 3.0).is_ok());
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(smooth(bad), Err(CurveError::Weights));
        let weighted = CubicSpline::smoothing(knots.clone(), &points, &[1.0, 1.0, bad, 1.0, 1.0], 1.0);
        assert_eq!(weighted, Err(CurveError::Weights));
    }
    assert_eq!(CubicSpline::smoothing(knots.clone(), &points[..4], &[1.0; 5], 1.0), Err(CurveError::Knots));
    assert_eq!(CubicSpline::smoothing(knots.clone(), &points, &[1.0; 4], 1.0), Err(CurveError::Weights));
}

#[test]
fn what_is_no_rational_spline_is_refused() {
    let points = [Vector3::zeros(), Vector3::x(), Vector3::y()];
    let knots = |k: [f64; 6]| Nurbs::new(2, &points, &[1.0; 3], k.to_vec());
    assert!(knots([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]).is_ok());
    for bad in [[0.0; 6], [0.0, 0.0, 1.0, 0.5, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0, 1.0, f64::NAN]] {
        assert_eq!(knots(bad), Err(CurveError::Knots));
    }
    let good = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(Nurbs::new(2, &points, &[1.0, bad, 1.0], good.clone()), Err(CurveError::Weights));
        assert!(Nurbs::circle(Vector3::zeros(), Vector3::x(), Vector3::y(), bad).is_err());
    }
    assert_eq!(Nurbs::new(3, &points, &[1.0; 3], good.clone()), Err(CurveError::Knots));
    assert_eq!(Nurbs::new(0, &points, &[1.0; 3], good.clone()), Err(CurveError::Knots));
    let still = Nurbs::new(2, &[Vector3::x(); 3], &[1.0; 3], good).unwrap();
    assert_eq!(ByLength::new(still), Err(CurveError::Coincident));
}

#[test]
fn orientations_half_a_turn_apart_make_a_spline_or_an_error() {
    let about = |axis: Vector3<f64>| UnitQuaternion::from_scaled_axis(axis);
    let two =
        RotationSpline::new(vec![0.0, 1.0], vec![about(Vector3::zeros()), about(Vector3::z() * PI)]).unwrap();
    assert!((two.at(0.5).0.angle() - 0.5 * PI).abs() < 1e-12);
    let turns = [Vector3::x() * PI, Vector3::y() * PI, Vector3::z() * PI, Vector3::zeros()];
    if let Ok(spline) = RotationSpline::new(vec![0.0, 1.0, 1.1, 5.0], turns.map(about).to_vec()) {
        assert!(spline.at(1.05).1.iter().all(|x| x.is_finite()));
    }
    assert_eq!(RotationSpline::new(vec![0.0, 0.0], vec![about(turns[0]); 2]), Err(CurveError::Knots));
    assert_eq!(
        RotationSpline::new(vec![0.0, f64::INFINITY], vec![about(turns[0]); 2]),
        Err(CurveError::NotFinite)
    );
}

proptest! {
    #[test]
    fn a_spline_through_poses_passes_them_and_nothing_jumps(
        poses in prop::collection::vec(proptest::array::uniform6(-0.8..0.8f64), 2..7),
        spans in prop::collection::vec(0.2..2.0f64, 6),
    ) {
        let poses: Vec<_> = poses
            .iter()
            .map(|x| Pose::new(Vector3::new(x[0], x[1], x[2]), Vector3::new(x[3], x[4], x[5])))
            .collect();
        let mut knots = vec![0.0];
        for i in 1..poses.len() {
            knots.push(knots[i - 1] + spans[i - 1]);
        }
        let orientations = poses.iter().map(|pose| pose.rotation).collect();
        let (spline, turning) = (
            PoseSpline::new(knots.clone(), &poses).unwrap(),
            RotationSpline::new(knots.clone(), orientations).unwrap(),
        );
        let (most_w, most_a) = turning.bounds();
        for (knot, pose) in knots.iter().zip(&poses) {
            let at = spline.at(*knot);
            prop_assert!((at.translation.vector - pose.translation.vector).norm() < 1e-15);
            prop_assert!(at.rotation.angle_to(&pose.rotation) < 1e-7);
            let (before, here) = (turning.at(knot.next_down()), turning.at(*knot));
            prop_assert!((before.1 - here.1).norm() < 1e-10 * (1.0 + here.1.norm()));
            prop_assert!((before.2 - here.2).norm() < 1e-9 * (1.0 + here.2.norm()), "{} {}", before.2, here.2);
        }
        let h = 1e-5;
        for i in 1..200 {
            let u = knots[knots.len() - 1] * (f64::from(i) + 0.3) / 201.0;
            let [a, b, c] = [-h, 0.0, h].map(|h| turning.at(u + h));
            let w = (a.0.inverse() * c.0).scaled_axis() / (2.0 * h);
            prop_assert!((w - b.1).norm() < 1e-6 * (1.0 + w.norm() + most_a), "{w} {}", b.1);
            prop_assert!(((c.1 - a.1) / (2.0 * h) - b.2).norm() < 1e-4 * (1.0 + most_a), "{u}");
            prop_assert!(b.1.norm() <= most_w * (1.0 + 1e-12) && b.2.norm() <= most_a * (1.0 + 1e-12));
        }
    }
}
