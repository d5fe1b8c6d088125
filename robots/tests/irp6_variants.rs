//! What the IRp-6 with five joints and the IRp-6 on its track do where they differ from the six-joint arm.

use mrroc::prelude::*;
use mrroc::random::Random;
use mrroc::robot::NoInverse;
use mrroc_robots::{Five, Irp6, Irp6FiveDof, Irp6Track, Kinematics, Seven};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::support::engraving;

const SEED: u64 = 9;

fn on_track(track: f64) -> Seven {
    let arm = engraving();
    Seven::from_fn(|i, _| if i == 0 { track } else { arm[i - 1] })
}

#[test]
fn the_track_stays_where_near_has_it_and_adds_to_y() {
    let (robot, arm) = (Irp6Track::nominal(), Irp6::nominal());
    let q = on_track(0.4);
    let pose = robot.forward(&q);
    let expected = Translation3::new(0.0, 0.4, 0.0) * arm.forward(&engraving());
    assert!((pose.translation.vector - expected.translation.vector).amax() < 1e-15);
    for track in [0.3, 0.4, 0.55] {
        let found = robot.inverse(&pose, &on_track(track)).expect("reachable");
        assert_eq!(found[0], track);
        assert_eq!(robot.inverse_at(&pose, track, &q), Ok(found));
    }
}

/// The arm at 0.1 m cannot reach 1 m along the track with a straight-down tool 0.85 m in front.
#[test]
fn the_track_moves_the_least_that_reaches() {
    let robot = Irp6Track::nominal();
    let pose = robot.forward(&on_track(1.1));
    let near = on_track(0.0);
    assert!(matches!(robot.inverse_at(&pose, 0.0, &near), Err(NoInverse::OutOfReach { .. })));
    let found = robot.inverse(&pose, &near).expect("the track reaches to 1.1 m");
    let error = robot.forward(&found).translation.vector - pose.translation.vector;
    assert!(error.amax() < 1e-9, "{error}");
    assert!(found[0] > 0.0 && found[0] < 1.1);
    assert!(robot.inverse_at(&pose, found[0] - 1e-6, &near).is_err(), "{found}");
    let mut far = pose;
    far.translation.vector.y = 3.0;
    assert!(matches!(robot.inverse(&far, &near), Err(NoInverse::OutOfReach { .. })));
}

#[test]
fn a_tool_that_leans_out_of_the_plane_of_the_arm_is_refused_and_made_upright() {
    let robot = Irp6FiveDof::nominal();
    let mut random = Random::seeded(SEED);
    for _ in 0..1000 {
        let q = Five::new(0.3, -1.6, 0.1, 0.2, 1.0) + Five::from_fn(|_, _| random.between(-0.3, 0.3));
        let pose = robot.forward(&q);
        let angle = random.between(0.01, 0.5);
        let along = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), q[0]) * Vector3::x();
        let up = pose.rotation * Vector3::z();
        // Turned about an axis of the arm's plane that is perpendicular to the tool.
        let hinge = nalgebra::Unit::new_normalize(up.cross(&along.cross(&Vector3::z())));
        let leaning = Pose::from_parts(
            pose.translation,
            UnitQuaternion::from_axis_angle(&hinge, angle) * pose.rotation,
        );
        let refused = robot.inverse(&leaning, &q);
        let Err(NoInverse::NotAttainable { actual, tolerance, unit: "rad", .. }) = refused else {
            panic!("seed {SEED}: {refused:?}");
        };
        assert!(actual > tolerance && (actual - angle).abs() < 1e-9, "seed {SEED}: {actual} {angle}");
        let upright = robot.upright(&leaning).expect("it can be straightened");
        let found = robot.inverse(&upright, &q).expect("attainable");
        assert!((found - q).amax() < 1e-9, "seed {SEED}: {q} {found}");
    }
}

#[test]
fn poses_have_eight_solutions_with_six_joints_and_four_with_five() {
    let robot = Irp6::nominal();
    let (mut six, mut five) = (0, 0);
    let pose = robot.forward(&engraving());
    robot.solutions(&pose, &engraving(), &mut |_| six += 1).expect("reachable");
    assert_eq!(six, 8);
    let robot = Irp6FiveDof::nominal();
    let q = Five::new(0.3, -1.6, 0.1, 0.2, 1.0);
    robot.solutions(&robot.forward(&q), &q, &mut |_| five += 1).expect("reachable");
    assert_eq!(five, 4);
}

#[test]
fn a_goal_is_chosen_within_the_limits_where_the_nearest_turn_is_not() {
    let robot = Irp6::nominal();
    let mut q = engraving();
    q[5] = -2.8;
    let pose = robot.forward(&q);
    let mut near = q;
    near[5] = 2.9;
    let continued = robot.inverse(&pose, &near).expect("reachable");
    assert!((continued[5] - (std::f64::consts::TAU - 2.8)).abs() < 1e-9, "{continued}");
    let goal = robot.nearest_attainable(&pose, &near).expect("reachable").expect("attainable");
    assert!((goal - q).amax() < 1e-9, "{goal}");
}

/// The facts' own figures, which are a rotation to 2e-7 only; here they are one to round-off.
#[test]
fn the_pair_of_arms_stands_two_metres_apart() {
    let base = Irp6Track::postument();
    let row = base.rotation.to_rotation_matrix().into_inner().row(1).into_owned();
    let published = [-0.032_112_349_151_151, 0.999_483_874_031_384, 0.000_884_637_222_621];
    for (found, expected) in row.iter().zip(published) {
        assert!((found - expected).abs() < 2e-7, "{found} {expected}");
    }
    assert!((base.rotation.norm() - 1.0).abs() < 1e-15);
    let arm = Irp6::calibrated().with_base(base);
    let at_rest = arm.forward(&engraving());
    assert!((at_rest.translation.vector.y - 2.1063).abs() < 0.1);
}
