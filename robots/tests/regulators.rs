//! The regulators' parameter sets: how stiff each is, and that they change without a jump.

use std::f64::consts::TAU;

use mrroc::prelude::*;
use mrroc::robot::{Driver, Regulators};
use mrroc_launch::cell_file::CellFile;
use mrroc_robots::{
    Gripper, Irp6, MotorData, Plant, Polycrank, Regulator, RegulatorSet, SimulatedIrp6, Six, simulated,
};

use crate::support::engraving;

const PERIOD: f64 = 0.002;

/// All motors that trip, without Coulomb friction, which would hold part of the load.
fn frictionless() -> Vec<MotorData> {
    let all = Irp6::MOTORS.into_iter().chain([Polycrank::MOTOR]);
    all.map(|data| MotorData { coulomb: 0.0, ..data }).collect()
}

/// A plant under its regulator, demanded to stand still.
struct Loop {
    data: MotorData,
    plant: Plant,
    regulator: Regulator,
    count: f64,
    deviation: f64,
    pwm: f64,
}

impl Loop {
    fn new(data: &MotorData, set: RegulatorSet) -> Self {
        let mut regulator = Regulator::holding(data.gains, 0.0);
        regulator.choose(set);
        Loop {
            data: *data,
            plant: Plant::at_rest(data, 0.0),
            regulator,
            count: 0.0,
            deviation: 0.0,
            pwm: 0.0,
        }
    }

    fn run(&mut self, periods: usize, load: f64) {
        for _ in 0..periods {
            self.pwm = self.regulator.step(self.deviation, 0.0);
            self.plant.run(self.pwm, load);
            let count = self.data.encoder.count(self.plant.angle());
            self.deviation = self.count - count;
            self.count = count;
        }
    }
}

/// Volts per pulse width over resistance, times the torque constant, the regulator's gain at rest and the pulses per rad.
fn stiffness(data: &MotorData) -> f64 {
    let gain = (data.gains.b0 - data.gains.b1) / (1.0 - data.gains.a);
    96.0 / 255.0 / data.resistance * data.torque_constant * gain * data.encoder.pulses / TAU
}

#[test]
fn a_lasting_load_displaces_a_springy_motor_by_its_stiffness() {
    for data in frictionless() {
        let stiffness = stiffness(&data);
        for share in [0.2, -0.4] {
            let load = share * data.torque_constant * data.current_limit;
            let mut springy = Loop::new(&data, RegulatorSet::Springy);
            springy.run(3000, load);
            let expected = -load / stiffness;
            let pulse = data.encoder.pulse();
            println!("{:.3} N m/rad: {:.4} rad, expected {expected:.4}", stiffness, springy.plant.angle());
            assert!((springy.plant.angle() - expected).abs() <= 1.5 * pulse, "{data:?}");
        }
    }
}

#[test]
fn a_lasting_load_displaces_no_motor_that_integrates() {
    for data in frictionless() {
        for set in [RegulatorSet::Usual, RegulatorSet::Soft] {
            let load = 0.4 * data.torque_constant * data.current_limit;
            let mut stiff = Loop::new(&data, set);
            stiff.run(4000, load);
            assert!(
                stiff.plant.angle().abs() <= 1.5 * data.encoder.pulse(),
                "{set:?}: {}",
                stiff.plant.angle()
            );
        }
    }
}

/// The loop gain is half, so the first answer to a sudden load is twice as far away, more or less by the damping.
#[test]
fn a_soft_motor_yields_about_twice_as_far() {
    for data in frictionless() {
        let load = 0.4 * data.torque_constant * data.current_limit;
        let farthest = |set| {
            let mut one = Loop::new(&data, set);
            (0..500).fold(0.0_f64, |most, _| {
                one.run(1, load);
                most.max(one.plant.angle().abs())
            })
        };
        let ratio = farthest(RegulatorSet::Soft) / farthest(RegulatorSet::Usual);
        assert!((1.5..2.5).contains(&ratio), "{ratio}");
    }
}

#[test]
fn no_change_of_sets_makes_the_pulse_width_jump() {
    use RegulatorSet::{Soft, Springy, Usual};
    for data in Irp6::MOTORS {
        let load = 0.3 * data.torque_constant * data.current_limit;
        for (from, to) in [
            (Usual, Soft),
            (Soft, Usual),
            (Usual, Springy),
            (Springy, Usual),
            (Soft, Springy),
            (Springy, Soft),
        ] {
            let mut one = Loop::new(&data, from);
            one.run(3000, load);
            let (before, at) = (one.pwm, one.plant.angle());
            one.regulator.choose(to);
            one.run(1, load);
            // At rest a pulse or none: the integration's step of the error that is left.
            let left = (at / data.encoder.pulse()).abs() + 0.5;
            let step = 0.02 * (data.gains.b0 - data.gains.b1) * left + 1e-9;
            assert!((one.pwm - before).abs() <= step, "{from:?} to {to:?}: {before} to {}", one.pwm);
        }
    }
}

