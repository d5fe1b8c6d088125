//! The redundancy of the robots with seven joints: given as a parameter of the pose, or kept along a path.

use mrroc::prelude::*;
use mrroc::random::Random;
use mrroc::robot::NoInverse;
use mrroc_robots::{Irp6, Irp6Track, Kinematics, Polycrank, Rnt, Seven, Six};
use nalgebra::{Translation3, Vector3};

use crate::support::engraving;

const SEED: u64 = 17;

fn error_between(x: &Pose, y: &Pose) -> f64 {
    let rotation =
        x.rotation.to_rotation_matrix().into_inner() - y.rotation.to_rotation_matrix().into_inner();
    rotation.amax().max((x.translation.vector - y.translation.vector).amax())
}

fn bent() -> Seven {
    Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2])
}

fn on_track() -> Seven {
    let arm = engraving();
    Seven::from_fn(|i, _| if i == 0 { 0.5 } else { arm[i - 1] })
}

/// Follows a circle from `start` while the tool keeps its orientation; returns the last joints. `radius`: from the start to
/// the centre \[m\].
fn circle<R: Kinematics<7>>(robot: &R, start: &Seven, radius: Vector3<f64>) -> Option<Seven> {
    let from = robot.forward(start);
    let beside = radius.cross(&Vector3::new(0.3, -0.5, 0.8)).normalize() * radius.norm();
    let mut near = *start;
    for k in 1..=1000 {
        let (s, c) = (f64::from(k) * std::f64::consts::TAU / 1000.0).sin_cos();
        let p = from.translation.vector + radius * (1.0 - c) + beside * s;
        let q = robot.inverse(&Pose::from_parts(Translation3::from(p), from.rotation), &near).ok()?;
        assert!((q - near).amax() < 0.1, "{}: a jump from {near} to {q}", R::KIND);
        near = q;
    }
    Some(near)
}

#[test]
fn a_closed_circle_closes_in_the_joints() {
    let radius = Vector3::new(-0.04, 0.02, -0.02);
    for (name, start, end) in [
        ("polycrank", bent(), circle(&Polycrank::new(), &bent(), radius)),
        ("irp6-track", on_track(), circle(&Irp6Track::nominal(), &on_track(), radius)),
    ] {
        let off = (end.expect("within reach") - start).amax();
        println!("{name}: after a closed circle the joints are off by {off:.1e}");
        assert!(off < 1e-9, "{name}: {off}");
    }
}

/// From random joints with bent arms and the tool away from the vertical, circles of 4 cm across: the arms stay bent.
#[test]
fn random_circles_close_in_polycrank_s_joints() {
    let (robot, mut random) = (Polycrank::new(), Random::seeded(SEED));
    let (mut closed, mut worst) = (0, 0.0_f64);
    for _ in 0..200 {
        let mut side = || if random.between(-1.0, 1.0) > 0.0 { 1.0 } else { -1.0 };
        let (second, fifth) = (side(), side());
        let mut q = Seven::from_fn(|_, _| random.between(-3.0, 3.0));
        q[1] = second * random.between(1.1, 2.0);
        q[4] = fifth * random.between(1.1, 2.0);
        q[5] = random.between(0.8, 2.3) - q[3] - q[4];
        let radius = Vector3::from_fn(|_, _| random.between(-1.0, 1.0)).normalize() * 0.02;
        let end = circle(&robot, &q, radius).expect("bent arms reach 4 cm farther");
        let off = (end - q).amax();
        worst = worst.max(off);
        closed += u32::from(off < 1e-9);
    }
    println!("{closed} of 200 circles closed to 1e-9, the worst to {worst:.1e}, seed {SEED}");
    assert!(closed == 200, "{closed}");
}

/// The same pose at other values of the redundancy: other joints, one pose; the value is the one asked for.
fn other_values<R: Kinematics<7>>(robot: &R, start: &Seven, value: impl Fn(&Seven) -> f64) {
    let pose = robot.forward(start);
    let own = robot.inverse_at(&pose, value(start), start).expect("its own value");
    assert!((own - start).amax() < 1e-12, "{own}");
    for off in [-0.05, -0.01, 0.01, 0.03] {
        let q = robot.inverse_at(&pose, value(start) + off, start).expect("within reach");
        assert!((value(&q) - value(start) - off).abs() < 1e-12);
        assert!(error_between(&robot.forward(&q), &pose) < 1e-12);
        assert!((q - start).amax() > 0.5 * f64::abs(off));
    }
}

#[test]
fn the_redundancy_s_value_changes_the_joints_and_not_the_pose() {
    let base = Pose::new(Vector3::new(0.3, -2.1, 0.95), Vector3::new(0.1, -0.4, 2.0));
    other_values(&Polycrank::new().with_base(base), &bent(), Polycrank::stretch);
    other_values(&Irp6Track::nominal().with_base(base), &on_track(), |q| q[0]);
}

#[test]
fn a_value_out_of_reach_is_refused_with_its_distance() {
    let robot = Polycrank::new();
    let pose = robot.forward(&bent());
    // The level-axis arm reaches 0.302 m; v is what its joints give.
    let v = 0.151 * (bent()[3].sin() + (bent()[3] + bent()[4]).sin());
    let why = robot.inverse_at(&pose, 0.29, &bent()).expect_err("too far");
    let NoInverse::OutOfReach { distance, min, max } = why else { panic!("{why}") };
    assert!((distance - f64::hypot(0.29, v)).abs() < 1e-12 && min == 0.0 && max == 0.302, "{why}");
    assert!(matches!(robot.inverse_at(&pose, f64::NAN, &bent()), Err(NoInverse::OutOfReach { .. })));
    // The carriage so far away that the arm's wrist lies 1.3 m or more from the shoulder.
    let track = Irp6Track::nominal();
    let why = track.inverse_at(&track.forward(&on_track()), 1.6, &on_track()).expect_err("too far");
    assert!(
        matches!(why, NoInverse::OutOfReach { distance, max, .. } if distance > max && max == 1.125),
        "{why}"
    );
}

#[test]
fn robots_without_redundancy_say_so() {
    let pose = Irp6::nominal().forward(&engraving());
    assert_eq!(Irp6::nominal().inverse_at(&pose, 0.0, &engraving()), Err(NoInverse::NotRedundant));
    assert_eq!(Rnt::new().inverse_at(&pose, 0.0, &Six::zeros()), Err(NoInverse::NotRedundant));
}
