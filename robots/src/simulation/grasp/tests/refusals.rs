//! What no world takes.

use mrroc::pose::Pose;
use nalgebra::{Matrix3, Vector3};

use super::Bench;
use super::bench::at;
use crate::simulation::grasp::{Body, Grasp, OutOfReach, Table, World, WorldError};

#[test]
fn bodies_that_cannot_be_are_refused() {
    let moments = |x, y, z| Body::new(1.0, Matrix3::from_diagonal(&Vector3::new(x, y, z)));
    let refused = |body: &Body| World::new(body).map(drop).expect_err("no body");
    assert_eq!(
        refused(&Body::block(0.0, [1.0; 3])),
        WorldError::NotPositive { what: "the body's mass", actual: 0.0, unit: "kg" }
    );
    // A plate's moment is the sum of the other two; nothing has more.
    assert!(World::new(&moments(1.0, 1.0, 2.0)).is_ok());
    assert_eq!(refused(&moments(1.0, 2.1, 1.0)), WorldError::Inertia([1.0, 1.0, 2.1]));
    assert!(matches!(refused(&moments(-1.0, 1.0, 1.0)), WorldError::Inertia(_)));
    assert!(matches!(refused(&moments(f64::NAN, 1.0, 1.0)), WorldError::Inertia(_)));
    let lopsided = Body::new(1.0, Matrix3::new(1.0, 0.1, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0));
    assert!(matches!(refused(&lopsided), WorldError::Inertia(_)));
    let nowhere = Body::block(1.0, [1.0; 3]).at(at(f64::NAN, 0.0, 0.0));
    assert!(matches!(refused(&nowhere), WorldError::NotFinite(_)));
}

#[test]
fn tables_and_grasps_out_of_range_are_refused() {
    let world = || World::new(&Body::block(1.0, [0.1; 3])).expect("a body");
    for table in [
        Table::at(f64::INFINITY),
        Table::at(0.0).with_friction(-0.1),
        Table::at(0.0).with_stiffness(0.0, 1.0),
        Table::at(0.0).with_stiffness(1e4, f64::NAN),
    ] {
        assert!(world().with_table(table).is_err(), "{table:?}");
    }
    let period = core::time::Duration::from_millis(2);
    for grasp in [
        Grasp::new(0.0, 500.0),
        Grasp::new(5e4, f64::NAN),
        Grasp::new(5e4, 500.0).with_damping(-1.0, 0.0),
        Grasp::new(5e4, 500.0).closing_over(f64::NAN),
        Grasp::new(5e4, 500.0).with_tool(at(f64::NAN, 0.0, 0.0)),
    ] {
        assert!(world().add_hand(grasp, period, Pose::identity()).is_err(), "{grasp:?}");
    }
    let grasp = Grasp::new(5e4, 500.0);
    assert!(world().add_hand(grasp, core::time::Duration::ZERO, Pose::identity()).is_err());
}

#[test]
fn a_gripper_that_does_not_reach_its_grasp_says_how_far_it_is_off() {
    let grasp = Grasp::new(5e4, 500.0).at(at(0.3, 0.0, 0.0));
    let world = World::new(&Body::block(1.0, [0.6, 0.1, 0.1])).expect("a body");
    let bench = Bench::new(world).with_hand(grasp, at(0.33, 0.04, 0.0));
    let OutOfReach { distance, reach, .. } = bench.hands[0].0.close().expect_err("5 cm off");
    assert!((distance - 0.05).abs() < 1e-15 && reach == Grasp::REACH);
    assert!(!bench.hands[0].0.is_closed());
}
