//! Motion: frequencies, momentum, energy, against the equations of rigid bodies.

use core::f64::consts::{PI, TAU};

use mrroc::pose::AngleAxis;
use nalgebra::{Matrix3, Vector3};

use super::Bench;
use super::bench::{at, weightless};
use crate::models::GRAVITY;
use crate::simulation::grasp::{Body, BodyState, Grasp, World};

fn held(body: &Body, grasp: Grasp) -> Bench {
    let bench = Bench::new(weightless(World::new(body).expect("a body")))
        .with_hand(grasp, at(-0.3, 0.0, 0.0))
        .with_hand(grasp, at(0.3, 0.0, 0.0));
    bench.close();
    bench
}

/// The time of `count` periods of a coordinate that starts at 0 and rises, between interpolated zeros.
fn period(bench: &Bench, count: u32, coordinate: impl Fn(&BodyState) -> f64) -> f64 {
    let (mut last, mut rising, mut first) = (0.0, 0, 0.0);
    loop {
        let before = bench.world.time();
        bench.tick();
        let now = coordinate(&bench.world.body());
        if last < 0.0 && now >= 0.0 {
            let zero = before + (bench.world.time() - before) * last / (last - now);
            rising += 1;
            if rising == 1 {
                first = zero;
            }
            if rising == count + 1 {
                return (zero - first) / f64::from(count);
            }
        }
        last = now;
    }
}

#[test]
fn a_body_on_two_grasps_swings_with_the_frequencies_of_their_springs() {
    let mass = 4.0;
    let body = Body::block(mass, [0.6, 0.2, 0.1]);
    let grasp = Grasp::new(2e3, 40.0).with_damping(0.0, 0.0);
    let bench = held(&body, grasp);
    bench.world.push(Vector3::new(0.01, 0.0, 0.0), Vector3::zeros());
    let along = period(&bench, 20, |body| body.pose.translation.x);
    let expected = TAU * (mass / 4e3).sqrt();
    assert!((along / expected - 1.0).abs() < 1e-3, "{along} for {expected}");

    let bench = held(&body, grasp);
    bench.world.push(Vector3::zeros(), Vector3::new(0.05, 0.0, 0.0));
    let about = period(&bench, 20, |body| body.pose.rotation.scaled_axis().x);
    let inertia = mass / 12.0 * (0.04 + 0.01);
    let expected = TAU * (inertia / 80.0_f64).sqrt();
    assert!((about / expected - 1.0).abs() < 1e-3, "{about} for {expected}");

    // About z the springs' levers help: kappa + k a^2 each.
    let bench = held(&body, grasp);
    bench.world.push(Vector3::zeros(), Vector3::new(0.0, 0.0, 0.01));
    let about = period(&bench, 20, |body| body.pose.rotation.scaled_axis().z);
    let inertia = mass / 12.0 * (0.36 + 0.04);
    let expected = TAU * (inertia / (2.0 * (40.0 + 2e3 * 0.09))).sqrt();
    assert!((about / expected - 1.0).abs() < 1e-3, "{about} for {expected}");
}

#[test]
fn a_damped_swing_decays_as_its_damping_says() {
    let (mass, k, c) = (4.0, 2e3, 4.0);
    let body = Body::block(mass, [0.6, 0.2, 0.1]);
    let bench = held(&body, Grasp::new(k, 40.0).with_damping(c, 0.1));
    bench.world.push(Vector3::new(0.01, 0.0, 0.0), Vector3::zeros());
    bench.run(2.0);
    // x = v / w exp(-d t) sin(w t), d = 2 c / 2 m, w^2 = 2 k / m - d^2.
    let d = c / mass;
    let w = (2.0 * k / mass - d * d).sqrt();
    // The last tick only begins the period that ends at 2 s.
    let t = bench.world.time();
    let (x, expected) = (bench.world.body().pose.translation.x, 0.01 / w * (-d * t).exp() * (w * t).sin());
    // With steps of at most 1 ms the frequency is off by 2 d h / 4 + (w h)^2 / 24, the decay by d (d h).
    let h = 1e-3;
    let off = (0.5 * d * h + (w * h).powi(2) / 24.0) * w * t + d * d * h * t;
    assert!((x - expected).abs() < 0.01 / w * (-d * t).exp() * off, "{x} for {expected}");
}

