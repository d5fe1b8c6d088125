//! Arms read from URDF in closed form beside the ortho-parallel ones: three parallel axes, and seven axes with a spherical
//! shoulder and a spherical wrist.

use core::f64::consts::{PI, TAU};

use mrroc::prelude::*;
use mrroc::random::Random;
use mrroc::robot::NoInverse;
use mrroc_robots::{Kinematics, Serial};
use nalgebra::{SVector, Translation3, UnitQuaternion, Vector3};

const SEED: u64 = 20_131_207;

/// Poses per robot, as many in every build. Of 100,000 with this seed one is not given back (SAFETY.md, known exceptions).
const POSES: usize = 10_000;

type Six = SVector<f64, 6>;
type Seven = SVector<f64, 7>;

fn arm<const N: usize>(arm: &str, base: &str, tip: &str) -> Serial<N> {
    let path = format!("{}/tests/reference/urdf/{arm}.urdf", env!("CARGO_MANIFEST_DIR"));
    Serial::from_urdf_file(path, base, tip)
        .and_then(|robot| robot.with_acceleration(SVector::repeat(10.0)))
        .expect("the URDF is sound")
}

fn base() -> Pose {
    Pose::new(Vector3::new(0.3, -2.1, 0.95), Vector3::new(0.1, -0.4, 2.0))
}

fn three_parallel_arms() -> [Serial<6>; 3] {
    let straight = arm("three_parallel", "base", "wrist_3");
    [straight.clone(), arm("three_parallel_beside", "foot", "tool"), straight.with_base(base())]
}

fn spherical_arms() -> [Serial<7>; 3] {
    let straight = arm("seven_axes", "world_foot", "flange");
    [straight.clone(), arm("offset_elbow", "foot", "tool"), straight.with_base(base())]
}

fn error_between(x: &Pose, y: &Pose) -> f64 {
    let rotation =
        x.rotation.to_rotation_matrix().into_inner() - y.rotation.to_rotation_matrix().into_inner();
    rotation.amax().max((x.translation.vector - y.translation.vector).amax())
}

fn positions<const N: usize>(robot: &Serial<N>, random: &mut Random) -> SVector<f64, N> {
    let limits = robot.limits();
    SVector::<f64, N>::from_fn(|i, _| random.between(limits.lower[i], limits.upper[i]))
}

fn near<const N: usize>(q: &SVector<f64, N>, distance: f64, random: &mut Random) -> SVector<f64, N> {
    SVector::<f64, N>::from_fn(|i, _| q[i] + random.between(-distance, distance))
}

/// Full turns left out of account.
fn apart<const N: usize>(a: &SVector<f64, N>, b: &SVector<f64, N>) -> f64 {
    (a - b).map(|d: f64| d - TAU * (d / TAU).round()).amax()
}

/// Expected values: `reference/urdf_solutions.py`, restarts of an iteration by Pinocchio. All solutions and no others.
fn all_that_restarts_find<const N: usize>(name: &str, robot: &Serial<N>, most: usize) {
    let (mut rows, mut seen, mut worst) = (0, 0, 0.0_f64);
    for line in include_str!("reference/urdf_solutions.csv").lines() {
        let Some(numbers) = line.strip_prefix(name).and_then(|rest| rest.strip_prefix(',')) else { continue };
        let numbers: Vec<f64> = numbers.split(',').map(|n| n.parse().expect("a number")).collect();
        let (head, joints) = numbers.split_at(2);
        let expected: Vec<SVector<f64, N>> =
            joints.chunks(N).skip(1).map(SVector::<f64, N>::from_column_slice).collect();
        assert_eq!(expected.len() as f64, head[1], "{name}");
        let q = SVector::<f64, N>::from_column_slice(&joints[..N]);
        if let Some(psi) = robot.arm_angle(&q) {
            assert!((psi - head[0]).abs() < 1e-9, "{name}: {psi} {}", head[0]);
        }
        let mut found = Vec::new();
        robot.solutions(&robot.forward(&q), &q, &mut |q| found.push(*q)).expect("its own pose");
        for solution in &found {
            let error = expected.iter().map(|q| apart(q, solution)).fold(f64::INFINITY, f64::min);
            worst = worst.max(error);
        }
        assert_eq!(found.len(), expected.len(), "{name}: {q}");
        rows += 1;
        seen = seen.max(found.len());
    }
    println!("{name}: {rows} poses, at most {seen} solutions, largest difference {worst:.1e}");
    assert_eq!((rows, seen), (10, most));
    assert!(worst < 1e-8, "{name}: {worst}");
}

