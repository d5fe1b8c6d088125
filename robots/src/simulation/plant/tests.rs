//! No plant creates energy: the balance of every integration step, and what it says of a servo period.
//!
//! The balance is taken from the motors' data and from what the shaft did, not from the plant's coefficients: friction is
//! what is missing of the torque, and must be friction.

use proptest::prelude::*;

use super::{H, PEAK, Plant, SUPPLY};
use crate::models::{Conveyor, Gripper, Irp6, Irp6Track, MotorData, Overload, Polycrank, Rnt};
use crate::simulation::Regulator;

/// Every motor of every robot.
fn motors() -> Vec<MotorData> {
    let mut all = Irp6::MOTORS.to_vec();
    all.extend([Irp6Track::TRACK_MOTOR, Polycrank::MOTOR, Gripper::MOTOR, Conveyor::MOTOR]);
    all.extend(Rnt::MOTORS);
    all
}

fn kinetic(data: &MotorData, speed: f64) -> f64 {
    0.5 * data.inertia * speed * speed
}

/// A plant whose shaft turns.
fn turning(data: &MotorData, speed: f64) -> Plant {
    Plant { speed, ..Plant::at_rest(data, 0.0) }
}

/// One integration step: the electrical, frictional and mechanical energy in it [J] sum up to the change of the kinetic one.
fn check_step(data: &MotorData, plant: &mut Plant, pwm: f64, load: f64) {
    let MotorData { resistance, torque_constant: k, inertia, viscous, coulomb, .. } = *data;
    let (before, at) = (plant.speed(), plant.angle());
    plant.step(pwm, load);
    let (speed, current, turned) = (plant.speed(), plant.current(), plant.angle() - at);
    // Round-off of everything that is summed up below.
    let torques = k * current.abs() + load.abs() + coulomb + viscous * speed.abs();
    let round_off = 1e-12 * (torques + inertia * (speed.abs() + before.abs()) / H);
    assert!((turned - H * speed).abs() <= 1e-15 + 4.0 * f64::EPSILON * plant.angle().abs());

    // The amplifier: full voltage, or less of it at the current's limit; it takes no more than it is given.
    let voltage = SUPPLY * pwm / Regulator::PWM;
    let at_motor = resistance * current + k * speed;
    let peak = if data.overload == Overload::Trip { PEAK * data.current_limit } else { data.current_limit };
    assert!(current.abs() <= peak);
    if current.abs() < peak {
        assert!((voltage - at_motor).abs() <= 1e-9, "{voltage} V, {at_motor} V at the motor");
    }
    let input = H * voltage * current;
    assert!(H * at_motor * current <= input + 1e-12 * (1.0 + input.abs()));

    // Friction is what is missing: never more than it can be, never with the motion.
    let friction = k * current - viscous * speed - load - inertia * (speed - before) / H;
    assert!(friction.abs() <= coulomb + round_off, "friction {friction} of {coulomb} N m");
    assert!(speed == 0.0 || friction * speed >= -round_off * speed.abs(), "friction drives");

    let losses = H * (resistance * current * current + viscous * speed * speed + friction * speed);
    let gained = kinetic(data, speed) - kinetic(data, before);
    let balance = gained - (H * at_motor * current - losses - H * load * speed);
    let lost_by_integration = kinetic(data, speed - before);
    let scale = round_off * H * (speed.abs() + before.abs() + 1.0);
    assert!((balance + lost_by_integration).abs() <= scale, "{balance} J, {lost_by_integration} J");
    // And the loss is of second order: the torques together change the speed by no more than this.
    let change = H * (k * current.abs() + load.abs() + coulomb + viscous * speed.abs()) / inertia;
    assert!(lost_by_integration <= kinetic(data, change) * (1.0 + 1e-9) + scale);
}

#[test]
fn every_motor_keeps_the_balance_pushed_loaded_and_at_full_voltage() {
    for data in motors() {
        let fastest = SUPPLY / data.torque_constant;
        let stall = data.torque_constant * data.current_limit;
        for pwm in [0.0, 1.0, -40.0, 255.0, -255.0] {
            for load in [0.0, 0.3 * stall, -0.3 * stall, 4.0 * stall] {
                for push in [0.0, 0.5 * fastest, -fastest] {
                    let mut plant = turning(&data, push);
                    for _ in 0..400 {
                        check_step(&data, &mut plant, pwm, load);
                    }
                }
            }
        }
    }
}

