//! Dynamics against equations of books; `tests/dynamics.rs` has Pinocchio's numbers.

use mrroc::pose::{Pose, Wrench};
use mrroc::robot::Load;
use nalgebra::{Matrix2, Matrix3, SVector, Vector2, Vector3};

use super::{Segment, Tree, TreeError};

const G: f64 = 9.80665;
const L1: f64 = 0.4;
const MASSES: [f64; 2] = [3.0, 2.0];
const CENTRES: [f64; 2] = [0.15, 0.25];
const MOMENTS: [f64; 2] = [0.05, 0.03];

/// Two links in the vertical plane x-z, level at q = 0, positive upwards.
fn planar() -> Tree<2> {
    let body = |i: usize| Load {
        mass: MASSES[i],
        centre: Vector3::x() * CENTRES[i],
        inertia: Matrix3::from_diagonal(&(Vector3::y() * MOMENTS[i])),
    };
    let upper = Segment::turning("upper", None, 0, Vector3::zeros(), -Vector3::y()).carrying(body(0));
    let lower = Segment::turning("lower", Some(0), 1, Vector3::x() * L1, -Vector3::y()).carrying(body(1));
    Tree::new(Pose::identity(), vec![upper, lower], Pose::translation(0.3, 0.0, 0.0)).expect("a tree")
}

/// Craig, Introduction to Robotics, 3rd edition, section 6.7, with links that have inertia: M and h.
fn craig(q: &Vector2<f64>, v: &Vector2<f64>) -> (Matrix2<f64>, Vector2<f64>) {
    let [m1, m2] = MASSES;
    let [c1, c2] = CENTRES;
    let [i1, i2] = MOMENTS;
    let a = i2 + m2 * c2 * c2;
    let b = m2 * L1 * c2;
    let mass = Matrix2::new(
        i1 + m1 * c1 * c1 + m2 * L1 * L1 + a + 2.0 * b * q.y.cos(),
        a + b * q.y.cos(),
        a + b * q.y.cos(),
        a,
    );
    let lower = m2 * c2 * G * (q.x + q.y).cos();
    let coriolis = b * q.y.sin();
    let bias = Vector2::new(
        -coriolis * (2.0 * v.x * v.y + v.y * v.y) + (m1 * c1 + m2 * L1) * G * q.x.cos() + lower,
        coriolis * v.x * v.x + lower,
    );
    (mass, bias)
}

#[test]
fn two_links_in_a_plane_move_by_the_equations_of_the_book() {
    let tree = planar();
    for k in 0..50 {
        let at = |factor: f64| (f64::from(k) * factor).sin() * 3.0;
        let (q, v, a) =
            (Vector2::new(at(1.1), at(2.3)), Vector2::new(at(0.7), at(1.9)), Vector2::new(at(3.1), at(0.3)));
        let (mass, bias) = craig(&q, &v);
        let torques = mass * a + bias;
        assert!((tree.mass_matrix(&q) - mass).amax() < 1e-14);
        assert!((tree.bias(&q, &v) - bias).amax() < 1e-12);
        assert!((tree.inverse_dynamics(&q, &v, &a, None) - torques).amax() < 1e-12);
        let back = tree.forward_dynamics(&q, &v, &torques, None).expect("it has mass");
        assert!((back - a).amax() < 1e-12);
        let energy = 0.5 * v.dot(&(mass * v));
        assert!((tree.kinetic_energy(&q, &v) - energy).abs() < 1e-12);
    }
}

#[test]
fn the_weights_torques_are_the_slope_of_the_potential_energy() {
    let tree = planar().with_gravity(Vector3::new(1.0, -2.0, -5.0));
    let q = Vector2::new(0.4, -1.1);
    let torques = tree.gravity_torques(&q);
    for i in 0..2 {
        let step = 1e-5 * Vector2::from_fn(|j, _| if i == j { 1.0 } else { 0.0 });
        let slope = (tree.potential_energy(&(q + step)) - tree.potential_energy(&(q - step))) / 2e-5;
        assert!((torques[i] - slope).abs() < 1e-8, "{} and {slope}", torques[i]);
    }
}