#[test]
fn three_parallel_axes_have_the_solutions_that_restarts_find() {
    all_that_restarts_find("three_parallel", &three_parallel_arms()[0], 8);
    all_that_restarts_find("three_parallel_beside", &three_parallel_arms()[1], 8);
}

#[test]
fn seven_axes_have_the_solutions_at_an_arm_angle_that_restarts_find() {
    all_that_restarts_find("seven_axes", &spherical_arms()[0], 16);
    all_that_restarts_find("offset_elbow", &spherical_arms()[1], 16);
}

/// The pose comes back whatever the seed, every joint within half a turn of the seed.
fn gives_back_every_pose<const N: usize>(robot: &Serial<N>) {
    let mut random = Random::seeded(SEED);
    let mut worst = 0.0_f64;
    for i in 0..POSES {
        let q = positions(robot, &mut random);
        let pose = robot.forward(&q);
        let seed = near(&q, if i % 2 == 0 { 0.01 } else { 20.0 }, &mut random);
        let found = robot.inverse(&pose, &seed).expect("the pose comes from joints");
        worst = worst.max(error_between(&robot.forward(&found), &pose));
        assert!((found - seed).amax() <= PI + 1e-9, "seed {SEED}: {q} {seed}");
    }
    println!("seed {SEED}: {POSES} poses, pose error {worst:.1e}");
    assert!(worst < 1e-9, "seed {SEED}: {worst}");
}

/// `inverse` is the nearest of `solutions`, which give the pose and differ from each other.
fn nearest_of_all<const N: usize>(robot: &Serial<N>, most: usize) {
    let mut random = Random::seeded(SEED);
    let mut seen = 0;
    for i in 0..POSES / 10 {
        let q = positions(robot, &mut random);
        let pose = robot.forward(&q);
        let seed = near(&q, if i % 2 == 0 { 0.3 } else { 3.0 }, &mut random);
        let mut all: Vec<SVector<f64, N>> = Vec::new();
        robot.solutions(&pose, &seed, &mut |q| all.push(*q)).expect("the pose comes from joints");
        let nearest = robot.inverse(&pose, &seed).expect("the pose comes from joints");
        let least = all.iter().map(|q| (q - seed).norm()).fold(f64::INFINITY, f64::min);
        assert!(((nearest - seed).norm() - least).abs() < 1e-12, "seed {SEED}: {q} {seed}");
        for (i, solution) in all.iter().enumerate() {
            assert!(error_between(&robot.forward(solution), &pose) < 1e-9, "seed {SEED}: {q}");
            assert!((solution - seed).amax() <= PI + 1e-9);
            assert!(all[..i].iter().all(|other| (other - solution).amax() > 1e-6), "seed {SEED}: {q}");
        }
        seen = seen.max(all.len());
    }
    assert_eq!(seen, most);
}

#[test]
fn three_parallel_axes_give_back_every_pose_by_the_nearest_solution() {
    for robot in three_parallel_arms() {
        gives_back_every_pose(&robot);
        nearest_of_all(&robot, 8);
    }
}

#[test]
fn seven_axes_give_back_every_pose_by_the_nearest_solution() {
    for robot in spherical_arms() {
        gives_back_every_pose(&robot);
        nearest_of_all(&robot, 16);
    }
}

/// With axes 4 and 6 parallel, joint 6 stays; with C on axis 1 joint 1 would, but b keeps C off it.
#[test]
fn joint_6_of_three_parallel_axes_stays_where_it_is_undetermined() {
    let robot = &three_parallel_arms()[0];
    let q = Six::from([0.3, -1.2, 1.4, -0.4, 0.0, -0.5]);
    let seed = q + Six::from([0.01, 0.02, 0.0, 0.05, 0.01, 0.03]);
    let found = robot.inverse(&robot.forward(&q), &seed).expect("reachable");
    assert!((found[5] - seed[5]).abs() < 1e-12 && (found[0] - q[0]).abs() < 1e-12, "{found}");
    assert!(error_between(&robot.forward(&found), &robot.forward(&q)) < 1e-12);
    assert_eq!(robot.near_singularity(&q), Some("near the wrist singularity"));
    assert_eq!(
        robot.near_singularity(&Six::from([0.3, -1.2, 0.01, -0.4, 0.9, 0.0])),
        Some("near the elbow singularity")
    );
}