#[test]
fn stiff_springs_on_a_light_body_create_no_energy() {
    // From 0.5 kg to 10 kg, held by grasps of 5e4 N/m and 500 N m/rad without damping, and with much of it.
    for mass in [0.5, 2.0, 10.0] {
        for damping in [(0.0, 0.0), (100.0, 1.0), (1000.0, 10.0)] {
            let body = Body::block(mass, [0.5, 0.08, 0.05]);
            let bench = held(&body, Grasp::new(5e4, 500.0).with_damping(damping.0, damping.1));
            bench.world.push(Vector3::new(0.1, -0.2, 0.3), Vector3::new(2.0, -1.0, 1.5));
            let began = bench.world.energy();
            let mut highest = 0.0_f64;
            for _ in 0..2000 {
                bench.tick();
                highest = highest.max(bench.world.energy());
            }
            // Leapfrog conserves an energy that differs from the true one by (w h)^2 / 4 at most, 0.25 %.
            assert!(highest / began < 1.0025, "{mass} kg, {damping:?}: {}", highest / began);
            let left = bench.world.energy() / began;
            if damping.0 == 0.0 {
                assert!((left - 1.0).abs() < 5e-3, "{mass} kg: {left}");
            } else {
                assert!(left < 1e-6, "{mass} kg, {damping:?}: {left}");
            }
        }
    }
}

/// `R I R^T omega`.
fn angular_momentum(inertia: &Matrix3<f64>, state: &BodyState) -> Vector3<f64> {
    let rotation = state.pose.rotation.to_rotation_matrix();
    rotation * (inertia * (rotation.inverse() * state.angular_velocity))
}

#[test]
fn free_flight_keeps_both_momenta_and_follows_the_parabola() {
    let inertia = Matrix3::new(0.05, 0.01, -0.004, 0.01, 0.03, 0.002, -0.004, 0.002, 0.06);
    let body = Body::new(2.0, inertia);
    let bench =
        Bench::new(World::new(&body).expect("a body")).with_hand(Grasp::new(1.0, 1.0), at(0.0, 0.0, 0.0));
    let (v, omega) = (Vector3::new(0.5, -0.2, 3.0), Vector3::new(2.0, 3.0, -1.0));
    bench.world.push(v, omega);
    let (l, e) = (angular_momentum(&inertia, &bench.world.body()), bench.world.energy());
    bench.run(2.0);
    let (t, state) = (bench.world.time(), bench.world.body());
    let expected = v * t - Vector3::z() * (0.5 * GRAVITY * t * t);
    assert!((state.pose.translation.vector - expected).amax() < 1e-10);
    assert!((state.velocity - (v - Vector3::z() * (GRAVITY * t))).amax() < 1e-11);
    let now = angular_momentum(&inertia, &state);
    assert!((now - l).amax() < 1e-14 * 1e2, "{now} for {l}");
    assert!((bench.world.energy() / e - 1.0).abs() < 1e-6);
}

#[test]
fn a_free_symmetric_top_precesses_as_euler_says() {
    // R(t) = exp(l t / I1) R exp(omega_3 (1 - I3 / I1) t e3) from R = 1.
    let (one, three) = (0.05, 0.02);
    let body = Body::new(2.0, Matrix3::from_diagonal(&Vector3::new(one, one, three)));
    let world = weightless(World::new(&body).expect("a body"));
    let bench = Bench::new(world).with_hand(Grasp::new(1.0, 1.0), at(0.0, 0.0, 0.0));
    let omega = Vector3::new(1.0, -0.5, 6.0);
    bench.world.push(Vector3::zeros(), omega);
    bench.run(3.0);
    let t = bench.world.time();
    let l = Vector3::new(one * omega.x, one * omega.y, three * omega.z);
    let spin = Vector3::z() * (omega.z * (1.0 - three / one) * t);
    let expected = AngleAxis(l * (t / one)).rotation() * AngleAxis(spin).rotation();
    let error = bench.world.body().pose.rotation.angle_to(&expected);
    // Second order: (omega h)^2 / 24 of some 20 rad.
    assert!(error < 20.0 * (6e-3_f64).powi(2) / 12.0, "{error} rad");
    assert!(PI > error);
}

#[test]
fn grippers_take_what_momentum_the_body_loses() {
    let edges = [0.6, 0.2, 0.1];
    let body = Body::block(4.0, edges);
    let inertia = body.inertia;
    let bench = held(&body, Grasp::new(5e4, 500.0));
    bench.world.push(Vector3::new(0.2, -0.1, 0.3), Vector3::new(1.0, 2.0, -1.5));
    let momenta = |state: &BodyState| {
        let p = 4.0 * state.velocity;
        (p, angular_momentum(&inertia, state) + state.pose.translation.vector.cross(&p))
    };
    bench.tick();
    let (mut p, mut l) = momenta(&bench.world.body());
    for _ in 0..500 {
        bench.tick();
        // Both stand without turn: their axes are the world's.
        for (hand, _, pose) in &bench.hands {
            let reaction = hand.reaction();
            p -= reaction.force * 2e-3;
            l -= (reaction.torque + pose.translation.vector.cross(&reaction.force)) * 2e-3;
        }
        let (left, turning) = momenta(&bench.world.body());
        assert!((left - p).amax() < 1e-12 && (turning - l).amax() < 1e-12, "{left} {p} {turning} {l}");
    }
    assert!(p.norm() < 0.1, "it was worth looking at: {p}");
}
