//! Poses and Jacobians of arms read from URDF against Pinocchio.

use mrroc::robot::Robot;
use mrroc_robots::{Kinematics, Serial};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Reads `tests/reference/urdf/<arm>.urdf` with accelerations of 10 rad/s² or m/s² throughout.
fn arm<const N: usize>(arm: &str, base: &str, tip: &str) -> Serial<N> {
    let path = format!("{}/tests/reference/urdf/{arm}.urdf", env!("CARGO_MANIFEST_DIR"));
    Serial::from_urdf_file(path, base, tip)
        .and_then(|robot| robot.with_acceleration(SVector::repeat(10.0)))
        .expect("the URDF is sound")
}

/// Largest differences of poses and Jacobians. Expected values: `reference/urdf_pinocchio.py` (Pinocchio 4.1).
fn agrees_with_pinocchio<const N: usize>(name: &str, base: &str, tip: &str) {
    let robot: Serial<N> = arm(name, base, tip);
    let (mut rows, mut worst) = (0, 0.0_f64);
    for line in include_str!("reference/urdf_poses.csv").lines() {
        let Some(numbers) = line.strip_prefix(name).and_then(|rest| rest.strip_prefix(',')) else { continue };
        let numbers: Vec<f64> = numbers.split(',').map(|n| n.parse().expect("a number")).collect();
        let (q, rest) = numbers.split_at(N);
        let q = SVector::<f64, N>::from_column_slice(q);
        let pose = robot.forward(&q);
        let position = pose.translation.vector - Vector3::from_column_slice(&rest[..3]);
        let rotation =
            pose.rotation.to_rotation_matrix().into_inner() - Matrix3::from_row_slice(&rest[3..12]);
        let jacobian = robot.jacobian(&q) - SMatrix::<f64, 6, N>::from_column_slice(&rest[12..]);
        worst = worst.max(position.amax()).max(rotation.amax()).max(jacobian.amax());
        rows += 1;
    }
    println!("{name}: {rows} poses, largest difference {worst:.1e}");
    assert_eq!(rows, 40);
    assert!(worst < 1e-12, "{name}: {worst}");
}

#[test]
fn an_ortho_parallel_arm_agrees_with_pinocchio() {
    agrees_with_pinocchio::<6>("ortho_parallel", "base_link", "tool0");
}

#[test]
fn an_arm_with_offsets_and_turned_axes_agrees_with_pinocchio() {
    agrees_with_pinocchio::<6>("offset_arm", "foot", "tool");
}

#[test]
fn an_arm_with_seven_joints_agrees_with_pinocchio() {
    agrees_with_pinocchio::<7>("seven_axes", "world_foot", "flange");
}

#[test]
fn a_scara_with_an_endless_spindle_and_a_lift_agrees_with_pinocchio() {
    agrees_with_pinocchio::<4>("scara", "base", "tool");
}

#[test]
fn a_gantry_agrees_with_pinocchio() {
    agrees_with_pinocchio::<4>("gantry", "bed", "tool");
}

#[test]
fn an_arm_with_mimic_joints_agrees_with_pinocchio() {
    agrees_with_pinocchio::<4>("palletiser", "base", "tool");
}

#[test]
fn an_arm_without_a_spherical_wrist_agrees_with_pinocchio() {
    agrees_with_pinocchio::<6>("three_parallel", "base", "wrist_3");
}

#[test]
fn an_arm_with_three_parallel_axes_beside_each_other_agrees_with_pinocchio() {
    agrees_with_pinocchio::<6>("three_parallel_beside", "foot", "tool");
}

#[test]
fn an_arm_with_seven_joints_and_an_offset_elbow_agrees_with_pinocchio() {
    agrees_with_pinocchio::<7>("offset_elbow", "foot", "tool");
}

#[test]
fn an_arm_with_seven_joints_and_an_offset_wrist_agrees_with_pinocchio() {
    agrees_with_pinocchio::<7>("offset_wrist", "link0", "flange");
}