/// All joints at 0, the arm of seven axes stands upright: shoulder, elbow and wrist are singular, and the arm angle is not
/// determined. From seeds nearby it stays there, and from there it goes in any direction.
#[test]
fn seven_axes_leave_the_upright_posture() {
    let robot = &spherical_arms()[0];
    let up = robot.forward(&Seven::zeros());
    let found = robot.inverse(&up, &Seven::repeat(0.02)).expect("its own pose");
    assert!(
        error_between(&robot.forward(&found), &up) < 1e-12 && (found - Seven::repeat(0.02)).amax() < 0.1,
        "{found}"
    );
    for direction in [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::z(), Vector3::new(-0.3, 0.7, -0.6)]
    {
        let mut q = Seven::zeros();
        for k in 1..=1000 {
            let pose = Pose::from_parts(
                Translation3::from(
                    up.translation.vector - Vector3::z() * 1e-4 * f64::from(k)
                        + direction * 2e-4 * f64::from(k),
                ),
                up.rotation * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 5e-4 * f64::from(k)),
            );
            match robot.inverse(&pose, &q) {
                Ok(next) => {
                    assert!(error_between(&robot.forward(&next), &pose) < 1e-9, "{direction}: {next}");
                    q = next;
                }
                Err(NoInverse::OutOfReach { distance, max, .. }) => assert!(distance > max),
                Err(why) => panic!("{why}"),
            }
        }
    }
}

/// A closed path of the flange is a closed path of the joints, because the arm angle is kept.
#[test]
fn closed_circles_close_in_the_joints_of_seven_axes() {
    for robot in spherical_arms() {
        let mut random = Random::seeded(SEED);
        let mut circles = 0;
        while circles < 50 {
            let start = positions(&robot, &mut random);
            if robot.near_singularity(&start).is_some() {
                continue;
            }
            let from = robot.forward(&start);
            let radius = Vector3::from_fn(|_, _| random.between(-1.0, 1.0)).normalize() * 0.02;
            let beside = radius.cross(&Vector3::new(0.3, -0.5, 0.8)).normalize() * 0.02;
            let mut q = start;
            let mut within = true;
            for k in 1..=500 {
                let (s, c) = (f64::from(k) * TAU / 500.0).sin_cos();
                let p = from.translation.vector + radius * (1.0 - c) + beside * s;
                let tilt = UnitQuaternion::from_scaled_axis(Vector3::new(0.02, 0.05, -0.03) * s);
                let Ok(next) =
                    robot.inverse(&Pose::from_parts(Translation3::from(p), tilt * from.rotation), &q)
                else {
                    within = false;
                    break;
                };
                if robot.near_singularity(&next).is_some() {
                    within = false;
                    break;
                }
                assert!((next - q).amax() < 0.1, "seed {SEED}: {q} {next}");
                q = next;
            }
            if within {
                assert!((q - start).amax() < 1e-9, "seed {SEED}: {start} {q}");
                circles += 1;
            }
        }
    }
}

/// `inverse_at` puts axis 4 at the arm angle asked for: one pose, other joints, and the elbow goes round on its circle.
#[test]
fn the_arm_angle_is_the_redundancy_of_seven_axes() {
    for robot in spherical_arms() {
        let mut random = Random::seeded(SEED);
        for _ in 0..200 {
            let q = positions(&robot, &mut random);
            let pose = robot.forward(&q);
            let own = robot.arm_angle(&q).expect("it has one");
            for psi in [own, own + 0.02, own - 0.7, own + PI, -3.0, 0.0] {
                let found = robot.inverse_at(&pose, psi, &q).expect("any arm angle is reachable");
                assert!(error_between(&robot.forward(&found), &pose) < 1e-9);
                let off = robot.arm_angle(&found).expect("it has one") - psi;
                assert!((off - TAU * (off / TAU).round()).abs() < 1e-7, "seed {SEED}: {q} {psi}");
            }
        }
        let q = positions(&robot, &mut random);
        assert!(robot.inverse_at(&robot.forward(&q), f64::NAN, &q).is_err());
    }
    let six = &three_parallel_arms()[0];
    assert_eq!(six.arm_angle(&Six::zeros()), None);
    let pose = six.forward(&Six::repeat(0.3));
    assert_eq!(six.inverse_at(&pose, 0.0, &Six::repeat(0.3)), Err(NoInverse::NotRedundant));
}

