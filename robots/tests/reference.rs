//! Forward kinematics and Jacobians against Pinocchio: `reference/pinocchio_reference.py`.

use mrroc_robots::{Irp6, Irp6FiveDof, Irp6Track, Kinematics, Polycrank, Rnt};
use nalgebra::{Matrix3, SVector, Vector3};

const TOLERANCE: f64 = 1e-12;

/// Compares every row of a reference file; returns how many there are.
fn compare<const N: usize>(csv: &str, robot: &impl Kinematics<N>) -> usize {
    let mut rows = 0;
    for line in csv.lines().skip(1) {
        let numbers: Vec<f64> = line.split(',').map(|n| n.parse().expect("a number")).collect();
        let q = SVector::<f64, N>::from_column_slice(&numbers[..N]);
        let pose = robot.forward(&q);
        let position = pose.translation.vector - Vector3::from_column_slice(&numbers[N..N + 3]);
        let rotation = pose.rotation.to_rotation_matrix().into_inner()
            - Matrix3::from_row_slice(&numbers[N + 3..N + 12]);
        assert!(position.amax() < TOLERANCE && rotation.amax() < TOLERANCE, "{q}{position}{rotation}");
        let jacobian = robot.jacobian(&q);
        for (k, expected) in numbers[N + 12..].iter().enumerate() {
            let error = jacobian[(k / N, k % N)] - expected;
            assert!(error.abs() < TOLERANCE, "row {}, joint {}: off by {error:e} at {q}", k / N, k % N);
        }
        rows += 1;
    }
    rows
}

#[test]
fn the_irp6_agrees_with_pinocchio() {
    assert_eq!(compare(include_str!("reference/irp6_nominal.csv"), &Irp6::nominal()), 25);
    assert_eq!(compare(include_str!("reference/irp6_calibrated.csv"), &Irp6::calibrated()), 25);
}

#[test]
fn the_irp6_with_five_joints_agrees_with_pinocchio() {
    assert_eq!(compare(include_str!("reference/irp6_5dof.csv"), &Irp6FiveDof::nominal()), 25);
}

#[test]
fn the_irp6_on_its_track_agrees_with_pinocchio() {
    assert_eq!(compare(include_str!("reference/irp6_track_nominal.csv"), &Irp6Track::nominal()), 25);
    assert_eq!(compare(include_str!("reference/irp6_track_calibrated.csv"), &Irp6Track::calibrated()), 25);
}

#[test]
fn polycrank_agrees_with_pinocchio() {
    assert_eq!(compare(include_str!("reference/polycrank.csv"), &Polycrank::new()), 25);
}

/// The closed linkages of the RNT: Pinocchio's tree, its loops closed by Newton's method.
#[test]
fn the_rnt_agrees_with_pinocchio_and_loops_closed_numerically() {
    assert_eq!(compare(include_str!("reference/rnt.csv"), &Rnt::new()), 25);
}
