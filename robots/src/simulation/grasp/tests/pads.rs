//! Fingers that touch bodies: pushing, turning, gripping, and coming down on one.

use mrroc::pose::Pose;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use super::Bench;
use super::bench::at;
use crate::models::GRAVITY;
use crate::simulation::grasp::body::Face;
use crate::simulation::grasp::{Body, Grasp, Pads, Table, World};

const MASS: f64 = 0.3;
const EDGES: [f64; 3] = [0.08, 0.05, 0.04];
/// Each finger [m/s].
const CLOSING: f64 = 0.03;
const PERIOD: f64 = 2e-3;

/// A hand at this height with its fingers down, along y of the world, over the table at z = 0, with the block in this pose.
#[allow(non_snake_case)]
fn over(X_WB: Pose, height: f64) -> Bench {
    let table = Table::at(0.0).with_stiffness(4e3, 12.0);
    let world = World::empty().with_table(table).expect("a table");
    world.put(&Body::block(MASS, EDGES).at(X_WB)).expect("a block");
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f64::consts::PI);
    let along_y = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), core::f64::consts::FRAC_PI_2);
    let X_WE = Pose::from_parts(Translation3::new(0.0, 0.0, height), along_y * down);
    let bench = Bench::new(world).with_hand(Grasp::new(2e4, 20.0), X_WE);
    bench.hands[0].0.fit(Pads::new(0.024, 0.01), 0.085).expect("pads");
    bench
}

/// Closes the fingers from this opening until they have the body or meet.
fn close(bench: &Bench, opening: f64) {
    let mut now = opening;
    while now > 0.0 && !bench.hands[0].0.is_closed() {
        bench.hands[0].0.set_opening(now, -2.0 * CLOSING, PERIOD);
        bench.tick();
        now -= 2.0 * CLOSING * PERIOD;
    }
}

#[test]
fn the_finger_that_comes_first_pushes_the_body_to_the_middle() {
    for off in [-0.012, 0.0, 0.009] {
        let bench = over(at(0.004, off, 0.0198), 0.02);
        close(&bench, 0.085);
        let grip = bench.hands[0].0.gripped().expect("gripped");
        // Its middle along the fingers is E's, to the depth by which pads must press; nothing moves it along the belt.
        assert!(grip.X_EB.translation.x.abs() < 1e-3, "{}", grip.X_EB.translation.x);
        assert!((grip.X_EB.translation.y.abs() - 0.004).abs() < 1e-4, "{}", grip.X_EB.translation.y);
        assert_eq!((grip.body, bench.hands[0].0.held(), bench.hands[0].0.crashes()), (0, Some(0), 0));
    }
}

#[test]
fn fingers_turn_a_body_that_lies_askew() {
    let askew = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 5.0_f64.to_radians());
    let bench = over(Pose::from_parts(Translation3::new(0.0, 0.0, 0.0198), askew), 0.02);
    close(&bench, 0.085);
    let (roll, _, yaw) = bench.world.body().pose.rotation.euler_angles();
    assert!(bench.hands[0].0.is_closed() && yaw.abs() < 1.0_f64.to_radians(), "{yaw} {roll}");
}

#[test]
fn what_is_gripped_is_carried_and_let_go() {
    let mut bench = over(at(0.0, 0.0, 0.0198), 0.02);
    close(&bench, 0.085);
    assert!(bench.hands[0].0.is_closed());
    // Up by 0.1 m within 1 s, and a second of rest.
    for i in 0..1000 {
        bench.hands[0].2.translation.z = 0.02 + 0.1 * (f64::from(i) * PERIOD).min(1.0);
        bench.tick();
    }
    let z = bench.world.body().pose.translation.z;
    assert!((z - 0.12).abs() < 2e-3, "{z}");
    let weight = bench.hands[0].0.reaction().force.norm();
    assert!((weight - MASS * GRAVITY).abs() < 0.01, "{weight} N");
    bench.hands[0].0.open();
    bench.hands[0].0.set_opening(0.085, 0.0, 0.0);
    bench.run(0.1);
    let fallen = z - bench.world.body().pose.translation.z;
    assert!((fallen - 0.5 * GRAVITY * 0.01).abs() < 2e-3, "{fallen} m in 0.1 s");
}

#[test]
fn a_finger_that_comes_down_on_a_body_is_told() {
    // The block is so far aside that a finger is over it, not beside it.
    let mut bench = over(at(0.0, 0.03, 0.0198), 0.08);
    bench.run(0.1);
    assert_eq!(bench.hands[0].0.crashes(), 0);
    for i in 0..50 {
        bench.hands[0].2.translation.z = 0.08 - 1e-3 * f64::from(i);
        bench.tick();
    }
    assert_eq!(bench.hands[0].0.crashes(), 1);
}

#[test]
fn a_prism_over_a_rectangle_is_the_block() {
    let block = Body::block(MASS, EDGES);
    let [x, y, z] = EDGES.map(|edge| 0.5 * edge);
    let outline = [[-x, -y], [x, -y], [x, y], [-x, y]];
    let prism = Body::prism(MASS, block.inertia, &outline, [-z, z]);
    assert_eq!((prism.faces.len(), prism.points.len()), (6, 8));
    for face in &block.faces {
        let same =
            |of: &&Face| (of.normal - face.normal).norm() < 1e-12 && (of.offset - face.offset).abs() < 1e-12;
        assert_eq!(prism.faces.iter().filter(same).count(), 1, "{face:?}");
    }
    assert!(block.points.iter().all(|point| prism.points.contains(point)));
}