/// At arm angle 0 or pi the elbow lies in the plane through axis 1 and the wrist: here with joint 3 at 0, as it is built.
#[test]
fn with_joint_3_at_0_the_arm_angle_is_0() {
    let robot = &spherical_arms()[0];
    let q = Seven::from([0.8, 0.5, 0.0, 1.1, 0.3, -0.6, 0.2]);
    let psi = robot.arm_angle(&q).expect("it has one");
    assert!((psi.abs() - PI).abs() < 1e-12 || psi.abs() < 1e-12, "{psi}");
}

/// The distance that the message gives is that of axis 4 from axis 2, or of the wrist from the shoulder.
#[test]
fn what_cannot_be_reached_is_refused_with_the_distance() {
    let robot = &three_parallel_arms()[0];
    let q = Six::from([0.3, -1.2, 1.4, -0.4, 0.9, -0.5]);
    let mut pose = robot.forward(&q);
    pose.translation.vector.x += 1.5;
    let why = robot.inverse(&pose, &q).expect_err("too far");
    let NoInverse::OutOfReach { distance, max, min } = why else { panic!("{why}") };
    assert!((max - 0.81725).abs() < 1e-12 && (min - 0.03275).abs() < 1e-12 && distance > max, "{why}");
    assert!(robot.solutions(&pose, &q, &mut |_| panic!("it was visited")).is_err());
    // The wrist centre nearer to axis 1 than 0.10915 m.
    let q = Six::from([0.0, -1.2, 1.4, -0.4, 0.9, -0.5]);
    let mut pose = robot.forward(&q);
    let centre = pose * nalgebra::Point3::new(0.0, 0.0, -0.0823);
    pose.translation.vector -= Vector3::new(centre.x - 0.03, centre.y - 0.04, 0.0);
    let why = robot.inverse(&pose, &q).expect_err("too near");
    let NoInverse::OutOfReach { distance, min, .. } = why else { panic!("{why}") };
    assert!((distance - 0.05).abs() < 1e-12 && (min - 0.10915).abs() < 1e-12, "{why}");
    let robot = &spherical_arms()[0];
    let q = Seven::from([0.8, 0.5, 0.1, 1.1, 0.3, -0.6, 0.2]);
    let mut pose = robot.forward(&q);
    pose.translation.vector.z += 1.0;
    let why = robot.inverse(&pose, &q).expect_err("too far");
    let NoInverse::OutOfReach { distance, max, .. } = why else { panic!("{why}") };
    assert!((max - 0.82).abs() < 1e-12 && distance > max, "{why}");
    pose.translation.vector.z = f64::NAN;
    assert!(robot.inverse(&pose, &q).is_err());
    assert!(robot.solutions(&pose, &q, &mut |_| panic!("it was visited")).is_err());
}

/// The UR5e that `mrroc-new` gives a project: the product of `R_z(q) T_z(d) T_x(a) R_x(alpha)` by the parameters that Universal
/// Robots publishes.
#[test]
fn the_ur5e_of_the_template_has_the_poses_of_its_denavit_hartenberg_parameters() {
    let text = include_str!("../../template/sets/ur5e/ur5e.urdf");
    let robot = Serial::<6>::from_urdf(text, "base", "tool0")
        .and_then(|robot| robot.with_acceleration(SVector::repeat(10.0)))
        .expect("the URDF is sound");
    assert!(robot.is_closed_form());
    let rows = [
        (0.1625, 0.0, 0.5 * PI),
        (0.0, -0.425, 0.0),
        (0.0, -0.3922, 0.0),
        (0.1333, 0.0, 0.5 * PI),
        (0.0997, 0.0, -0.5 * PI),
        (0.0996, 0.0, 0.0),
    ];
    let mut random = Random::seeded(SEED);
    for _ in 0..1000 {
        let q = positions(&robot, &mut random);
        let expected = rows.iter().zip(&q).fold(Pose::identity(), |pose, ((d, a, alpha), q)| {
            let turn = Pose::rotation(Vector3::z() * *q);
            pose * turn * Pose::translation(*a, 0.0, *d) * Pose::rotation(Vector3::x() * *alpha)
        });
        assert!(error_between(&robot.forward(&q), &expected) < 1e-13, "{q}");
    }
}
