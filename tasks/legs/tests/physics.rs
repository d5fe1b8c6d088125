//! The machine satisfies mechanics: momenta, statics, friction.

use legs::ground::Ground;
use legs::leg::{GRAVITY, Leg, Three};
use legs::places::{hip, start};
use legs::plant::trunk::Sums;
use legs::plant::{PERIOD, World};
use mrroc::pose::Pose;
use nalgebra::{Matrix3, Vector3};

fn legs() -> [Leg; 4] {
    core::array::from_fn(|i| Leg::at(hip(i)))
}

fn world(height: f64, friction: f64, q: [Three; 4]) -> World {
    World::new(legs(), Ground::level(), friction, Pose::translation(0.0, 0.0, height), q)
}

#[test]
fn in_the_air_the_centre_of_mass_falls_on_a_parabola_whatever_the_legs_do() {
    let mut world = world(5.0, 0.5, start());
    let first = world.standing().centre;
    for k in 1..=300 {
        let t = f64::from(k) * PERIOD;
        for (leg, q) in start().into_iter().enumerate() {
            let swing = 0.3 * (9.0 * t + leg as f64).sin() * (1.0 - (-t / 0.05).exp());
            world.begin(leg);
            world.end(leg, q + Three::new(0.3 * swing, swing, -swing));
        }
    }
    let t = 300.0 * PERIOD;
    let now = world.standing();
    let fallen = first - Vector3::z() * (0.5 * GRAVITY * t * t);
    assert!((now.centre - fallen).norm() < 2e-6, "{} {fallen}", now.centre);
    // The legs have turned the trunk.
    assert!(now.lean() > 1e-3, "{}", now.lean());
}

#[test]
fn the_sums_over_the_bodies_are_those_of_a_rigid_body_where_the_legs_are_locked() {
    let q = start();
    let sums = Sums::of(&legs(), &q, &[Three::zeros(); 4]);
    assert!((sums.M - 28.4).abs() < 1e-12 && sums.U == Vector3::zeros() && sums.K == Vector3::zeros());
    // Momenta of a turn about the centre of mass: no momentum, and I omega of angular momentum.
    let omega = Vector3::new(0.1, -0.2, 0.3);
    let v = -omega.cross(&sums.centre());
    let c = sums.centre();
    let inertia = sums.J - (Matrix3::identity() * c.norm_squared() - c * c.transpose()) * sums.M;
    let (told_v, told_omega) = sums.twist(&Vector3::zeros(), &(inertia * omega));
    assert!((told_v - v).norm() < 1e-12 && (told_omega - omega).norm() < 1e-12);
}

/// Settles for a while, with the legs locked.
fn settled(mut world: World, seconds: f64) -> World {
    for _ in 0..(seconds / PERIOD) as usize {
        world.stand();
    }
    world
}

#[test]
fn on_three_feet_the_forces_are_those_of_statics() {
    let mut q = start();
    // One foot is 30 mm up.
    let leg = Leg::at(hip(1));
    let up = leg.foot(&q[1]) + Vector3::z() * 0.03;
    q[1] = leg.reach_for(&up, &q[1]).expect("in reach");
    // It leans to the others, whose feet hold the centre of mass.
    let mut world = world(0.42, 0.8, q);
    for k in 0..500 {
        let share = (f64::from(k) / 400.0).min(1.0);
        for (i, q) in q.iter().enumerate() {
            let foot = legs()[i].foot(q) - Vector3::new(0.03, 0.06, 0.0) * share;
            let moved = legs()[i].reach_for(&foot, q).expect("in reach");
            world.begin(i);
            world.end(i, moved);
        }
    }
    let world = settled(world, 8.0);
    let now = world.standing();
    assert!(!now.bears(1) && !now.has_fallen() && now.margin() > 0.02, "{now:?}");
    // Moments about the x and y axes through the centre of mass, and the weight; friction acts at the height of the feet.
    let rows = [0, 2, 3].map(|i| {
        let at = now.feet[i] - now.centre;
        Vector3::new(1.0, at.x, at.y)
    });
    let up =
        Matrix3::from_columns(&rows).try_inverse().expect("no line") * Vector3::new(28.4 * GRAVITY, 0.0, 0.0);
    for (told, i) in up.iter().zip([0, 2, 3]) {
        assert!((now.forces[i].z / told - 1.0).abs() < 2e-3, "{} {told}", now.forces[i].z);
    }
}

#[test]
fn it_slides_on_ice_and_stands_on_rubber() {
    let push = |friction: f64| {
        let mut world = world(0.4192, friction, start());
        // All feet are moved against the trunk, hard: 0.1 m in 0.1 s.
        for k in 1..=50 {
            let share = f64::from(k) / 50.0;
            for (i, q) in start().into_iter().enumerate() {
                let foot = legs()[i].foot(&q) - Vector3::x() * (0.1 * share * share);
                world.begin(i);
                world.end(i, legs()[i].reach_for(&foot, &q).expect("in reach"));
            }
        }
        settled(world, 0.5).standing()
    };
    let (ice, rubber) = (push(0.05), push(3.0));
    assert!(ice.slid[0] > 0.08, "{:?}", ice.slid);
    assert!(rubber.X_WT.translation.x > 0.05, "{}", rubber.X_WT.translation.x);
}
