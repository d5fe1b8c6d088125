//! The book's example: a URDF arm of one's own, from a tracker to `cell.toml`; and what choosing postures saves.

use mrroc::pose::Pose;
use mrroc::robot::Robot;
use mrroc_calibration::InHand;
use mrroc_launch::cell_file::CellFile;
use mrroc_robots::{ArmCalibration, Serial, simulated};
use nalgebra::{SVector, Vector3};

#[path = "../examples/own_arm.rs"]
mod example;

use example::{Truth, calibrated, postures};

fn folder() -> String {
    format!("{}/../../robots/tests/reference/urdf", env!("CARGO_MANIFEST_DIR"))
}

fn nominal() -> Serial<6> {
    let path = format!("{}/three_parallel.urdf", folder());
    let arm = Serial::<6>::from_urdf_file(path, "base", "wrist_3").expect("a URDF");
    arm.with_acceleration(SVector::repeat(10.0)).expect("limits")
}

/// Root of the mean square of how far the flange is from the truth at postures that were not measured \[m\]: what a base on the table of the tracker takes up is a rigid
/// motion of all of them, so that distances of two postures are compared.
fn error(text: &str) -> f64 {
    let Ok(ArmCalibration::Chain(found)) = ArmCalibration::parse(text) else { panic!("{text}") };
    let arm = nominal().calibrated_by(&found).expect("its own");
    between(&arm)
}

fn between(arm: &Serial<6>) -> f64 {
    let truth = Truth::new().expect("a URDF");
    let unseen = postures(260).split_off(200);
    let place = |q: &Vec<f64>| {
        let own = arm.forward(&SVector::from_column_slice(q));
        (own.translation.vector, truth.flange(q).translation.vector)
    };
    let places: Vec<_> = unseen.iter().map(place).collect();
    let pairs = places.iter().zip(places.iter().skip(1));
    let squares: f64 =
        pairs.map(|((a, own_a), (b, own_b))| ((a - b).norm() - (own_a - own_b).norm()).powi(2)).sum();
    (squares / (places.len() - 1) as f64).sqrt()
}

#[test]
fn an_arm_of_ones_own_is_calibrated_for_its_cell() {
    let truth = Truth::new().expect("a URDF");
    let text = calibrated(&postures(200), 20, |q, ball| truth.ball(q, ball)).expect("a fit");
    let (before, after) = (between(&nominal()), error(&text));
    assert!(before > 3e-4 && after < 3e-5, "{before} -> {after}");
    let out = std::env::temp_dir().join(format!("mrroc-own-arm-{}.toml", std::process::id()));
    std::fs::write(&out, &text).expect("written");
    let cell = format!(
        "step_ms = 2\nstop_ms = 3000\n[robots.arm]\nkind = \"urdf\"\nfile = \"three_parallel.urdf\"\ntip = \"wrist_3\"\n\
         acceleration = [10.0, 10.0, 10.0, 10.0, 10.0, 10.0]\nstart = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]\ncalibration = {out:?}\n"
    );
    let file = CellFile::parse(&format!("{}/cell.toml", folder()), &cell).expect("well-formed");
    let made = file.cell(&simulated()).map(|_| ()).map_err(|why| why.to_string());
    std::fs::remove_file(out).expect("removed");
    assert_eq!(made, Ok(()));
}

/// What `calibrate eye-to-hand` writes is copied into `cell.toml` as it is.
#[test]
fn a_camera_beside_the_arm_is_a_frame_of_its_cell() {
    let frame = Pose::new(Vector3::new(1.2, -0.3, 0.8), Vector3::new(0.4, -2.1, 0.7));
    let (unseen, unsure, poses) = (Vec::new(), Vec::new(), Vec::new());
    let found = InHand { frame, sigma: vec![1e-4; 6], left: [0.0; 2], pixels: None, unseen, unsure, poses };
    let text = found.base_text("camera", "2026-11-24");
    let cell = format!(
        "step_ms = 2\nstop_ms = 3000\n[robots.arm]\nkind = \"urdf\"\nfile = \"three_parallel.urdf\"\ntip = \"wrist_3\"\n\
         acceleration = [10.0, 10.0, 10.0, 10.0, 10.0, 10.0]\nstart = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]\n\n{text}"
    );
    let file = CellFile::parse(&format!("{}/cell.toml", folder()), &cell).expect("well-formed");
    assert!(file.cell(&simulated()).is_ok());
    let numbers = |key: &str| -> Vec<f64> {
        let line = text.lines().find_map(|line| line.strip_prefix(&format!("{key} = ["))).expect("a key");
        line.trim_end_matches(']').split(", ").map(|number| number.parse().expect("a number")).collect()
    };
    let (p, q) = (numbers("xyz"), numbers("quat_xyzw"));
    let turn = |r: [f64; 3]| Pose::rotation(Vector3::from(r));
    let place = Pose::translation(p[0], p[1], p[2]);
    let quaternion = nalgebra::Quaternion::new(q[3], q[0], q[1], q[2]);
    let read = place * nalgebra::UnitQuaternion::from_quaternion(quaternion);
    assert!((read.to_homogeneous() - frame.to_homogeneous()).amax() < 1e-12);
    // The same in the comment: turns about the fixed axes x, y and z.
    let (_, comment) = text.split_once("rpy = [").expect("the angles");
    let rpy: Vec<f64> = comment
        .split(']')
        .next()
        .into_iter()
        .flat_map(|list| list.split(", "))
        .map(|number| number.parse().expect("a number"))
        .collect();
    let read = place * turn([0.0, 0.0, rpy[2]]) * turn([0.0, rpy[1], 0.0]) * turn([rpy[0], 0.0, 0.0]);
    assert!((read.to_homogeneous() - frame.to_homogeneous()).amax() < 1e-12);
}
