//! Arms whose URDF rounds its right angles: the closed form of the nearest exact geometry, corrected.
//!
//! Expected values: the arm's own forward kinematics, and the solutions of the same arm with exact right angles.

use core::f64::consts::TAU;

use mrroc::prelude::*;
use mrroc::random::Random;
use mrroc_counting_allocator::count;
use mrroc_robots::{Kinematics, Serial};
use nalgebra::{SVector, Translation3, UnitQuaternion, Vector3};

const SEED: u64 = 15_707_963;
const POSES: usize = 5_000;
/// How the files of the field write a right angle, and by how much they are off.
const RIGHT_ANGLES: [(&str, f64); 4] =
    [("1.570796327", 2.1e-10), ("1.5707963", 2.7e-8), ("1.570796", 3.3e-7), ("1.5708", 3.7e-6)];

fn arm<const N: usize>(text: &str, right_angle: &str, base: &str, tip: &str) -> Serial<N> {
    let text = text.replace("1.5707963267948966", right_angle);
    Serial::from_urdf(&text, base, tip)
        .and_then(|robot| robot.with_acceleration(SVector::repeat(10.0)))
        .expect("the URDF is sound")
}

const EXACT: &str = "1.5707963267948966";

fn ur(right_angle: &str) -> Serial<6> {
    arm(include_str!("reference/urdf/three_parallel.urdf"), right_angle, "base", "wrist_3")
}

/// Its fourth axis is off by this.
fn industrial(rounding: f64) -> Serial<6> {
    let text = include_str!("reference/urdf/ortho_parallel.urdf");
    let turned = format!("xyz=\"0.455 0 0\" rpy=\"0 0 {rounding}\"");
    arm(&text.replace("xyz=\"0.455 0 0\"", &turned), EXACT, "base_link", "tool0")
}

fn iiwa(right_angle: &str) -> Serial<7> {
    arm(include_str!("reference/urdf/seven_axes.urdf"), right_angle, "world_foot", "flange")
}

fn positions<const N: usize>(robot: &Serial<N>, random: &mut Random) -> SVector<f64, N> {
    let limits = robot.limits();
    SVector::<f64, N>::from_fn(|i, _| random.between(limits.lower[i], limits.upper[i]))
}

fn near<const N: usize>(q: &SVector<f64, N>, distance: f64, random: &mut Random) -> SVector<f64, N> {
    SVector::<f64, N>::from_fn(|i, _| q[i] + random.between(-distance, distance))
}

fn error_between(x: &Pose, y: &Pose) -> f64 {
    let rotation =
        x.rotation.to_rotation_matrix().into_inner() - y.rotation.to_rotation_matrix().into_inner();
    rotation.amax().max((x.translation.vector - y.translation.vector).amax())
}

/// Full turns left out of account.
fn apart<const N: usize>(a: &SVector<f64, N>, b: &SVector<f64, N>) -> f64 {
    (a - b).map(|d: f64| d - TAU * (d / TAU).round()).amax()
}

/// Every pose comes back to 1e-9, from seeds near and far; from a near seed, away from singularities, on the seed's branch.
fn gives_back_every_pose<const N: usize>(name: &str, robot: &Serial<N>, rounding: f64) {
    assert!(robot.is_closed_form(), "{name}");
    let mut random = Random::seeded(SEED);
    let (mut worst, mut joints, mut lost) = (0.0_f64, 0.0_f64, 0);
    for i in 0..POSES {
        let q = positions(robot, &mut random);
        let pose = robot.forward(&q);
        let is_near = i % 2 == 0;
        let seed = near(&q, if is_near { 1e-3 } else { 3.0 }, &mut random);
        let found = match robot.inverse(&pose, &seed) {
            Ok(found) => found,
            // Stretched so far that the exact arm cannot follow, it is sought by iteration, which a far seed may mislead.
            Err(_) if !is_near && robot.near_singularity(&q).is_some() => {
                lost += 1;
                continue;
            }
            Err(why) => panic!("{name}, seed {SEED}: {q}: {why}"),
        };
        worst = worst.max(error_between(&robot.forward(&found), &pose));
        if is_near && robot.near_singularity(&q).is_none() {
            assert!((found - q).amax() < 0.05, "{name}, seed {SEED}: {q} {found}");
            // Seven joints keep the arm angle of the seed, not that of `q`.
            if N == 6 {
                joints = joints.max((found - q).amax());
            }
        }
    }
    println!(
        "{name}, off by {rounding:.0e}: {POSES} poses, {lost} not found, pose error {worst:.1e}, joint error {joints:.1e}"
    );
    assert!(lost <= POSES / 1000, "{name}: {lost}");
    assert!(worst < 1e-9, "{name}: {worst}");
    assert!(joints < 1e-9, "{name}: {joints}");
}

