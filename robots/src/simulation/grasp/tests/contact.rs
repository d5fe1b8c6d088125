//! A block on a table: weight, friction, impact.

use nalgebra::{UnitQuaternion, Vector3};

use super::Bench;
use super::bench::at;
use crate::models::GRAVITY;
use crate::simulation::grasp::{Body, Grasp, Table, World};

const MASS: f64 = 2.0;

/// A block on a table at z = 0, in a world whose "down" leans by `slope` towards x.
fn on_slope(slope: f64, friction: f64) -> Bench {
    let down = Vector3::new(slope.sin(), 0.0, -slope.cos()) * GRAVITY;
    let body = Body::block(MASS, [0.2, 0.2, 0.1]).at(at(0.0, 0.0, 0.05));
    let table = Table::at(0.0).with_friction(friction);
    let world = World::new(&body).and_then(|world| world.with_table(table)).expect("a world");
    let bench = Bench::new(world.with_gravity(down)).with_hand(Grasp::new(1.0, 1.0), at(0.0, 0.0, 1.0));
    bench.run(1.0);
    bench
}

#[test]
fn a_block_on_a_level_table_rests_with_its_weight_on_it() {
    let bench = on_slope(0.0, 0.4);
    let force = bench.world.table_force();
    assert!((force - Vector3::new(0.0, 0.0, MASS * GRAVITY)).amax() < 1e-6, "{force}");
    let depth = 0.05 - bench.world.body().pose.translation.z;
    assert!((depth - MASS * GRAVITY / 8e4).abs() < 1e-9, "{depth}");
}

#[test]
fn within_the_friction_cone_a_block_stays_where_it_is() {
    let slope = 0.38_f64.atan();
    let bench = on_slope(slope, 0.4);
    let before = bench.world.body().pose.translation.vector;
    bench.run(10.0);
    let crept = (bench.world.body().pose.translation.vector - before).norm();
    assert!(crept < 1e-9, "{crept} m");
    let force = bench.world.table_force();
    assert!((force.x / force.z + slope.tan()).abs() < 1e-6, "{force}");
}

#[test]
fn beyond_the_friction_cone_a_block_slides_with_the_acceleration_that_is_left() {
    let slope = 0.6_f64.atan();
    let bench = on_slope(slope, 0.4);
    let (before, from) = (bench.world.body().velocity.x, bench.world.time());
    for _ in 0..250 {
        bench.tick();
        let force = bench.world.table_force();
        assert!(force.xy().norm() <= 0.4 * force.z * (1.0 + 1e-12), "{force}");
    }
    let acceleration = (bench.world.body().velocity.x - before) / (bench.world.time() - from);
    let expected = GRAVITY * (slope.sin() - 0.4 * slope.cos());
    assert!((acceleration / expected - 1.0).abs() < 1e-3, "{acceleration} for {expected}");
}

#[test]
fn a_dropped_block_tumbles_without_gaining_energy_and_comes_to_rest() {
    for seed in 0..6 {
        let turn = UnitQuaternion::from_euler_angles(0.3 * f64::from(seed), 0.5, -0.2 * f64::from(seed));
        let pose = nalgebra::Isometry3::from_parts(at(0.0, 0.0, 0.35).translation, turn);
        let body = Body::block(MASS, [0.3, 0.2, 0.1]).at(pose);
        let world = World::new(&body).and_then(|world| world.with_table(Table::at(0.0))).expect("a world");
        let bench = Bench::new(world).with_hand(Grasp::new(1.0, 1.0), at(0.0, 0.0, 1.0));
        bench.world.push(Vector3::new(0.5, 0.2, 0.0), Vector3::new(1.0, -3.0, 2.0));
        let mut highest = bench.world.energy();
        for _ in 0..3000 {
            bench.tick();
            let energy = bench.world.energy();
            // Leapfrog's bound on what springs store, 0.25 %.
            assert!(energy < highest * 1.0025, "seed {seed}: {energy} after {highest}");
            highest = highest.min(energy.max(0.0));
        }
        let state = bench.world.body();
        assert!(
            state.velocity.norm() < 1e-6 && state.angular_velocity.norm() < 1e-5,
            "seed {seed}: {state:?}"
        );
    }
}
