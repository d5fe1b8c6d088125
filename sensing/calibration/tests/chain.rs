//! Chains: their Jacobian, and the arms that they are.

use mrroc::robot::JointKind;
use mrroc_calibration::*;
use nalgebra::Vector6;

fn rows() -> Vec<DhRow> {
    let row = |i: usize, d: f64, a: f64, alpha: f64| DhRow {
        name: format!("joint {}", i + 1),
        kind: if i == 3 { JointKind::Prismatic } else { JointKind::Revolute },
        theta: 0.1 * i as f64,
        d,
        a,
        alpha,
    };
    vec![
        row(0, 0.3, 0.0, -1.5),
        row(1, 0.0, 0.27, 0.0),
        row(2, 0.0, 0.07, -1.6),
        row(3, 0.3, 0.0, 1.3),
        row(4, 0.1, 0.02, 0.2),
    ]
}

#[test]
fn the_derivatives_of_a_chain_are_those_of_differences() {
    let arm = Chain::distal(&rows()).with(Detail::Encoders, &Tolerances::default());
    let n = arm.parameters().len();
    let values: Vec<f64> = (0..n).map(|i| 0.01 * ((i * 7 % 11) as f64 - 5.0)).collect();
    let q = [0.4, -0.7, 0.9, 0.12, -1.3];
    let mut twists = vec![Vector6::zeros(); n];
    let flange = arm.linearise(&q, &values, &mut twists);
    assert!((flange.to_homogeneous() - arm.flange(&q, &values).to_homogeneous()).amax() < 1e-14);
    for (i, twist) in twists.iter().enumerate() {
        let at = |by: f64| {
            let mut values = values.clone();
            values[i] += by;
            arm.flange(&q, &values)
        };
        let differences = between(&at(-1e-5), &at(1e-5)) / 2e-5;
        assert!((twist - differences).amax() < 1e-8, "{}: {twist} {differences}", arm.parameters()[i].name);
    }
}

/// Both conventions describe the same arm if the turn and shift about x of the one stand a row earlier in the other.
#[test]
fn the_two_conventions_differ_by_where_the_turn_about_x_stands() {
    let distal = rows();
    let mut proximal = distal.clone();
    for i in (0..proximal.len()).rev() {
        (proximal[i].a, proximal[i].alpha) =
            if i == 0 { (0.0, 0.0) } else { (distal[i - 1].a, distal[i - 1].alpha) };
    }
    let last = distal.last().expect("rows");
    let q = [0.4, -0.7, 0.9, 0.12, -1.3];
    let none = Tolerances::default();
    let a = Chain::distal(&distal).with(Detail::Frames, &none).flange(&q, &[]);
    let b = Chain::proximal(&proximal).with(Detail::Frames, &none).flange(&q, &[]);
    let rest = mrroc::pose::Pose::translation(last.a, 0.0, 0.0)
        * mrroc::pose::Pose::rotation(nalgebra::Vector3::x() * last.alpha);
    assert!((a.to_homogeneous() - (b * rest).to_homogeneous()).amax() < 1e-14);
}
