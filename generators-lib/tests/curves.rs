//! Curves against closed forms and scipy.

use mrroc::pose::Pose;
use mrroc_generators::bspline::Span;
use mrroc_generators::curve::*;
use mrroc_generators::line::SmoothToolLimits;
use mrroc_generators::profile::{JerkLimits, Profile, SevenPhase};
use mrroc_generators::waypoints::PointsError;
use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn v(x: f64, y: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, y, z)
}

/// Derivatives are those of the positions, and the tangent is of length 1: the parameter is the length.
fn is_by_length(curve: &impl Curve, tolerance: f64) {
    let (length, h) = (curve.length(), 1e-5 * curve.length());
    for i in 1..200 {
        let s = (f64::from(i) + 0.137) * length / 200.5;
        let (before, here, after) = (curve.at(s - h), curve.at(s), curve.at(s + h));
        assert!((here.tangent.norm() - 1.0).abs() < 1e-12);
        assert!(here.tangent.dot(&here.curvature).abs() < 1e-9 * (1.0 + here.curvature.norm()));
        let slope = (after.position - before.position) / (2.0 * h);
        assert!((slope - here.tangent).norm() < tolerance, "{s} of {length}: {slope} {}", here.tangent);
        let bend = (after.tangent - before.tangent) / (2.0 * h);
        assert!((bend - here.curvature).norm() < tolerance * 10.0 / length, "{s} of {length}");
    }
    assert_eq!(curve.at(-1.0).position, curve.at(0.0).position);
    assert_eq!(curve.at(length + 1.0).position, curve.at(length).position);
}

#[test]
fn an_arc_through_three_points_is_the_circle_through_them() {
    // On the unit circle about (1, 2, 3) in a tilted plane.
    let turn = UnitQuaternion::from_euler_angles(0.4, -0.7, 1.1);
    let on = |angle: f64| v(1.0, 2.0, 3.0) + turn * v(angle.cos(), angle.sin(), 0.0);
    for (via, end) in [(0.3, 0.9), (2.0, 3.5), (5.0, 6.0), (-0.2, -1.0), (-3.0, -6.1)] {
        let arc = Arc::through(on(0.0), on(via), on(end)).unwrap();
        assert!((arc.centre() - v(1.0, 2.0, 3.0)).norm() < 1e-12, "{}", arc.centre());
        assert!((arc.radius() - 1.0).abs() < 1e-12 && (arc.length() - end.abs()).abs() < 1e-12);
        assert!((arc.at(via.abs()).position - on(via)).norm() < 1e-12);
        assert_eq!(arc.at(arc.length()).position, on(end));
        assert!((arc.at(0.1).curvature + arc.at(0.1).position - arc.centre()).norm() < 1e-12);
        is_by_length(&arc, 1e-8);
    }
    let line = [v(0.0, 0.0, 0.0), v(1.0, 1.0, 0.0), v(3.0, 3.0, 0.0)];
    assert_eq!(Arc::through(line[0], line[1], line[2]), Err(CurveError::Collinear));
    assert_eq!(Arc::through(line[0], line[0], line[2]), Err(CurveError::Coincident));
    assert_eq!(Arc::through(line[0], line[1], v(f64::NAN, 0.0, 0.0)), Err(CurveError::NotFinite));
    for size in [1e-300, 1e-100, 1e100, 1e300] {
        if let Ok(arc) = Arc::through(v(0.0, 0.0, 0.0), v(size, 0.0, 0.0), v(0.0, size, 0.0)) {
            assert!((arc.length() / size - PI * 0.5_f64.sqrt() * 1.5).abs() < 4.0, "{size}");
            assert!(arc.at(0.5 * arc.length()).position.iter().all(|x| x.is_finite()));
        }
    }
}

#[test]
fn a_helix_is_as_long_as_its_closed_form() {
    let helix = Helix::about(v(0.2, 0.0, 0.1), v(0.0, 0.0, 5.0), Vector3::z_axis(), 3.0 * TAU, 0.05).unwrap();
    assert!((helix.length() - 3.0 * (TAU * 0.2).hypot(0.05)).abs() < 1e-12);
    assert!((helix.at(helix.length()).position - v(0.2, 0.0, 0.25)).norm() < 1e-12);
    // Curvature r / (r^2 + p^2), p = pitch / 2 pi.
    let p = 0.05 / TAU;
    assert!((helix.at(0.3).curvature.norm() - 0.2 / (0.04 + p * p)).abs() < 1e-12);
    is_by_length(&helix, 1e-6);
    let back = Helix::about(v(0.2, 0.0, 0.1), v(0.0, 0.0, 5.0), Vector3::z_axis(), -FRAC_PI_2, 0.04).unwrap();
    assert!((back.at(back.length()).position - v(0.0, -0.2, 0.09)).norm() < 1e-12);
    assert!(Helix::about(v(0.0, 0.0, 1.0), v(0.0, 0.0, 5.0), Vector3::z_axis(), 1.0, 0.1).is_err());
    assert!(Arc::about(v(1.0, 0.0, 0.0), v(0.0, 0.0, 0.0), Vector3::z_axis(), 0.0).is_err());
}

