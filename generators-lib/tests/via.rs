//! Motion through via points: closed forms, deviations and limits, and what is refused.

use mrroc::pose::Pose;
use mrroc_generators::jerk::JointLimits;
use mrroc_generators::line::SmoothToolLimits;
use mrroc_generators::profile::JerkLimits;
use mrroc_generators::via::*;
use mrroc_generators::waypoints::PointsError;
use nalgebra::{Vector2, Vector3};
use proptest::prelude::*;

fn limits(v: f64, a: f64, j: f64) -> JointLimits<Vector2<f64>> {
    JointLimits { velocity: Vector2::repeat(v), acceleration: Vector2::repeat(a), jerk: Vector2::repeat(j) }
}

#[test]
fn one_leg_takes_the_closed_form_time() {
    let leg = |d: f64, v, a, j| {
        let points = [Vector2::zeros(), Vector2::new(d, 0.3 * d)];
        ViaJoints::new(&points, &limits(v, a, j), &Vector2::repeat(0.1)).unwrap().duration()
    };
    // Seven phases: the table of tests/jerk_plan.rs; without a limit of jerk: (10, 2, 1) 7 s and (3, 2, 1) sqrt 12 s.
    let table = [
        (1.0, 1.0, 1.0, 1.0, 3.174_802_103_936),
        (1.0, 1.0, 1.0, 2.0, 2.561_552_812_809),
        (1.0, 0.6, 1.0, 2.0, 2.766_666_666_667),
        (2.0, 1.0, 4.0, 40.0, 2.35),
        (10.0, 2.0, 1.0, f64::INFINITY, 7.0),
        (3.0, 2.0, 1.0, f64::INFINITY, 3.464_101_615_138),
    ];
    for (d, v, a, j, expected) in table {
        assert!((leg(d, v, a, j) - expected).abs() < 1e-11, "{} {expected}", leg(d, v, a, j));
    }
}

#[test]
fn a_right_angle_is_passed_at_the_stated_deviation() {
    // |dv| = V sqrt 2 within A = 2 per joint: t = V / A = 0.5, parabola: deviation V t / 8 = 0.0625 per joint.
    let points = [Vector2::zeros(), Vector2::new(5.0, 0.0), Vector2::new(5.0, 5.0)];
    let parabolic = limits(1.0, 2.0, f64::INFINITY);
    let wide = ViaJoints::new(&points, &parabolic, &Vector2::repeat(1.0)).unwrap();
    // 10 m at 1 m/s, less nothing at the corner, and a ramp of 0.5 s at the ends.
    assert!((wide.duration() - 10.5).abs() < 1e-12, "{}", wide.duration());
    let off = wide.at(5.25) - points[1];
    assert!((off - Vector2::new(-0.0625, 0.0625)).norm() < 1e-12, "{off}");
    // Half the deviation: sqrt 2 slower.
    let narrow = ViaJoints::new(&points, &parabolic, &Vector2::repeat(0.03125)).unwrap();
    let nearest = |motion: &ViaJoints<Vector2<f64>>| {
        let times = (0..=200_000).map(|i| motion.duration() * f64::from(i) / 2e5);
        times.map(|t| (motion.at(t) - points[1]).amax()).fold(f64::INFINITY, f64::min)
    };
    assert!((nearest(&narrow) - 0.03125).abs() < 1e-4, "{}", nearest(&narrow));
    assert!(narrow.duration() > wide.duration() && narrow.duration() < 10.8, "{}", narrow.duration());
}

#[test]
fn what_is_no_motion_is_refused() {
    let two = [Vector2::zeros(), Vector2::x()];
    let one = Vector2::repeat(0.1);
    let coincident = ViaJoints::new(&[two[0], two[0]], &limits(1.0, 1.0, 1.0), &one);
    assert_eq!(coincident, Err(ViaError::Points(PointsError::Coincident)));
    assert!(ViaJoints::<Vector2<f64>>::new(&[], &limits(1.0, 1.0, 1.0), &one).is_err());
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        for limits in [limits(bad, 1.0, 1.0), limits(1.0, bad, 1.0)] {
            assert!(matches!(ViaJoints::new(&two, &limits, &one), Err(ViaError::Limit { .. })));
        }
        assert!(ViaJoints::new(&two, &limits(1.0, 1.0, 1.0), &Vector2::repeat(bad)).is_err());
        if bad != f64::INFINITY {
            assert!(ViaJoints::new(&two, &limits(1.0, 1.0, bad), &one).is_err());
        }
    }
    let nan = [two[0], Vector2::repeat(f64::NAN)];
    assert_eq!(
        ViaJoints::new(&nan, &limits(1.0, 1.0, 1.0), &one),
        Err(ViaError::Points(PointsError::NotFinite(1)))
    );
}

