//! Dynamics of the library's robots: Pinocchio's torques and mass matrices; trees that are where their kinematics is, and
//! weigh what their drives bear; and URDFs of which the same robots are read.

use mrroc::pose::{Pose, Wrench};
use mrroc::random::Random;
use mrroc::robot::{Load, Robot, Tool};
use mrroc_counting_allocator::allocations;
use mrroc_robots::{
    Conveyor, Driven, Gripper, Irp6, Irp6FiveDof, Irp6Track, Kinematics, Polycrank, Rnt, Serial, Six,
    TwoFingers, UrdfText,
};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3, Vector6};

/// A base that stands nowhere in particular.
fn base() -> Pose {
    Pose::new(Vector3::new(0.4, -0.3, 0.2), Vector3::new(0.0, 0.0, 0.7))
}

fn weighted() -> Serial<6> {
    let path = format!("{}/tests/reference/urdf/weighted_arm.urdf", env!("CARGO_MANIFEST_DIR"));
    Serial::<6>::from_urdf_file(path, "base_link", "tool0")
        .and_then(|robot| robot.with_acceleration(SVector::repeat(10.0)))
        .expect("the URDF is sound")
        .with_base(base())
}

/// The tree's tip is the flange; its weight loads the motors as the robot's drives say, and its mass is that of the energy.
fn agrees<const N: usize, R: Driven<N> + Kinematics<N>>(robot: &R) {
    let tree = robot.tree().expect("it has links");
    let limits = robot.limits();
    let mut random = Random::seeded(1955);
    for _ in 0..200 {
        let q = loop {
            let drawn = |i: usize, _| random.between(limits.lower[i].max(-3.0), limits.upper[i].min(3.0));
            let q = SVector::<f64, N>::from_fn(drawn);
            if robot.is_attainable(&q) {
                break q;
            }
        };
        let v = SVector::<f64, N>::from_fn(|i, _| limits.velocity[i] * random.between(-1.0, 1.0));
        let (there, flange) = (tree.forward(&q), robot.forward(&q));
        let off = (there.translation.vector - flange.translation.vector).norm();
        let turned =
            there.rotation.to_rotation_matrix().matrix() - flange.rotation.to_rotation_matrix().matrix();
        assert!(off < 1e-12 && turned.amax() < 1e-12, "{}: {off} m, {turned}", R::KIND);
        let kinetic = 0.5 * v.dot(&(tree.mass_matrix(&q) * v));
        assert!((tree.kinetic_energy(&q, &v) - kinetic).abs() <= 1e-12 * kinetic.max(1e-3), "{}", R::KIND);
        let motors = robot.motors(&q);
        let loads = robot.shafts(&motors, &SVector::zeros()).loads;
        let weight = robot.motor_torques(&motors, &tree.gravity_torques(&q));
        let scale = loads.amax().max(1e-3);
        assert!((weight - loads).amax() < 1e-9 * scale, "{}: {weight} and {loads} at {q}", R::KIND);
    }
    let rotors = robot.rotors();
    assert!(rotors.iter().all(|rotor| *rotor > 0.0), "{}: {rotors}", R::KIND);
}

#[test]
fn the_trees_of_the_irp6_family_are_their_arms_and_load_their_motors_as_their_drives_say() {
    agrees(&Irp6::nominal().with_base(base()));
    agrees(&Irp6::calibrated().with_base(base()));
    agrees(&Irp6FiveDof::nominal().with_base(base()));
    agrees(&Irp6Track::nominal().with_base(base()));
    agrees(&Irp6Track::calibrated().with_base(base()));
}

#[test]
fn the_trees_of_polycrank_hands_and_belt_are_theirs() {
    agrees(&Polycrank::new().with_base(base()));
    agrees(&Gripper::new().with_base(base()));
    agrees(&TwoFingers::new().with_base(base()));
    agrees(&Conveyor::new().with_base(base()));
}

#[test]
fn the_tree_of_an_arm_read_from_urdf_is_that_arm() {
    agrees(&weighted());
}

/// The base and the tool of `examples/dynamics.rs`, with which the reference was made.
fn leaning() -> Pose {
    Pose::new(Vector3::new(0.4, -0.3, 0.2), Vector3::new(0.3, -0.5, 0.7))
}

fn tool() -> Tool {
    let inertia = Matrix3::new(4e-3, 2e-4, -1e-4, 2e-4, 5e-3, 3e-4, -1e-4, 3e-4, 3e-3);
    let load = Load { mass: 1.2, centre: Vector3::new(0.01, -0.02, 0.07), inertia };
    Tool { frame: Pose::new(Vector3::new(0.0, 0.03, 0.15), Vector3::new(0.0, 0.4, 0.0)), load }
}