/// Perimeters `4 a E(1 - b^2 / a^2)` and a quadrature by scipy 1.17.1.
#[test]
fn an_ellipse_is_as_long_as_scipy_says() {
    for (a, b, expected) in [
        (1.0, 0.5, 4.844_224_110_273_838),
        (0.3, 0.2, 1.586_543_958_929_059),
        (2.0, 0.1, 8.038_851_238_291_922),
    ] {
        let ellipse = Ellipse::new(v(1.0, 0.0, 0.0), v(0.0, a, 0.0), v(0.0, 0.0, b), 0.0, TAU).unwrap();
        assert!((ellipse.length() - expected).abs() < 1e-9 * a, "{} {expected}", ellipse.length());
        assert!((ellipse.at(0.25 * expected).position - v(1.0, 0.0, b)).norm() < 1e-9 * a);
        assert!((ellipse.at(0.5 * expected).position - v(1.0, -a, 0.0)).norm() < 1e-9 * a);
    }
    let part = Ellipse::new(v(0.0, 0.0, 0.0), v(0.3, 0.0, 0.0), v(0.0, 0.2, 0.0), 0.4, 2.9).unwrap();
    assert!((part.length() - 0.661_865_705_966_185_7).abs() < 1e-12, "{}", part.length());
    is_by_length(&part, 1e-6);
    assert!((part.at(0.0).position - v(0.3 * 0.4_f64.cos(), 0.2 * 0.4_f64.sin(), 0.0)).norm() < 1e-14);
    let skew = Ellipse::new(v(0.0, 0.0, 0.0), v(0.3, 0.0, 0.0), v(0.1, 0.2, 0.0), 0.0, 1.0);
    assert!(matches!(skew, Err(CurveError::Skew(_))));
}

#[test]
fn a_blended_corner_is_passed_at_the_deviation_asked_for() {
    let corner = [v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(1.0, 1.0, 0.0)];
    let curve = blended(&corner, 0.01).unwrap();
    let nearest = |p: Vector3<f64>| {
        (0..=20_000)
            .map(|i| (curve.at(f64::from(i) * curve.length() / 20_000.0).position - p).norm())
            .fold(f64::INFINITY, f64::min)
    };
    assert!((nearest(corner[1]) - 0.01).abs() < 1e-6);
    is_by_length(&Segment::new(corner[0], corner[2]).unwrap(), 1e-9);
    // Tangents agree where the pieces meet, and the ends are met.
    for pair in curve.spans().windows(2) {
        let (end, start) = (pair[0].at(pair[0].knot_span()), pair[1].at(0.0));
        assert!(
            (end.position - start.position).norm() < 1e-15
                && (end.tangent() - start.tangent()).norm() < 1e-12
        );
    }
    assert_eq!((curve.at(0.0).position, curve.at(9.0).position), (corner[0], corner[2]));
    // Two legs less d = 4 deviation / sqrt 2 each, and the parabola between tangents at right angles:
    // d (sqrt 2 + asinh(1)) / sqrt 2.
    let d = 0.04 / 2.0_f64.sqrt();
    let parabola = d * (2.0_f64.sqrt() + 1.0_f64.asinh()) / 2.0_f64.sqrt();
    assert!((curve.length() - (2.0 - 2.0 * d + parabola)).abs() < 1e-9, "{}", curve.length());
    // A short leg is shared by the blends at its ends.
    let short = [v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(1.0, 0.01, 0.0), v(2.0, 0.01, 0.0)];
    assert!(blended(&short, 1.0).unwrap().spans().len() >= 4);
    let (same, none) = ([v(1.0, 0.0, 0.0); 3], blended(&corner, 0.0));
    assert_eq!(
        (blended(&same, 0.1), none),
        (Err(CurveError::Points(PointsError::Coincident)), Err(CurveError::Deviation(0.0)))
    );
    assert!(SpanCurve::new(Vec::<Span>::new()).is_err() && Segment::new(corner[0], corner[0]).is_err());
}

