//! A peg on a plate with a hole, against statics and geometry.

use core::f64::consts::FRAC_PI_4;

use mrroc::pose::Pose;
use nalgebra::{UnitQuaternion, Vector3};

use super::Bench;
use super::bench::at;
use crate::models::GRAVITY;
use crate::simulation::grasp::{Body, Grasp, Hole, Plate, World};

const MASS: f64 = 0.5;
const DIAMETER: f64 = 0.01;
const LENGTH: f64 = 0.05;
/// Of the hole, wider than the peg \[m\].
const CLEARANCE: f64 = 2e-4;
const DEPTH: f64 = 0.02;

fn hole(chamfer: f64) -> Hole {
    Hole { at: [0.0, 0.0], diameter: DIAMETER + CLEARANCE, depth: DEPTH, chamfer }
}

/// A peg whose end is at `end` in the world, and stands upright.
fn standing(end: Vector3<f64>) -> Body {
    Body::peg(MASS, DIAMETER, LENGTH).at(at(end.x, end.y, end.z + 0.5 * LENGTH))
}

/// A peg in a world with this plate, and a hand far away which drives the clock.
fn free(end: Vector3<f64>, plate: Plate) -> Bench {
    let world = World::new(&standing(end)).and_then(|world| world.with_plate(plate)).expect("a world");
    Bench::new(world).with_hand(Grasp::new(1.0, 1.0), at(0.0, 0.0, 1.0))
}

/// How far the end of the peg is below the plate's top \[m\].
fn depth(world: &World) -> f64 {
    let pose = world.body().pose;
    -(pose.translation.vector - pose.rotation * (Vector3::z() * (0.5 * LENGTH))).z
}

#[test]
fn a_peg_beside_the_hole_stands_on_the_plate_and_one_over_it_falls_to_the_floor() {
    let plate = || Plate::at(Pose::identity()).with_hole(hole(0.0));
    let beside = free(Vector3::new(0.02, 0.0, 1e-4), plate());
    beside.run(0.5);
    let force = beside.world.plate_force();
    assert!((force - Vector3::new(0.0, 0.0, MASS * GRAVITY)).amax() < 1e-6, "{force}");
    // All points of its rim share the weight.
    let sunk = MASS * GRAVITY / (Body::RIM as f64 * 1e5);
    assert!((depth(&beside.world) - sunk).abs() < 1e-9, "{}", depth(&beside.world));
    let over = free(Vector3::new(0.0, 0.0, 1e-4), plate());
    over.run(0.5);
    assert!((depth(&over.world) - DEPTH - sunk).abs() < 1e-8, "{}", depth(&over.world));
    let force = over.world.plate_force();
    assert!((force - Vector3::new(0.0, 0.0, MASS * GRAVITY)).amax() < 1e-6, "{force}");
}

/// A chamfer takes in a peg that is beside the hole by less than the clearance on its side and the width of the chamfer.
#[test]
fn a_chamfer_leads_a_peg_in_and_a_sharp_edge_does_not() {
    for (chamfer, aside, falls_in) in
        [(1e-3, 0.9e-3, true), (1e-3, 1.3e-3, false), (0.0, 0.9e-3, false), (0.0, 0.08e-3, true)]
    {
        // Held by its middle so that it neither tilts nor falls aside, and let down by 5 mm on a soft spring.
        let plate = Plate::at(Pose::identity()).with_friction(0.1).with_hole(hole(chamfer));
        let peg = standing(Vector3::new(aside, 0.0, 1e-4));
        let grip = at(aside, 0.0, 0.5 * LENGTH + 1e-4);
        let world = World::new(&peg).and_then(|world| world.with_plate(plate)).expect("a world");
        let mut bench = Bench::new(world.with_gravity(Vector3::zeros()))
            .with_hand(Grasp::new(1000.0, 50.0).with_damping(30.0, 0.02), grip);
        bench.close();
        for _ in 0..500 {
            bench.hands[0].2.translation.z -= 1e-5;
            bench.tick();
        }
        bench.run(0.2);
        let depth = depth(&bench.world);
        assert!((depth > 4e-3) == falls_in, "{depth} m deep with a chamfer of {chamfer} m, {aside} m aside");
    }
}

/// Without friction a face of 45 degrees pushes aside as hard as it bears; beside it the plate pushes up alone.
#[test]
fn a_chamfer_pushes_aside_as_hard_as_it_bears() {
    let plate = Plate::at(Pose::identity()).with_friction(0.0).with_hole(hole(2e-3));
    let peg = standing(Vector3::new(1e-3, 0.0, 0.0));
    let world = World::new(&peg).and_then(|world| world.with_plate(plate)).expect("a world");
    let grip = at(1e-3, 0.0, 0.5 * LENGTH);
    let mut bench = Bench::new(world.with_gravity(Vector3::zeros()))
        .with_hand(Grasp::new(2e4, 50.0).with_damping(100.0, 0.02), grip);
    bench.close();
    // It comes to the chamfer 1.1 mm deep, 2 mm less 1 mm aside and the clearance, and is pressed 0.5 mm farther.
    for _ in 0..100 {
        bench.hands[0].2.translation.z -= 1.6e-5;
        bench.tick();
    }
    bench.run(0.5);
    let force = bench.world.plate_force();
    assert!(force.z > 1.0, "{force}");
    // Points off the plane of symmetry push along their own radii, by a few degrees: cos(20 degrees) at most.
    let ratio = -force.x / force.z;
    assert!((0.94..1.0 + 1e-9).contains(&ratio) && force.y.abs() < 1e-6 * force.z, "{ratio}");
}