#[test]
fn a_servo_period_gains_no_more_than_it_is_given() {
    for data in motors() {
        let mut plant = Plant::at_rest(&data, 0.0);
        for k in 0..500_u32 {
            let pwm = 255.0 * (f64::from(k) * 0.05).sin();
            let load = 0.2 * data.torque_constant * data.current_limit * (f64::from(k) * 0.013).cos();
            let (before, at) = (kinetic(&data, plant.speed()), plant.angle());
            // The current falls with the speed, so the sum over the steps is bounded by the voltage times the charge.
            let mut input = 0.0;
            let mut steps = plant;
            for _ in 0..Plant::SUBSTEPS {
                steps.step(pwm, load);
                input += H * SUPPLY * pwm / Regulator::PWM * steps.current();
            }
            plant.run(pwm, load);
            assert_eq!(plant, steps);
            let gained = kinetic(&data, plant.speed()) - before;
            let given = input - load * (plant.angle() - at);
            assert!(gained <= given + 1e-12 * (1.0 + input.abs()), "{gained} J of {given} J");
        }
    }
}

#[test]
fn a_brake_only_takes_energy_and_a_jammed_shaft_has_none() {
    for data in motors() {
        let mut plant = turning(&data, 0.7 * SUPPLY / data.torque_constant);
        for _ in 0..3000 {
            let before = plant;
            plant.brake();
            assert!(plant.speed().abs() <= before.speed().abs() && plant.current() == 0.0);
            // Equal deceleration: never faster than it began, never slower than it ends.
            let turned = plant.angle() - before.angle();
            assert!(turned >= 0.0 && turned <= 0.002 * before.speed().abs() + 1e-9);
        }
        assert_eq!(plant.speed(), 0.0, "0.7 of its top speed is braked in 6 s");
        let mut plant = turning(&data, 100.0);
        plant.set_jammed(true);
        for pwm in [0.0, 255.0, -255.0] {
            plant.run(pwm, 1.0);
            assert_eq!((plant.angle(), plant.speed()), (0.0, 0.0));
            // All that comes in becomes heat: what the amplifier gives at standstill.
            let voltage = data.resistance * plant.current();
            assert!(voltage.abs() <= SUPPLY * f64::abs(pwm) / Regulator::PWM * (1.0 + 1e-12));
        }
    }
}

proptest! {
    #[test]
    fn a_motor_in_short_circuit_without_load_never_gets_faster(
        index in 0..16_usize, speed in -1e4..1e4_f64, periods in 1..200_usize
    ) {
        let data = motors()[index % motors().len()];
        let mut plant = turning(&data, speed);
        for _ in 0..periods {
            let before = plant.speed();
            plant.run(0.0, 0.0);
            prop_assert!(plant.speed().abs() <= before.abs());
            prop_assert!(plant.speed() * before >= 0.0, "it turns back");
        }
    }

    #[test]
    fn the_balance_holds_for_any_motor(
        resistance in 0.1..100.0_f64,
        torque_constant in 1e-3..1.0_f64,
        inertia in -7.0..-1.0_f64,
        viscous in 0.0..1e-2_f64,
        coulomb in 0.0..1.0_f64,
        current_limit in 0.1..30.0_f64,
        trips: bool,
        speed in -1e3..1e3_f64,
        pwm in -255.0..255.0_f64,
        load in -5.0..5.0_f64,
    ) {
        let overload = if trips { Overload::Trip } else { Overload::Limit };
        let inertia = 10_f64.powf(inertia);
        let data = MotorData {
            resistance, torque_constant, inertia, viscous, coulomb, current_limit, overload, ..MotorData::DISC
        };
        let mut plant = turning(&data, speed);
        for _ in 0..20 {
            check_step(&data, &mut plant, pwm, load);
        }
    }
}