/// Chasles: half the screw, twice, is the screw; points of its axis move along it.
#[test]
fn a_screw_divides_evenly_and_meets_its_ends() {
    let poses = [
        Pose::new(v(0.8, -0.3, 0.5), v(3.0, 0.1, -0.2)),
        Pose::new(v(0.7, 0.1, 0.2), v(1.0, -0.5, 0.4)),
        Pose::new(v(0.8, -0.3, 0.6), v(3.0, 0.1, -0.2)),
        Pose::new(v(0.1, 0.2, 0.3), v(3.0, 0.1005, -0.2)),
    ];
    for from in poses {
        for to in poses {
            let screw = Screw::new(from, to);
            let close = |a: &Pose, b: &Pose| {
                let off = a.inv_mul(b);
                assert!(off.translation.vector.norm() < 1e-12 && off.rotation.angle() < 1e-7, "{off}");
            };
            let third = from.inv_mul(&screw.pose(1.0 / 3.0));
            close(&(from * third * third * third), &to);
            close(&(from * third * third), &screw.pose(2.0 / 3.0));
            assert_eq!((screw.pose(0.0), screw.pose(1.0)), (from, to));
        }
    }
    // A quarter turn about z through (1, 0, 0) that rises by 0.3: the origin of (2, 0, 0) moves on a circle of 1 m.
    let from = Pose::translation(2.0, 0.0, 0.0);
    let to = Pose::new(v(1.0, 1.0, 0.3), v(0.0, 0.0, FRAC_PI_2));
    let screw = Screw::new(from, to);
    assert!(
        (screw.length() - FRAC_PI_2.hypot(0.3)).abs() < 1e-12 && (screw.angle() - FRAC_PI_2).abs() < 1e-15
    );
    let half = screw.pose(0.5).translation.vector;
    assert!((half - v(1.0 + 0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.15)).norm() < 1e-12, "{half}");
    let limits = JerkLimits { velocity: 0.2, acceleration: 1.0, jerk: 10.0 };
    let limits = SmoothToolLimits { translation: limits, rotation: JerkLimits { velocity: 9.0, ..limits } };
    let duration = screw.profile(limits).unwrap().duration();
    assert!((duration - (screw.length() / 0.2 + 0.2 + 0.1)).abs() < 1e-9, "{duration}");
}

#[test]
fn cubic_splines_equal_scipys() {
    let (mut knots, mut points, mut spline) = (vec![], vec![], None);
    let mut checked = 0;
    let text =
        std::fs::read_to_string(format!("{}/tests/reference/cubic_splines.csv", env!("CARGO_MANIFEST_DIR")))
            .unwrap();
    for line in text.lines().skip(1) {
        let mut cells = line.split(',');
        let (kind, _) = (cells.next().unwrap(), cells.next());
        let n: Vec<f64> = cells.filter(|x| !x.is_empty()).map(|x| x.parse().unwrap()).collect();
        match kind {
            "knots" => (knots, points) = (n, vec![]),
            "point" => points.push(v(n[0], n[1], n[2])),
            "ends" => {
                let ends = match n[..] {
                    [] => SplineEnds::Natural,
                    _ => SplineEnds::Clamped(v(n[0], n[1], n[2]), v(n[3], n[4], n[5])),
                };
                spline = Some(CubicSpline::new(knots.clone(), points.clone(), ends).unwrap());
            }
            _ => {
                let here = spline.as_ref().unwrap().at(n[0]);
                for (ours, theirs) in
                    [(here.value, &n[1..4]), (here.first, &n[4..7]), (here.second, &n[7..10])]
                {
                    let theirs = v(theirs[0], theirs[1], theirs[2]);
                    assert!((ours - theirs).norm() < 1e-10 * (1.0 + theirs.norm()), "{line}: {ours}");
                }
                let (first, second) = spline.as_ref().unwrap().peaks();
                assert!((0..3).all(|i| here.first[i].abs() <= first[i] + 1e-9));
                assert!((0..3).all(|i| here.second[i].abs() <= second[i] + 1e-9));
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 40 * 31);
    let bad = CubicSpline::new(vec![0.0, 0.0], vec![v(0.0, 0.0, 0.0); 2], SplineEnds::Natural);
    assert_eq!(bad, Err(CurveError::Knots));
}

#[test]
fn a_body_is_led_along_a_helix_from_where_it_is() {
    use mrroc_generators::cooperation::BodyPath;
    let helix = Helix::about(v(0.2, 0.0, 0.0), v(0.0, 0.0, 0.0), Vector3::z_axis(), TAU, 0.05).unwrap();
    let limits = JerkLimits { velocity: 0.3, acceleration: 1.0, jerk: 10.0 };
    let profile = SevenPhase::new(helix.length(), limits).unwrap();
    let start = Pose::new(v(0.8, -0.3, 0.5), v(3.0, 0.1, -0.2));
    let mut path = CurveBody::new(helix, profile);
    path.begin(&start).unwrap();
    let poses: Vec<_> = std::iter::from_fn(|| path.advance(1e-3).unwrap()).collect();
    let duration = helix.length() / 0.3 + 0.3 + 0.1;
    assert!((poses.len() as f64 * 1e-3 - duration).abs() < 1e-3);
    let end = poses.last().unwrap();
    assert!((end.translation.vector - start.translation.vector - v(0.0, 0.0, 0.05)).norm() < 1e-12);
    assert!(poses.iter().all(|pose| pose.rotation == start.rotation));
    assert!(CurveBody::new(helix, SevenPhase::new(0.1, limits).unwrap()).begin(&start).is_err());
}