#[test]
fn arms_with_rounded_right_angles_give_back_every_pose() {
    for (digits, rounding) in RIGHT_ANGLES {
        gives_back_every_pose("three parallel axes", &ur(digits), rounding);
        gives_back_every_pose("ortho-parallel", &industrial(rounding), rounding);
        gives_back_every_pose("seven axes", &iiwa(digits), rounding);
        let base = Pose::new(Vector3::new(0.3, -2.1, 0.95), Vector3::new(0.1, -0.4, 2.0));
        gives_back_every_pose("on a base", &ur(digits).with_base(base), rounding);
    }
}

/// As many solutions as the exact arm has at the same joints, each beside one of those, and each of this arm's own pose.
fn keeps_its_branches<const N: usize>(rounded: &Serial<N>, exact: &Serial<N>, rounding: f64) {
    let mut random = Random::seeded(SEED);
    let mut most = 0;
    for _ in 0..300 {
        let q = positions(rounded, &mut random);
        let far = |robot: &Serial<N>| robot.near_singularity(&q).is_none();
        if !far(rounded) || !far(exact) {
            continue;
        }
        let all = |robot: &Serial<N>| {
            let mut all = Vec::new();
            robot.solutions(&robot.forward(&q), &q, &mut |q| all.push(*q)).expect("its own pose");
            all
        };
        let (ours, theirs) = (all(rounded), all(exact));
        // A branch whose elbow is nearly stretched is far from its neighbour, or is one of the two only.
        let bent = |q: &SVector<f64, N>| exact.near_singularity(q).is_none();
        if !theirs.iter().all(bent) {
            continue;
        }
        assert_eq!(ours.len(), theirs.len(), "seed {SEED}: {q}");
        for solution in &ours {
            assert!(error_between(&rounded.forward(solution), &rounded.forward(&q)) < 1e-9, "{q}");
            let off = theirs.iter().map(|other| apart(other, solution)).fold(f64::INFINITY, f64::min);
            assert!(off < 1e4 * rounding, "seed {SEED}: {q}: {off}");
        }
        most = most.max(ours.len());
    }
    assert_eq!(most, if N == 6 { 8 } else { 16 });
}

#[test]
fn arms_with_rounded_right_angles_keep_all_branches() {
    for (digits, rounding) in RIGHT_ANGLES {
        keeps_its_branches(&ur(digits), &ur(EXACT), rounding);
        keeps_its_branches(&industrial(rounding), &industrial(0.0), rounding);
        keeps_its_branches(&iiwa(digits), &iiwa(EXACT), rounding);
    }
}

/// The arm angle does not drift: after 20 rounds of a circle the joints are where they were.
#[test]
fn a_closed_path_of_seven_rounded_axes_closes_in_the_joints() {
    let robot = iiwa("1.5708");
    let start = SVector::from([0.8, 0.5, 0.2, 1.1, 0.3, -0.6, 0.2]);
    let from = robot.forward(&start);
    let psi = robot.arm_angle(&start).expect("it has one");
    let mut q = start;
    for k in 1..=20_000 {
        let (s, c) = (f64::from(k) * TAU / 1000.0).sin_cos();
        let p = from.translation.vector + Vector3::new(0.03 * (1.0 - c), 0.05 * s, 0.02 * s);
        let tilt = UnitQuaternion::from_scaled_axis(Vector3::new(0.02, 0.05, -0.03) * s);
        let pose = Pose::from_parts(Translation3::from(p), tilt * from.rotation);
        let next = robot.inverse(&pose, &q).expect("within reach");
        assert!((next - q).amax() < 0.01 && error_between(&robot.forward(&next), &pose) < 1e-9);
        q = next;
    }
    println!("after 20 rounds: joints off by {:.1e}", (q - start).amax());
    assert!((q - start).amax() < 1e-8, "{q}");
    let found = robot.inverse_at(&robot.forward(&q), psi + 0.3, &q).expect("another arm angle");
    assert!((robot.arm_angle(&found).expect("it has one") - psi - 0.3).abs() < 1e-6);
    assert!(error_between(&robot.forward(&found), &robot.forward(&q)) < 1e-9);
}

#[test]
fn a_pose_that_is_out_of_reach_is_refused_with_its_distance_and_at_once() {
    let robot = ur("1.5708");
    let q = SVector::from([0.3, -1.2, 1.4, -0.4, 0.9, -0.5]);
    let mut pose = robot.forward(&q);
    pose.translation.vector.x += 1.5;
    let why = robot.inverse(&pose, &q).expect_err("too far");
    assert!(why.to_string().contains("out of reach"), "{why}");
    // What is off by more than rounding is no arm of the family: it is moved as it is written, by iteration.
    assert!(!ur("1.58").is_closed_form());
}

#[test]
fn the_correction_allocates_nothing() {
    let (six, seven) = (ur("1.5708"), iiwa("1.5708"));
    let (a, b) = (SVector::from([0.3, -1.2, 1.4, -0.4, 0.9, -0.5]), SVector::repeat(0.4));
    let poses = (six.forward(&a), seven.forward(&b));
    let (both, allocated) =
        count(|| six.inverse(&poses.0, &a).is_ok() && seven.inverse(&poses.1, &b).is_ok());
    assert!(both);
    assert_eq!(allocated, 0);
}