/// The lines of this robot, in numbers.
fn references(name: &str) -> Vec<Vec<f64>> {
    let lines = include_str!("reference/dynamics.csv").lines();
    let lines = lines.filter_map(|line| line.strip_prefix(name)?.strip_prefix(','));
    lines.map(|line| line.split(',').map(|n| n.parse().expect("a number")).collect()).collect()
}

/// Torques, accelerations and mass matrices. Expected values: `reference/dynamics.py` (Pinocchio 4.1).
fn agrees_with_pinocchio<const N: usize, R: Driven<N>>(name: &str, robot: &R) {
    let tree = robot.tree().expect("it has links").with_load(&tool().load);
    let rows = references(name);
    assert_eq!(rows.len(), 3, "{name}");
    for row in rows {
        let part = |k: usize| SVector::<f64, N>::from_column_slice(&row[k..k + N]);
        let (q, v, a) = (part(0), part(N), part(2 * N));
        let three = |k: usize| Vector3::from_column_slice(&row[k..k + 3]);
        let wrench = Wrench::new(three(3 * N), three(3 * N + 3));
        let tau = part(3 * N + 6);
        let mass = SMatrix::<f64, N, N>::from_column_slice(&row[4 * N + 6..]);
        let before = allocations();
        let ours = tree.inverse_dynamics(&q, &v, &a, Some(&wrench));
        let our_mass = tree.mass_matrix(&q);
        let back = tree.forward_dynamics(&q, &v, &tau, Some(&wrench));
        assert_eq!(allocations(), before, "{name}: dynamics allocates");
        let off = (ours - tau).amax() / tau.amax();
        let off_mass = (our_mass - mass).amax() / mass.amax();
        // Solved for the accelerations, round-off grows by the condition of M.
        let off_back = (back.expect("it has mass") - a).amax() / a.amax();
        println!("{name}: torques {off:.1e}, masses {off_mass:.1e}, accelerations {off_back:.1e}");
        assert!(off < 1e-13 && off_mass < 1e-13 && off_back < 1e-9, "{name}");
    }
}

#[test]
fn torques_accelerations_and_mass_matrices_are_pinocchios() {
    agrees_with_pinocchio("irp6", &Irp6::nominal().with_base(leaning()));
    agrees_with_pinocchio("irp6-calibrated", &Irp6::calibrated().with_base(leaning()));
    agrees_with_pinocchio("irp6-5dof", &Irp6FiveDof::nominal().with_base(leaning()));
    agrees_with_pinocchio("irp6-track", &Irp6Track::nominal().with_base(leaning()));
    agrees_with_pinocchio("irp6-track-calibrated", &Irp6Track::calibrated().with_base(leaning()));
    agrees_with_pinocchio("polycrank", &Polycrank::new().with_base(leaning()));
    agrees_with_pinocchio("gripper", &Gripper::new().with_base(leaning()));
    agrees_with_pinocchio("two-fingers", &TwoFingers::new().with_base(leaning()));
    agrees_with_pinocchio("conveyor", &Conveyor::new().with_base(leaning()));
    agrees_with_pinocchio("weighted_arm", &weighted().with_base(leaning()));
}

#[test]
fn rnt_with_its_loops_closed_has_the_mass_matrix_and_the_bias_of_pinocchios_constraints() {
    let links = Rnt::new().with_base(leaning()).dynamics().expect("it has links");
    let rows = references("rnt");
    assert_eq!(rows.len(), 3);
    for row in rows {
        let part = |k: usize| SVector::<f64, 6>::from_column_slice(&row[k..k + 6]);
        let before = allocations();
        let equation = links.equation(&part(0), &part(6));
        assert_eq!(allocations(), before, "it allocates");
        let mass = SMatrix::<f64, 6, 6>::from_column_slice(&row[18..]);
        let off = (equation.bias - part(12)).amax() / part(12).amax();
        let off_mass = (equation.mass - mass).amax() / mass.amax();
        println!("rnt: bias {off:.1e}, masses {off_mass:.1e}");
        assert!(off < 1e-12 && off_mass < 1e-12);
    }
}

