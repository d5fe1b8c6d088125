//! The force law at a surface, against the equations of motion that it stands for.
//!
//! An axis with the reciprocal damping `b` and the inertia `m` that meets a spring `K` is a mass on a spring and a damper,
//! `m z'' + z' / b + K z = F_d` in contact and `= v / b` where it is guarded; without contact `m z'' + z' / b` is all there is.

use mrroc::generator::Generator;
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc::robot::{RobotImage, RobotState};
use mrroc::sensor::SensorImage;
use mrroc_generators::force::{Behaviour, Bound, ForceControl, Give};
use mrroc_generators::generators::ForceLaw;
use mrroc_robots::{Irp6, Six};
use nalgebra::Vector3;

const STIFFNESS: f64 = 2000.0;
const LOAD: f64 = 10.0;
const SPEED: f64 = 0.02;
const GIVE: Give = Give { reciprocal_damping: 0.005, inertia: 20.0 };

struct Wrist;

impl Sensor for Wrist {
    const KIND: &'static str = "wrist";
    type Reading = Wrench;
    type Configuration = ();
}

/// `z` of `m z'' + z' / b + K z = F` from rest at 0: under-damped here.
fn struck(force: f64, t: f64) -> f64 {
    let (b, m) = (GIVE.reciprocal_damping, GIVE.inertia);
    let (decay, square) = (0.5 / (b * m), STIFFNESS / m);
    let w = (square - decay * decay).sqrt();
    force / STIFFNESS * (1.0 - (-decay * t).exp() * ((w * t).cos() + decay / w * (w * t).sin()))
}

/// Displacements along the tool's axes after each step, with springs at 0 along y and z, and none along x; the tool points down.
fn pressed(dt: f64, steps: u32) -> Vec<Vector3<f64>> {
    let still = Behaviour::Unguarded { velocity: 0.0 };
    let axes = [
        Behaviour::Unguarded { velocity: SPEED },
        Behaviour::Guarded { velocity: SPEED, give: GIVE },
        Behaviour::Contact { load: LOAD, give: GIVE, within: Bound { speed: 1.0, travel: 1.0 } },
        still,
        still,
        still,
    ];
    let law = ForceControl::new(axes).expect("in range");
    let mut generator = ForceLaw::<Irp6, Wrist>::lasting(law, f64::INFINITY, 1);
    let start = Pose::new(Vector3::new(0.8, 0.1, 0.3), Vector3::x() * std::f64::consts::PI);
    let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose: start };
    let (e, c0) = (State::new(RobotImage::new(state, state)), Order::new(()));
    let (mut displacement, mut trace) = (Vector3::<f64>::zeros(), vec![Vector3::zeros()]);
    for i in 0..steps {
        let push = -STIFFNESS * Vector3::new(0.0, displacement.y.max(0.0), displacement.z.max(0.0));
        let v = Reading::new((SensorImage::<Wrist>::new(Wrench::new(push, Vector3::zeros()), 0),));
        let t = Tick { step: i.into(), dt, duration: dt };
        let step = match i {
            0 => generator.first_step(&c0, &e, &v, t),
            _ => Generator::next_step(&mut generator, &c0, &e, &v, t),
        };
        let Ok(Step::Next(demand)) = step else { panic!("{step:?}") };
        let demand: Demand<Irp6> = demand;
        displacement = start.inv_mul(&demand.as_pose().expect("a pose")).translation.vector;
        trace.push(displacement);
    }
    trace
}

/// Farthest from the equations over a second, along each axis \[m\].
fn error(dt: f64) -> Vector3<f64> {
    let steps = (1.0 / dt).round() as u32;
    let apart = |(i, displacement): (usize, &Vector3<f64>)| {
        let t = i as f64 * dt;
        let expected = Vector3::new(SPEED * t, struck(SPEED / GIVE.reciprocal_damping, t), struck(LOAD, t));
        (displacement - expected).abs()
    };
    pressed(dt, steps).iter().enumerate().map(apart).fold(Vector3::zeros(), |most, x| most.sup(&x))
}

#[test]
fn contact_and_guard_are_a_mass_on_a_spring_and_a_damper_and_the_unguarded_axis_feels_nothing() {
    let (coarse, fine) = (error(2e-3), error(1e-3));
    // Of 5 mm and 2 mm at which the springs come to rest.
    assert!(
        coarse.z < 0.02 * LOAD / STIFFNESS && coarse.y < 0.02 * SPEED / GIVE.reciprocal_damping / STIFFNESS,
        "{coarse}"
    );
    assert!(coarse.x < 1e-12 && fine.x < 1e-12, "{coarse}");
    // Of the first order in the step: half the step, half the error.
    for axis in [1, 2] {
        let ratio = coarse[axis] / fine[axis];
        assert!((1.8..2.2).contains(&ratio), "{ratio} along {axis}");
    }
}

#[test]
fn at_rest_the_contact_has_its_load_and_the_guard_the_speed_over_the_damping() {
    let end = pressed(2e-3, 5000)[5000] * STIFFNESS;
    assert!((end.z - LOAD).abs() < 1e-6 && (end.y - SPEED / GIVE.reciprocal_damping).abs() < 1e-6, "{end}");
}
