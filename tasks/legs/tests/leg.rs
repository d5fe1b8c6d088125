//! The leg as a robot.

use legs::leg::{GRAVITY, Leg, Three};
use legs::places::{NEAR, hip, start};
use mrroc::robot::{NoInverse, Robot};
use mrroc_robots::{Driven, Kinematics, Simulated};
use nalgebra::Vector3;

mrroc_robots::kinematics_conformance!(left, Leg::at(hip(0)), NEAR);
mrroc_robots::kinematics_conformance!(right, Leg::at(hip(3)), NEAR);
mrroc_robots::driver_conformance!(drives, Leg::at(hip(1)), Simulated::new(Leg::at(hip(1)), &NEAR), NEAR);

/// Postures within the limits.
fn postures() -> impl Iterator<Item = Three> {
    (0..60).map(|i| {
        let turn = |by: f64| (f64::from(i) * by).sin();
        Three::new(0.6 * turn(1.3), 0.5 + 1.2 * turn(0.7), -1.3 + turn(2.1))
    })
}

#[test]
fn its_links_move_and_weigh_as_those_of_its_tree_do() {
    for leg in [0, 3].map(|i| Leg::at(hip(i))) {
        let tree = leg.tree().expect("masses");
        for (q, qd) in postures().zip(postures().skip(7)) {
            let energy: f64 = leg
                .links(&q, &qd)
                .iter()
                .map(|link| {
                    0.5 * link.mass * link.velocity.norm_squared()
                        + 0.5 * link.turning.dot(&(link.inertia * link.turning))
                })
                .sum();
            assert!((energy - tree.kinetic_energy(&q, &qd)).abs() < 1e-12 * (1.0 + energy), "{q}");
            let loads = leg.shafts(&(q * Leg::GEAR), &Three::zeros()).loads * Leg::GEAR;
            assert!((loads - tree.gravity_torques(&q)).norm() < 1e-12 * GRAVITY, "{q}");
            assert!((tree.forward(&q).translation.vector - leg.foot(&q)).norm() < 1e-14);
        }
    }
}

#[test]
fn a_foot_that_cannot_be_there_is_told_with_the_reason() {
    let leg = Leg::at(hip(0));
    let refused = |x: f64, y: f64, z: f64| {
        let pose = mrroc::pose::Pose::translation(0.3 + x, 0.11 + y, z);
        leg.inverse(&pose, &NEAR).expect_err("out of reach").to_string()
    };
    assert!(refused(0.2, 0.09, -0.55).contains("distance of the foot from the hip is 0.585"), "too far");
    assert!(refused(0.1, 0.02, -0.03).contains("inside of the circle"), "too near the axis");
    let at_hip = Leg::at(hip(0)).reach_for(&Vector3::new(0.3, 0.2, 0.0), &NEAR);
    assert_eq!(at_hip, Err(NoInverse::Singular { name: "folded knee" }));
    let turned = mrroc::pose::Pose::new(Vector3::new(0.3, 0.2, -0.4), Vector3::z() * 0.01);
    assert!(leg.inverse(&turned, &NEAR).expect_err("turned").to_string().contains("turn of a foot"));
    assert_eq!(leg.near_singularity(&Three::new(0.0, 0.0, -0.1)), Some("straight knee"));
    assert_eq!(leg.near_singularity(&NEAR), None);
}

#[test]
fn it_stays_on_its_branch_and_another_one_is_outside_of_its_limits() {
    let leg = Leg::at(hip(2));
    let pose = leg.forward(&NEAR);
    let mut inside = 0;
    leg.solutions(&pose, &NEAR, &mut |q| {
        inside += usize::from(leg.is_attainable(q));
    })
    .expect("four");
    assert_eq!(inside, 1);
    let other = leg.inverse(&pose, &Three::new(0.0, -0.7, 1.4)).expect("knee forwards");
    assert!(other[2] > 0.0 && !leg.is_attainable(&other));
}

#[test]
fn the_cells_file_has_the_posture_at_the_start() {
    let file = legs::file().expect("in order");
    for (i, entry) in file.robots().iter().enumerate() {
        let leg = Leg::at(entry.base());
        let told: Three = entry.start(&leg).expect("three");
        assert!((told - start()[i]).amax() < 1e-12, "{}: {:?}", entry.name(), start()[i]);
        assert_eq!(entry.base(), hip(i));
    }
}
