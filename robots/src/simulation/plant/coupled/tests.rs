//! Coupled motors keep the equation of motion in every step: its residual, by recursive Newton-Euler, is friction.

use mrroc::random::Random;
use nalgebra::SVector;

use super::super::{H, Plant};
use super::Coupling;
use crate::dynamics::Tree;
use crate::models::{Driven, Polycrank, Serial};

fn weighted() -> Serial<6> {
    Serial::<6>::from_urdf(
        include_str!("../../../../tests/reference/urdf/weighted_arm.urdf"),
        "base_link",
        "tool0",
    )
    .and_then(|builder| builder.with_acceleration(SVector::repeat(10.0)))
    .expect("the URDF is sound")
}

/// What is left of the equation of motion in one step of a robot whose gears are the same in every posture.
fn keeps_its_equation<const N: usize>(robot: &impl Driven<N>, tree: &Tree<N>) {
    let mut random = Random::seeded(1955);
    let (mut stood, mut limited) = (0, 0);
    for k in 0..2000 {
        // Every third time from near rest, with little voltage, so that friction holds some.
        let size = if k % 3 == 0 { 1e-3 } else { 1.0 };
        let speed = robot.motor_limits().speed;
        let q = SVector::<f64, N>::from_fn(|_, _| random.within(1.0));
        let angles = robot.motors(&q);
        let data = robot.motor_data();
        let mut plants: [Plant; N] = core::array::from_fn(|i| Plant::at_rest(&data[i], angles[i]));
        plants.iter_mut().for_each(|plant| plant.speed = speed * size * random.within(1.0));
        plants[0].jammed = k % 5 == 0;
        let before = SVector::<f64, N>::from_fn(|i, _| plants[i].speed);
        let pwm: [f64; N] = core::array::from_fn(|_| 255.0 * size.sqrt() * random.within(1.0));
        let loads = SVector::<f64, N>::from_fn(|i, _| data[i].coulomb * random.within(1.0));
        let mut coupling = Coupling::of(robot).expect("it has links");
        coupling.follow(robot, &plants);
        coupling.step(robot, &mut plants, &pwm, &loads);

        let ratios = robot.ratios(&angles);
        let after = SVector::<f64, N>::from_fn(|i, _| plants[i].speed);
        let change = (after - before) / H;
        let torques = tree.inverse_dynamics(&q, &(ratios * before), &(ratios * change), None);
        let links = ratios.tr_mul(&torques);
        for i in 0..N {
            let motor = data[i].torque_constant * plants[i].current;
            let friction =
                motor - data[i].viscous * after[i] - loads[i] - links[i] - robot.rotors()[i] * change[i];
            let scale = 1e-9 * (motor.abs() + links[i].abs() + robot.rotors()[i] * change[i].abs());
            assert!((plants[i].angle - angles[i] - H * after[i]).abs() < 1e-9, "it turns by its speed");
            if plants[i].jammed {
                assert_eq!(after[i], 0.0);
                continue;
            }
            assert!(friction.abs() <= data[i].coulomb + scale, "{friction} of {} N m", data[i].coulomb);
            if after[i] == 0.0 {
                stood += 1;
            } else {
                let off = friction - data[i].coulomb.copysign(after[i]);
                assert!(off.abs() <= scale, "motor {i}: {off} N m of {scale}");
            }
            limited += u32::from(plants[i].current.abs() == plants[i].model.peak);
        }
    }
    assert!(stood > 50 && limited > 100, "{stood} stood, {limited} had their current limited");
}

#[test]
fn coupled_motors_keep_the_equation_of_motion() {
    let robot = weighted();
    keeps_its_equation(&robot, &robot.tree().expect("it has links"));
    let robot = Polycrank::new();
    keeps_its_equation(&robot, &robot.tree().expect("it has links"));
}

#[test]
fn an_arm_without_voltage_swings_down_and_its_energy_with_it() {
    // Motors short-circuited by an amplifier at zero: resistance and friction take what the weight gives, about which a step errs
    // by a part of its length.
    let robot = weighted();
    let tree = robot.tree().expect("it has links");
    let q = SVector::from([0.0, 0.4, 0.6, 0.3, 0.8, 0.0]);
    let angles = robot.motors(&q);
    let data = robot.motor_data();
    let mut plants: [Plant; 6] = core::array::from_fn(|i| Plant::at_rest(&data[i], angles[i]));
    let mut coupling = Coupling::of(&robot).expect("it has links");
    let state = |plants: &[Plant; 6]| {
        let angles = SVector::<f64, 6>::from_fn(|i, _| plants[i].angle);
        let speeds = SVector::<f64, 6>::from_fn(|i, _| plants[i].speed);
        let (q, v) = (robot.positions(&angles), robot.ratios(&angles) * speeds);
        let rotors: f64 = (0..6).map(|i| 0.5 * robot.rotors()[i] * speeds[i] * speeds[i]).sum();
        (tree.kinetic_energy(&q, &v) + rotors + tree.potential_energy(&q), speeds)
    };
    let (start, _) = state(&plants);
    let (mut lost, mut worst) = (0.0, 0.0_f64);
    for _ in 0..4000 {
        coupling.step(&robot, &mut plants, &[0.0; 6], &SVector::zeros());
        let (energy, speeds) = state(&plants);
        for i in 0..6 {
            let current = plants[i].current;
            lost += H
                * (data[i].resistance * current * current
                    + data[i].viscous * speeds[i] * speeds[i]
                    + data[i].coulomb * speeds[i].abs());
        }
        worst = worst.max((start - energy - lost).abs());
    }
    println!("{lost:.3} J lost, the balance is off by {worst:.4} J");
    assert!(lost > 1.0 && worst < 0.02 * lost, "{lost} J, {worst} J");
}
