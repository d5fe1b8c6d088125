//! Time-optimal motion along paths: closed forms, places that need care, and what is refused.

use mrroc::prelude::*;
use mrroc_generators::curve::{CubicSpline, Curve, Helix, Parametric, SplineEnds, SplinePoint};
use mrroc_generators::profile::Profile;
use mrroc_generators::timing::*;
use mrroc_robots::Irp6;
use nalgebra::{Translation3, Vector1, Vector2, Vector3};
use proptest::prelude::*;
use std::f64::consts::TAU;

fn line(length: f64) -> CubicSpline<Vector1<f64>> {
    CubicSpline::new(vec![0.0, 1.0], vec![Vector1::zeros(), Vector1::new(length)], SplineEnds::Natural)
        .unwrap()
}

fn limits<const N: usize>(velocity: f64, acceleration: f64) -> PathLimits<nalgebra::SVector<f64, N>> {
    PathLimits {
        velocity: nalgebra::SVector::repeat(velocity),
        acceleration: nalgebra::SVector::repeat(acceleration),
        speed: f64::INFINITY,
    }
}

#[test]
fn a_straight_line_takes_the_time_of_the_trapezoid() {
    // A grid on which the trapezoid's corners lie: D = 8, V = 2, A = 1 and D = 10: 2 m up, 2 m down.
    for (length, duration, cells) in [(8.0, 6.0, 4), (10.0, 7.0, 5), (1.0, 2.0, 10)] {
        let path = line(length);
        let plan = TimeOptimal::plan(&path, &grid(&path, cells), &limits::<1>(2.0, 1.0), [0.0; 2]).unwrap();
        assert!((plan.duration() - duration).abs() < 1e-12, "{length}: {}", plan.duration());
        assert_eq!(plan.at(plan.duration()).s, 1.0);
        assert_eq!(plan.at(-1.0).s, 0.0);
    }
    // Between speeds: v0 = 1 to v1 = 2 at A = 1 takes 1.5 m and 1 s.
    let path = line(1.5);
    let ends = [1.0 / 1.5, 2.0 / 1.5];
    let plan = TimeOptimal::plan(&path, &grid(&path, 3), &limits::<1>(9.0, 1.0), ends).unwrap();
    assert!((plan.duration() - 1.0).abs() < 1e-12 && (plan.at(9.0).v - ends[1]).abs() < 1e-12);
    // A walk along it ends at that speed, too.
    let mut cursor = plan.cursor();
    let end = core::iter::from_fn(|| cursor.advance(1e-3)).last().unwrap();
    assert!(end.s == 1.0 && (end.v - ends[1]).abs() < 1e-12, "{end:?}");
    // A speed of the path's parameter alone: 1 at 0.5.
    let slow = PathLimits { speed: 0.5, ..limits::<1>(1e3, 1e6) };
    let plan = TimeOptimal::plan(&line(1.0), &grid(&line(1.0), 100), &slow, [0.0; 2]).unwrap();
    assert!((2.0..2.1).contains(&plan.duration()), "{}", plan.duration());
}

/// A circle in two joints by its angle: `q'' = -q`, so that the speed is `min(V, sqrt(A))` and each joint reverses twice.
struct Round;

impl Parametric for Round {
    type Value = Vector2<f64>;

    fn range(&self) -> (f64, f64) {
        (0.0, TAU)
    }

    fn at(&self, u: f64) -> SplinePoint<Vector2<f64>> {
        let (s, c) = u.sin_cos();
        SplinePoint { value: Vector2::new(c, s), first: Vector2::new(-s, c), second: Vector2::new(-c, -s) }
    }
}