#[test]
fn a_wrench_at_the_tip_does_the_work_that_its_joints_feel() {
    // The tip of two links of 0.4 and 0.3 m; J^T F by hand.
    let tree = planar();
    let q = Vector2::new(0.4, -1.1);
    let none = SVector::zeros();
    let wrench = Wrench::new(Vector3::new(3.0, 7.0, -2.0), Vector3::new(0.5, 0.25, -0.5));
    let alone = tree.inverse_dynamics(&q, &none, &none, None);
    let pushed = tree.inverse_dynamics(&q, &none, &none, Some(&wrench));
    let (elbow, tip) = (q.x, q.x + q.y);
    let forearm = 0.3 * (-tip.sin() * 3.0 + tip.cos() * -2.0) - 0.25;
    let all = L1 * (-elbow.sin() * 3.0 + elbow.cos() * -2.0) + forearm;
    assert!((alone - pushed - Vector2::new(all, forearm)).amax() < 1e-12);
}

#[test]
fn free_motion_keeps_its_energy_to_the_order_of_its_integration() {
    // Runge-Kutta of order 4 for 10 s; a step of half the length loses at most a tenth.
    let tree = planar();
    let drift = |steps: u32| {
        let h = 10.0 / f64::from(steps);
        let mut q = Vector2::new(0.3, 0.9);
        let mut v = Vector2::new(0.0, 1.0);
        let none = Vector2::zeros();
        let energy =
            |q: &Vector2<f64>, v: &Vector2<f64>| tree.kinetic_energy(q, v) + tree.potential_energy(q);
        let start = energy(&q, &v);
        for _ in 0..steps {
            let rate = |q: Vector2<f64>, v: Vector2<f64>| {
                (v, tree.forward_dynamics(&q, &v, &none, None).expect("it has mass"))
            };
            let (k1, a1) = rate(q, v);
            let (k2, a2) = rate(q + k1 * (h / 2.0), v + a1 * (h / 2.0));
            let (k3, a3) = rate(q + k2 * (h / 2.0), v + a2 * (h / 2.0));
            let (k4, a4) = rate(q + k3 * h, v + a3 * h);
            q += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
            v += (a1 + (a2 + a3) * 2.0 + a4) * (h / 6.0);
        }
        (energy(&q, &v) - start).abs()
    };
    let (coarse, fine) = (drift(5_000), drift(10_000));
    println!("energy drifts by {coarse:.1e} J, by {fine:.1e} J with half the step");
    assert!(fine < 1e-6 && fine < 0.1 * coarse, "{coarse} J, {fine} J");
}

#[test]
fn a_load_at_the_tip_is_part_of_the_last_body() {
    // A rod of two halves is the whole rod.
    let half = |x: f64| Load {
        mass: 1.0,
        centre: Vector3::x() * x,
        inertia: Matrix3::from_diagonal(&Vector3::new(0.0, 1.0, 1.0)) / 12.0,
    };
    let rod = Segment::turning("rod", None, 0, Vector3::zeros(), Vector3::z()).carrying(half(0.5));
    let tree = Tree::<1>::new(Pose::identity(), vec![rod], Pose::translation(1.0, 0.0, 0.0)).expect("a tree");
    let whole = tree.with_load(&half(0.5));
    // m l² / 3 about an end, of 2 kg and 2 m.
    assert!((whole.mass_matrix(&SVector::zeros())[0] - 2.0 * 4.0 / 3.0).abs() < 1e-14);
    assert!((whole.mass() - 2.0).abs() < 1e-15);
}

#[test]
fn what_is_no_tree_is_told() {
    let segment =
        |parent, coordinate| Segment::turning("a", parent, coordinate, Vector3::zeros(), Vector3::z());
    let refused = |segments: Vec<Segment>| Tree::<1>::new(Pose::identity(), segments, Pose::identity()).err();
    assert_eq!(refused(vec![]), Some(TreeError::Size { count: 0, limit: 16 }));
    assert_eq!(refused(vec![segment(Some(0), 0)]), Some(TreeError::Order { segment: "a".to_owned() }));
    assert!(matches!(
        refused(vec![segment(None, 1)]),
        Some(TreeError::Coordinate { coordinate: 1, count: 1, .. })
    ));
    let axis = Segment { axis: Vector3::zeros(), ..segment(None, 0) };
    assert!(matches!(refused(vec![axis]), Some(TreeError::Axis { .. })));
    let body = segment(None, 0).carrying(Load::point(-1.0, Vector3::zeros()));
    assert!(matches!(refused(vec![body]), Some(TreeError::Body { .. })));
}