/// What is read of the exported URDF has the same tool pose, torques and limits.
fn is_read_back<const N: usize, R: Driven<N>>(robot: &R) {
    let text = robot.urdf("a & b", &tool()).expect("it has a URDF");
    assert_eq!(UrdfText::new(&text).root().expect("well-formed"), "world");
    let builder =
        Serial::<N>::from_urdf(&text, "world", "tool").unwrap_or_else(|why| panic!("{}: {why}", R::KIND));
    let limits = robot.limits();
    let read = builder.with_acceleration(limits.acceleration).expect("accelerations");
    let off = |a: &SVector<f64, N>, b: &SVector<f64, N>| (a - b).amax();
    assert_eq!((read.limits().lower, read.limits().upper), (limits.lower, limits.upper));
    assert_eq!(read.limits().velocity, limits.velocity);
    let mut random = Random::seeded(1955);
    let ours = robot.tree().expect("it has links").with_load(&tool().load);
    let theirs = read.tree().expect("it has links");
    for _ in 0..100 {
        let q = SVector::<f64, N>::from_fn(|i, _| {
            random.between(limits.lower[i].max(-3.0), limits.upper[i].min(3.0))
        });
        let v = limits.velocity.map(|most| random.between(-most, most));
        let (a, b) = (read.forward(&q), robot.forward(&q) * tool().frame);
        let turned = a.rotation.to_rotation_matrix().matrix() - b.rotation.to_rotation_matrix().matrix();
        let moved = (a.translation.vector - b.translation.vector).norm();
        assert!(moved < 1e-12 && turned.amax() < 1e-12, "{}: {moved} m", R::KIND);
        let tau = ours.inverse_dynamics(&q, &v, &limits.acceleration, None);
        let same = theirs.inverse_dynamics(&q, &v, &limits.acceleration, None);
        assert!(off(&tau, &same) <= 1e-12 * tau.amax(), "{}: {tau} and {same}", R::KIND);
    }
}

#[test]
fn a_robot_is_read_back_from_the_urdf_that_it_is_exported_as() {
    is_read_back(&Irp6::nominal().with_base(leaning()));
    is_read_back(&Irp6::calibrated().with_base(leaning()));
    is_read_back(&Irp6FiveDof::nominal().with_base(leaning()));
    is_read_back(&Irp6Track::nominal().with_base(leaning()));
    is_read_back(&Polycrank::new().with_base(leaning()));
    is_read_back(&Gripper::new().with_base(leaning()));
    is_read_back(&TwoFingers::new().with_base(leaning()));
    is_read_back(&weighted().with_base(leaning()));
}

#[test]
fn the_urdf_of_a_robot_names_what_it_cannot_say() {
    let said = Irp6::nominal().urdf("arm", &tool()).expect("it has a URDF");
    for named in
        ["Transmission", "depends on the posture", "rotor's inertia", "Coulomb friction", "share motors"]
    {
        assert!(said.contains(named), "{named}");
    }
    let said = Rnt::new().urdf("rnt", &tool()).expect("it has a URDF");
    assert!(said.contains("Closed loops") && said.contains("(0.52 0 0) of `rod_link`"));
    let comment = said.split("<!--").nth(1).and_then(|rest| rest.split("-->").next()).expect("a comment");
    assert!(!comment.contains("--"));
    let massless = Serial::<6>::from_urdf_file(
        format!("{}/tests/reference/urdf/offset_arm.urdf", env!("CARGO_MANIFEST_DIR")),
        "foot",
        "tool",
    );
    let massless = massless.and_then(|robot| robot.with_acceleration(SVector::repeat(10.0))).expect("sound");
    assert!(massless.urdf("arm", &tool()).is_some_and(|said| said.contains("its links have none here")));
    assert!(massless.dynamics().is_none());
}

// ANCHOR: dynamics
/// The accelerations [rad/s²] that raise a tool at 0.5 m/s², and those which the torques for it give.
fn lift() -> Option<[Six; 2]> {
    let arm = Irp6::nominal();
    let load = Load::point(2.0, Vector3::new(0.0, 0.0, 0.1)); // 2 kg, 0.1 m in front of the flange
    let tree = arm.tree()?.with_load(&load);
    let q = Irp6::READY;
    let at_rest = Six::zeros();
    let up = Vector6::new(0.0, 0.0, 0.5, 0.0, 0.0, 0.0);
    let acceleration = arm.jacobian(&q).lu().solve(&up)?; // at rest
    let torques = tree.inverse_dynamics(&q, &at_rest, &acceleration, None);
    let moved = tree.forward_dynamics(&q, &at_rest, &torques, None)?;
    Some([acceleration, moved])
}
// ANCHOR_END: dynamics

#[test]
fn the_book_lifts_an_arm_by_its_torques() {
    let [asked, given] = lift().expect("an arm is a tree");
    assert!((asked - given).amax() < 1e-9 && asked.amax() > 0.1, "{asked} and {given}");
}