#[test]
fn where_a_joint_reverses_the_acceleration_does_not_chatter() {
    let plan = TimeOptimal::plan(&Round, &grid(&Round, 200), &limits::<2>(10.0, 1.0), [0.0; 2]).unwrap();
    // The largest acceleration is at most the speed's limit: x <= 1 where q'' is along an axis.
    let accelerations: Vec<f64> =
        (0..2000).map(|i| plan.at(plan.duration() * f64::from(i) / 2000.0).a).collect();
    let turns = accelerations.windows(2).filter(|a| a[0] * a[1] < 0.0).count();
    assert!(turns <= 20, "the sign of the acceleration changes {turns} times");
    for i in 0..=10_000 {
        let point = plan.at(plan.duration() * f64::from(i) / 10_000.0);
        let at = Round.at(point.s);
        let a = (at.first * point.a + at.second * point.v * point.v).amax();
        // No parabola: the third order of a cell of 0.03.
        assert!(a < 1.0 + 1e-6, "{a}");
    }
}

#[test]
fn a_path_that_stops_and_turns_back_is_passed() {
    // One joint there and back: all joints reverse at the peak, inside the path.
    let points = [0.0, 1.0, 0.0].map(Vector1::new).to_vec();
    let path = CubicSpline::new(vec![0.0, 1.0, 2.0], points, SplineEnds::Natural).unwrap();
    for cells in [4, 20, 200, 1000_u32] {
        let plan = TimeOptimal::plan(&path, &grid(&path, cells as usize), &limits::<1>(10.0, 1.0), [0.0; 2])
            .unwrap();
        // At the peak the joint is at rest: twice 1 m from rest to rest with A = 1.
        let over = plan.duration() - 4.0;
        assert!(over > -1e-9 && over < 10.0 / f64::from(cells), "{cells}: {}", plan.duration());
        for i in 0..=10_000 {
            let point = plan.at(plan.duration() * f64::from(i) / 10_000.0);
            let at = path.at(point.s);
            let a = (at.first * point.a + at.second * point.v * point.v).amax();
            assert!(a < 1.0 + 1e-9, "{cells}: {a} at {}", point.s);
        }
    }
}

#[test]
fn a_load_is_lifted_if_the_drive_can_and_refused_otherwise() {
    // Gravity 5 against a drive of 6 upwards or 4: `tau = q'' + 5`.
    let path = line(1.0);
    let plan = |most: f64| {
        TimeOptimal::with_linear_limits(
            &path,
            &grid(&path, 50),
            &limits::<1>(100.0, 100.0),
            [0.0; 2],
            |at, more| {
                let tau = |_: &Vector1<f64>, _: &Vector1<f64>, a: &Vector1<f64>| a + Vector1::new(5.0);
                more.extend(torque_limits(at, tau, &Vector1::new(-most), &Vector1::new(most)));
            },
        )
    };
    // Up with 1, down with 11: v^2 / 2 + v^2 / 22 = 1, t = v + v / 11.
    let v = (1.0_f64 / (0.5 + 1.0 / 22.0)).sqrt();
    let duration = plan(6.0).unwrap().duration();
    assert!((duration / (v + v / 11.0) - 1.0).abs() < 1e-2, "{duration}");
    // A drive of 4 only brakes: the start would need a speed.
    assert!(matches!(plan(4.0), Err(TimingError::Speed { place: "start", asked: 0.0, .. })));
    // Nor does one brake that must be pushed from both sides.
    let none =
        TimeOptimal::with_linear_limits(&path, &[0.0, 1.0], &limits::<1>(1.0, 1.0), [0.0; 2], |_, more| {
            more.push(LinearLimit { a: 0.0, b: 0.0, low: 1.0, high: 2.0 });
        });
    assert!(matches!(none, Err(TimingError::Impassable(_))));
}