/// Springy under a load, then usual again: the displacement is not forgotten.
#[test]
fn what_integrates_takes_back_what_the_spring_yielded() {
    for data in frictionless() {
        let load = 0.3 * data.torque_constant * data.current_limit;
        let mut one = Loop::new(&data, RegulatorSet::Springy);
        one.run(3000, load);
        assert!(one.plant.angle().abs() > 5.0 * data.encoder.pulse());
        one.regulator.choose(RegulatorSet::Usual);
        one.run(4000, load);
        assert!(one.plant.angle().abs() <= 1.5 * data.encoder.pulse(), "{}", one.plant.angle());
    }
}

#[test]
fn a_pushed_arm_yields_where_its_joint_is_springy() {
    let q = engraving();
    let push = 0.4;
    let pushed = |sets: Regulators| {
        let mut arm = SimulatedIrp6::new(Irp6::nominal(), &q);
        let shaft = arm.shaft();
        arm.choose_regulators(&sets);
        arm.push(0, push);
        for _ in 0..3000 {
            arm.tick(&q).expect("it bears that");
        }
        // The column's motor turns backwards, 158 times as far.
        (shaft.state().position - q)[0] * -158.0
    };
    let data = Irp6::MOTORS[0];
    let expected = -push / stiffness(&data);
    // Friction holds part of it, in either direction.
    let band = data.coulomb / stiffness(&data) + 1.5 * data.encoder.pulse();
    assert!((pushed(Regulators::uniform(0).with(0, 2)) - expected).abs() <= band);
    for sets in [Regulators::default(), Regulators::uniform(1), Regulators::uniform(2).with(0, 0)] {
        let off = pushed(sets);
        assert!(off.abs() <= 1.5 * data.encoder.pulse(), "{sets:?}: {off}");
    }
}

#[test]
fn an_arm_moves_through_changes_of_its_regulators() {
    let mut q = engraving();
    let mut arm = SimulatedIrp6::new(Irp6::nominal(), &q);
    let rates = Six::new(0.2, 0.05, -0.05, 0.1, 0.2, 0.1);
    for k in 0..1500_u32 {
        // Speeding up within 0.2 s; another set every 0.2 s from then on.
        q += rates * (f64::from(k) / 100.0).min(1.0) * PERIOD;
        if k % 100 == 0 {
            arm.choose_regulators(&Regulators::uniform((k / 100 % 3) as u8));
        }
        let measured = arm.tick(&q).expect("no drive trips");
        assert!((measured.position - q).amax() < 3e-3, "{}", measured.position - q);
    }
}

#[test]
fn the_sets_are_numbered_and_no_others_are_there() {
    let arm = SimulatedIrp6::new(Irp6::nominal(), &engraving());
    for joint in 0..6 {
        assert!((0..=2).all(|set| arm.has_regulator(joint, set)));
        assert!((3..=255).all(|set| !arm.has_regulator(joint, set)));
    }
    assert!(!arm.has_regulator(6, 0));
    assert_eq!(Gripper::MOTOR.gains, Irp6::MOTORS[5].gains);
}

/// Holds with the usual set, then chooses `set`.
struct Choice {
    set: u8,
    steps: u32,
}

#[generator(mp)]
fn choose(c: &mut Choice, _t: Tick) -> Step<(Irp6,)> {
    c.steps += 1;
    match c.steps {
        100.. => Step::Done,
        k => {
            Step::Next((Demand::hold().with_regulators(Regulators::uniform(if k < 50 { 0 } else { c.set })),))
        }
    }
}

#[test]
fn a_demand_chooses_the_sets_that_there_are() {
    let text = "step_ms = 2\nstop_ms = 5000\n[robots.a]\nkind = \"irp6\"\nstart = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]\n";
    let run = |set| {
        let file = CellFile::parse("cell.toml", text).expect("well-formed");
        file.cell(&simulated())
            .expect("a cell")
            .program(move |mp| {
                let mut robot = mp.robot::<Irp6>("a")?;
                mp.move_robots((&mut robot,), (), Choice { set, steps: 0 }).map(|_| ())
            })
            .run()
    };
    for set in 0..=2 {
        run(set).unwrap_or_else(|why| panic!("set {set}: {why}"));
    }
    let Err(why) = run(3) else { panic!("there is no set 3") };
    assert!(why.to_string().contains('3'), "{why}");
    println!("{why}");
}