fn poses() -> impl Strategy<Value = Vec<Pose>> {
    let pose = proptest::array::uniform6(-1.0..1.0f64)
        .prop_map(|x| Pose::new(Vector3::new(x[0], x[1], x[2]), Vector3::new(x[3], x[4], x[5]) * 1.5));
    prop::collection::vec(pose, 2..6)
}

proptest! {
    #[test]
    fn joints_keep_their_limits_and_pass_every_point(
        points in prop::collection::vec([-1.0..1.0f64, -1.0..1.0f64], 2..7),
        (v, a, j) in (0.1..3.0f64, 0.1..10.0f64, prop::sample::select(vec![0.5, 5.0, 50.0, f64::INFINITY])),
        deviation in prop::sample::select(vec![1e-4, 1e-2, 0.3]),
    ) {
        let points: Vec<_> = points.iter().map(|p| Vector2::new(p[0], p[1])).collect();
        let motion = ViaJoints::new(&points, &limits(v, a, j), &Vector2::repeat(deviation)).unwrap();
        let n = 4000;
        let dt = motion.duration() / f64::from(n);
        let at = |i: i32| motion.at(f64::from(i) * dt);
        let mut nearest = vec![f64::INFINITY; points.len()];
        for i in -2..n + 3 {
            let q = [at(i - 1), at(i), at(i + 1), at(i + 2)];
            let speed = (q[1] - q[0]) / dt;
            let acceleration = (q[2] - q[1] * 2.0 + q[0]) / (dt * dt);
            let jerk = (q[3] - q[2] * 3.0 + q[1] * 3.0 - q[0]) / (dt * dt * dt);
            prop_assert!(speed.amax() <= v * (1.0 + 1e-9), "{speed}");
            prop_assert!(acceleration.amax() <= a * (1.0 + 1e-9) + 1e-14 / (dt * dt), "{acceleration}");
            prop_assert!(jerk.amax() <= j * (1.0 + 1e-9) + 1e-14 / (dt * dt * dt), "{jerk}");
            for (nearest, point) in nearest.iter_mut().zip(&points) {
                *nearest = nearest.min((q[0] - point).amax());
            }
        }
        prop_assert!(nearest.iter().all(|off| *off <= deviation + v * dt), "{nearest:?}");
        prop_assert_eq!(motion.at(motion.duration()), points[points.len() - 1]);
        prop_assert_eq!(motion.at(0.0), points[0]);
    }

    #[test]
    fn a_tool_keeps_its_limits_and_passes_every_pose(poses in poses(), jerk in prop::sample::select(vec![20.0, f64::INFINITY])) {
        let (translation, rotation) = (
            JerkLimits { velocity: 0.5, acceleration: 2.0, jerk },
            JerkLimits { velocity: 1.0, acceleration: 3.0, jerk },
        );
        let limits = SmoothToolLimits { translation, rotation };
        let motion = ViaPoses::new(&poses, limits, PoseDeviation { distance: 0.02, angle: 0.05 }).unwrap();
        let n = 4000;
        let dt = motion.duration() / f64::from(n);
        let mut nearest = vec![(f64::INFINITY, f64::INFINITY); poses.len()];
        for i in -2..n + 3 {
            let [a, b, c] = [-1, 0, 1].map(|k| motion.at(f64::from(i + k) * dt));
            let v = (b.translation.vector - a.translation.vector) / dt;
            let dv = (c.translation.vector - b.translation.vector) / dt - v;
            // In the world's axes; differences of the angular velocity over a step are those of the acceleration to the
            // second order of the step.
            let w = (b.rotation * a.rotation.inverse()).scaled_axis() / dt;
            let dw = (c.rotation * b.rotation.inverse()).scaled_axis() / dt - w;
            prop_assert!(v.norm() <= 0.5 * (1.0 + 1e-9) && dv.norm() <= 2.0 * dt * (1.0 + 1e-9) + 1e-14 / dt);
            prop_assert!(w.norm() <= 1.0 + 1e-9, "{}", w.norm());
            prop_assert!(dw.norm() <= 3.0 * dt * (1.0 + 1e-3) + 1e-12 / dt, "{} > 3", dw.norm() / dt);
            for (nearest, pose) in nearest.iter_mut().zip(&poses) {
                nearest.0 = nearest.0.min((b.translation.vector - pose.translation.vector).norm());
                nearest.1 = nearest.1.min(b.rotation.angle_to(&pose.rotation));
            }
        }
        let near = |(p, r): &(f64, f64)| *p <= 0.02 + 0.5 * dt && *r <= 0.05 + dt;
        prop_assert!(nearest.iter().all(near), "{nearest:?}");
    }
}