#[test]
fn the_path_of_a_tool_is_followed_by_the_joints_and_its_slopes_are_the_jacobians() {
    let (robot, q) = (Irp6::nominal(), Irp6::READY);
    let start = robot.forward(&q);
    let helix =
        Helix::about(Vector3::x() * 0.05, Vector3::zeros(), Vector3::z_axis(), TAU, 0.03).expect("a helix");
    let pose = |s: f64| -> Pose { Translation3::from(helix.at(s).position - helix.at(0.0).position) * start };
    let spline = joint_spline(&robot, pose, helix.length(), &q, 1e-6).unwrap();
    for i in 0..=100 {
        let s = helix.length() * f64::from(i) / 100.0;
        let (at, h) = (spline.at(s), 1e-4);
        let off = robot.forward(&at.value).translation.vector - pose(s).translation.vector;
        assert!(off.norm() < 3e-6, "{}", off.norm());
        // The tool's velocity by the joints' is the tangent.
        let tool = |h: f64| robot.forward(&(at.value + at.first * h)).translation.vector;
        let tangent = (tool(h) - tool(-h)) / (2.0 * h);
        assert!((tangent - helix.at(s).tangent).norm() < 1e-3, "{tangent} {}", helix.at(s).tangent);
    }
    let far = |s: f64| Translation3::new(0.0, 0.0, 10.0 * s) * start;
    assert!(matches!(joint_spline(&robot, far, 1.0, &q, 1e-6), Err(TimingError::NoInverse { .. })));
    let corner = |s: f64| Translation3::new(0.05 * (s - 0.5).abs(), 0.0, 0.0) * start;
    assert!(matches!(joint_spline(&robot, corner, 1.0, &q, 1e-9), Err(TimingError::NotSmooth { .. })));
}

#[test]
fn what_is_no_problem_is_refused() {
    let path = line(1.0);
    let plan = |grid: &[f64], limits, ends| TimeOptimal::plan(&path, grid, &limits, ends);
    let good = limits::<1>(1.0, 1.0);
    for grid in [&[][..], &[0.0], &[0.0, 0.5], &[0.0, 0.0, 1.0], &[0.0, f64::NAN, 1.0], &[-1.0, 1.0]] {
        assert!(matches!(plan(grid, good, [0.0; 2]), Err(TimingError::Grid(..))), "{grid:?}");
    }
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(plan(&[0.0, 1.0], limits(bad, 1.0), [0.0; 2]).is_err());
        assert!(plan(&[0.0, 1.0], limits(1.0, bad), [0.0; 2]).is_err());
    }
    for bad in [-1.0, f64::NAN, 2.0, f64::INFINITY] {
        for ends in [[bad, 0.0], [0.0, bad]] {
            let refused = plan(&[0.0, 1.0], good, ends);
            assert!(matches!(refused, Err(TimingError::Speed { .. })), "{bad} {refused:?}");
        }
    }
    let mut count = 0;
    let uneven = TimeOptimal::with_linear_limits(&path, &[0.0, 1.0], &good, [0.0; 2], |_, more| {
        count += 1;
        more.extend((0..count).map(|_| LinearLimit { a: 1.0, b: 0.0, low: -1.0, high: 1.0 }));
    });
    assert!(matches!(uneven, Err(TimingError::Rows { .. })));
}

proptest! {
    #[test]
    fn any_spline_is_passed_within_the_limits_or_refused(
        points in prop::collection::vec([-2.0..2.0f64, -2.0..2.0f64], 2..8),
        v in 0.01..10.0f64,
        a in 0.01..100.0f64,
        scale in prop::sample::select(vec![1e-300, 1e-9, 1.0, 1e9, 1e300]),
    ) {
        let knots = (0..points.len()).map(|i| i as f64).collect();
        let points = points.iter().map(|p| Vector2::new(p[0], p[1]) * scale).collect();
        let Ok(path) = CubicSpline::new(knots, points, SplineEnds::Natural) else { return Ok(()) };
        let limits = limits::<2>(v, a);
        let Ok(plan) = TimeOptimal::plan(&path, &grid(&path, 60), &limits, [0.0; 2]) else {
            prop_assert!(scale != 1.0, "refused");
            return Ok(());
        };
        prop_assert!(plan.duration() > 0.0 && plan.duration().is_finite());
        for i in 0..=2000 {
            let point = plan.at(plan.duration() * f64::from(i) / 2000.0);
            let at = path.at(point.s);
            let (q, x) = (at.first * point.v, point.v * point.v);
            let acceleration = at.first * point.a + at.second * x;
            prop_assert!(q.amax() <= v * (1.0 + 1e-9), "{} > {v}", q.amax());
            prop_assert!(acceleration.amax() <= a * (1.0 + 1e-9), "{} > {a} at {}", acceleration.amax(), point.s);
        }
    }
}