#[test]
fn a_peg_that_is_dragged_over_the_plate_bears_the_friction_of_its_load() {
    let plate = Plate::at(Pose::identity()).with_friction(0.3);
    let peg = standing(Vector3::zeros());
    let world = World::new(&peg).and_then(|world| world.with_plate(plate)).expect("a world");
    // Turned by no torque to speak of: it is held by its end.
    let mut bench = Bench::new(world.with_gravity(Vector3::zeros()))
        .with_hand(Grasp::new(2e4, 50.0).with_damping(100.0, 0.02), at(0.0, 0.0, 0.0));
    bench.close();
    bench.hands[0].2.translation.z = -1e-3;
    for _ in 0..500 {
        bench.hands[0].2.translation.x += 2e-5;
        bench.tick();
    }
    let force = bench.world.plate_force();
    assert!((-force.x / force.z - 0.3).abs() < 1e-3 && force.z > 10.0, "{force}");
}

/// A peg that is held askew by `theta` and pushed without friction goes in until two points touch: the end of its side and the
/// wall, its other side and the edge. Its lowest point is then `cos(theta) (D - d cos(theta)) / sin(theta)` deep.
#[test]
fn a_tilted_peg_goes_in_as_deep_as_its_diameter_lets_it() {
    let theta: f64 = 0.03;
    let stiffness = 5e6;
    let plate = Plate::at(Pose::identity()).with_friction(0.0).with_stiffness(stiffness, 100.0);
    let tilted = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), theta);
    // Its end 0.3 mm above the plate.
    let start = Vector3::z() * 3e-4 + tilted * (Vector3::z() * (0.5 * LENGTH));
    let start = Pose::from_parts(start.into(), tilted);
    let peg = Body::peg(MASS, DIAMETER, LENGTH).at(start);
    let world = World::new(&peg).and_then(|world| world.with_plate(plate.with_hole(hole(0.0))));
    let grasp = Grasp::new(200.0, 200.0).with_damping(20.0, 0.05);
    let mut bench =
        Bench::new(world.expect("a world").with_gravity(Vector3::zeros())).with_hand(grasp, start);
    bench.close();
    let expected = theta.cos() * (DIAMETER + CLEARANCE - DIAMETER * theta.cos()) / theta.sin();
    // Down by 9 mm, 2 mm more than it can: it is pushed by 0.4 N.
    for _ in 0..450 {
        bench.hands[0].2.translation.z -= 2e-5;
        bench.tick();
    }
    bench.run(0.1);
    let pose = bench.world.body().pose;
    let corner = pose * nalgebra::Point3::new(0.5 * DIAMETER, 0.0, -0.5 * LENGTH);
    let force = bench.world.plate_force();
    assert!((0.2..0.6).contains(&force.z), "{force}");
    // The edge bears the push by the sine of theta, and the wall bears the edge: both yield, and the grasp turns.
    let press = force.z / theta.sin();
    let turned = press * expected / 200.0;
    let give = 2.0 * press / stiffness / theta + turned / theta * expected;
    let depth = -corner.z;
    assert!((expected - 1e-5..expected + 1.5 * give).contains(&depth), "{depth} m, {expected} m, {give} m");
}

#[test]
fn a_peg_that_is_dropped_askew_onto_a_hole_gains_no_energy() {
    for seed in 0..5 {
        let turn = UnitQuaternion::from_euler_angles(0.05 * f64::from(seed), 0.1, 0.3);
        let plate = Plate::at(Pose::from_parts(Vector3::zeros().into(), turn)).with_hole(hole(1e-3));
        let drop = at(1e-3 * f64::from(seed), 5e-4, 0.5 * LENGTH + 5e-3);
        let tilted = drop * Pose::new(Vector3::zeros(), Vector3::x() * (0.1 * FRAC_PI_4));
        let peg = Body::peg(MASS, DIAMETER, LENGTH).at(tilted);
        let world = World::new(&peg).and_then(|world| world.with_plate(plate)).expect("a world");
        let bench = Bench::new(world).with_hand(Grasp::new(1.0, 1.0), at(0.0, 0.0, 1.0));
        let start = bench.world.energy();
        let mut least = start;
        for _ in 0..100 {
            bench.tick();
            let energy = bench.world.energy();
            // In flight energy is constant to the error of the steps; in contact it only falls.
            assert!(
                energy < least + 1e-3 * MASS * GRAVITY * LENGTH,
                "{energy} J after {least} J, seed {seed}"
            );
            least = least.min(energy);
        }
        assert!(least < start, "seed {seed}");
    }
}

#[test]
fn plates_that_cannot_be_are_refused() {
    let refused = |plate: Plate| {
        let world = World::empty().with_plate(plate);
        world.err().map(|error| error.to_string()).unwrap_or_default()
    };
    let plate = || Plate::at(Pose::identity());
    assert!(refused(plate().with_hole(Hole { diameter: 0.0, ..hole(0.0) })).contains("diameter"));
    assert!(refused(plate().with_hole(Hole { chamfer: -1.0, ..hole(0.0) })).contains("chamfer"));
    assert!(refused(plate().with_hole(hole(0.03))).contains("floor"));
    assert!(refused(plate().with_friction(f64::NAN)).contains("friction"));
    assert!(refused(plate().with_stiffness(0.0, 1.0)).contains("stiffness"));
    let beside = Hole { at: [0.01, 0.0], ..hole(0.0) };
    assert!(refused(plate().with_hole(hole(0.0)).with_hole(beside)).contains("between two holes"));
    assert_eq!(refused(plate().with_hole(hole(1e-3))), "");
}
