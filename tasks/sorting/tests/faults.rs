//! Faults of the belt and of sensors: a named fault, or a part that passes; never a wrong grasp.
//!
//! A share of the moments; `just sorting-whole` takes all of them, and more parts.

use mrroc::fault::{Name, ProcessId, Role};
use mrroc::prelude::*;
use mrroc::testing::{Case, FaultySensor, Injected, SensorFault, Sweep};
use mrroc_sensors::physics::Stuck;
use sorting::monitor::{Fate, Grip};
use sorting::plant::Plant;
use sorting::run::{Ready, Sensing, Settings};

const SPEED: f64 = 0.12;
const SEED: u64 = 3;

fn settings() -> Settings {
    Settings { sensing: Sensing::Reactive, ..Settings::one(SPEED, SEED) }
}

/// When the undisturbed run gets hold of its part \[s\], and the steps then.
fn undisturbed() -> Grip {
    let outcome = settings().run().expect("a cell");
    assert_eq!(outcome.count(Fate::Sorted), 1, "{outcome:?}");
    outcome.grips[0]
}

/// Half of the width of a pad \[m\].
const HALF_PAD: f64 = 0.012;

/// Runs, and checks that there was no wrong grasp; what became of the part, and the fault.
fn checked(ready: Ready, case: &str) -> (Fate, Option<String>) {
    let lengths: Vec<f64> = ready.parts.iter().map(|part| part.shape.length()).collect();
    let outcome = ready.run();
    let fault = outcome.report.as_ref().err().map(ToString::to_string);
    assert_eq!((outcome.count(Fate::Wrong), outcome.crashes), (0, 0), "{case}: {outcome:?}");
    for grip in &outcome.grips {
        // Within that each pad lies on the part with all of its width.
        let most = 0.5 * lengths[grip.part] - HALF_PAD;
        assert!(grip.along.abs() < most, "{case}: grasped {} m off the middle, at most {most} m", grip.along);
    }
    (outcome.fates[0], fault)
}

/// Times from when the part has passed the first barrier until it is held, every so many seconds.
fn moments(step: f64) -> impl Iterator<Item = f64> {
    let held = undisturbed().time;
    (0..).map(move |i| held - 4.0 + step * f64::from(i)).take_while(move |time| *time < held + 0.5)
}

/// A belt that goes on at a share of its speed, from moments on that are so many seconds apart, with parts of several lengths.
fn belt_changes(share: f64, seeds: &[u64], step: f64) {
    let mut passed = 0;
    for &seed in seeds {
        for time in moments(step) {
            let settings = Settings { profile: Box::leak(Box::new([(time, share)])), seed, ..settings() };
            let case = format!("seed {seed}, at {time} s");
            let (fate, fault) = checked(settings.ready().expect("a cell"), &case);
            assert_eq!(fault, None, "{case}");
            passed += usize::from(fate == Fate::Missed);
        }
    }
    assert!(passed > 0, "no part was let pass");
}

#[test]
fn fault_170_a_belt_that_stops_makes_a_missed_part_and_no_wrong_grasp() {
    belt_changes(0.0, &[SEED, 8], 1.0);
}

#[test]
fn fault_171_a_belt_that_turns_back_makes_a_missed_part_and_no_wrong_grasp() {
    belt_changes(-0.8, &[SEED, 8], 1.0);
}

/// The cell with a gate of which a barrier fails, or a finger barrier that does.
fn with_barrier(number: Option<usize>, from: f64, stuck: Stuck) -> Ready {
    let sense = move |plant: &Plant, file: &CellFile, cell: Cell| {
        let step = file.step().as_secs_f64();
        let (mut gate, mut fingers) = (plant.gate(step), plant.fingers(step));
        match number {
            Some(number) => gate.barrier(number).fail(from, stuck),
            None => fingers.barrier().fail(from, stuck),
        }
        let cell = cell.sensor(file.sensor("gate", gate)?).sensor(file.sensor("range", plant.range(step))?);
        Ok(cell.sensor(file.sensor("fingers", fingers)?))
    };
    settings().sensed_by(sense).expect("a cell")
}

/// Barriers of the gate that are dead from the beginning, or die so many seconds before the grasp.
fn barriers_die(before: &[f64]) {
    let held = undisturbed().time;
    for number in [0, 1] {
        for stuck in [Stuck::Open, Stuck::Covered] {
            let case = format!("barrier {number} {stuck:?}");
            // Dead from the beginning.
            assert_eq!(
                checked(with_barrier(Some(number), 0.0, stuck), &case),
                (Fate::Missed, None),
                "{case}"
            );
            // Dying while the part is at the gate, and after it.
            for &before in before {
                let (_, fault) = checked(with_barrier(Some(number), held - before, stuck), &case);
                assert_eq!(fault, None, "{case}");
            }
        }
    }
}

#[test]
fn fault_172_a_dead_barrier_of_the_gate_makes_missed_parts_and_no_grasp_beside_them() {
    barriers_die(&[3.5, 2.5]);
}

#[test]
fn fault_173_a_barrier_between_the_fingers_that_is_always_open_makes_missed_parts() {
    let (fate, fault) = checked(with_barrier(None, 0.0, Stuck::Open), "open");
    assert_eq!((fate, fault), (Fate::Missed, None));
}

#[test]
fn fault_173_a_barrier_between_the_fingers_that_is_always_covered_is_a_named_fault() {
    let held = undisturbed().time;
    for from in [0.0, held - 2.0, held - 1.6, held - 1.2] {
        let (fate, fault) = checked(with_barrier(None, from, Stuck::Covered), &format!("from {from} s"));
        let named =
            fault.as_ref().is_some_and(|text| text.contains("the barrier between the fingers is covered"));
        assert!(named || fate == Fate::Missed || fate == Fate::Sorted, "{fate:?} {fault:?}");
        assert!(from > 0.0 || named, "{fault:?}");
    }
}

/// Each sensor is lost so many seconds before the grasp.
fn sensors_are_lost(before: &[f64]) {
    let held = undisturbed().time;
    for name in ["gate", "range", "fingers"] {
        for &before in before {
            let at = ((held - before) / 4e-3) as u64;
            let sense = |plant: &Plant, file: &CellFile, cell: Cell| {
                let step = file.step().as_secs_f64();
                // A sensor that works until then, or for good.
                let from = |sensor: &str| if sensor == name { at } else { u64::MAX };
                let gate = FaultySensor::new(plant.gate(step), SensorFault::Off, from("gate"), u64::MAX);
                let range = FaultySensor::new(plant.range(step), SensorFault::Off, from("range"), u64::MAX);
                let fingers =
                    FaultySensor::new(plant.fingers(step), SensorFault::Off, from("fingers"), u64::MAX);
                let cell = cell.sensor(file.sensor("gate", gate)?).sensor(file.sensor("range", range)?);
                Ok(cell.sensor(file.sensor("fingers", fingers)?))
            };
            let case = format!("{name} lost {before} s before the grasp");
            let ready = settings().sensed_by(sense).expect("a cell");
            let world = ready.plant.world.clone();
            let (fate, fault) = checked(ready, &case);
            match fault {
                Some(text) => assert!(text.contains(name), "{case}: {text}"),
                None => assert_eq!(fate, Fate::Sorted, "{case}"),
            }
            // What was held when the cell stopped is held still.
            if before < -0.2 && fate != Fate::Sorted {
                assert!(world.hand(0).expect("a hand").is_closed(), "{case}: the part was let go");
            }
        }
    }
}

#[test]
fn fault_174_a_sensor_that_is_lost_in_mid_pick_is_a_named_fault_or_not_needed_any_more() {
    sensors_are_lost(&[1.6, 0.2]);
}

#[test]
fn fault_174_a_vsp_that_is_killed_in_mid_pick_stops_all_robots_within_their_bounds() {
    let held = undisturbed().time;
    let sweep = Sweep::new(|| settings().ready().expect("a cell").cell);
    for name in ["gate", "range", "fingers"] {
        for before in [1.6, 0.4] {
            let process = ProcessId::new(Role::Vsp, Name::new(name).expect("a name"));
            let at = ((held - before) / 4e-3) as u64;
            // Checked: limits, the cause, standstill within the bound, and that no gripper opens.
            let report = sweep.repeat(&Case { injected: Injected::Kill(process), at, seed: 1 });
            assert!(report.is_clean(), "{report}");
        }
    }
}

mod whole {
    use super::{SEED, barriers_die, belt_changes, sensors_are_lost};

    const SEEDS: [u64; 5] = [SEED, 4, 8, 11, 15];

    #[test]
    #[ignore = "takes minutes: `just sorting-whole`"]
    fn fault_170_a_belt_that_stops_makes_a_missed_part_and_no_wrong_grasp() {
        belt_changes(0.0, &SEEDS, 0.1);
    }

    #[test]
    #[ignore = "takes minutes: `just sorting-whole`"]
    fn fault_171_a_belt_that_turns_back_makes_a_missed_part_and_no_wrong_grasp() {
        belt_changes(-0.8, &SEEDS, 0.1);
    }

    #[test]
    #[ignore = "takes minutes: `just sorting-whole`"]
    fn fault_172_a_dead_barrier_of_the_gate_makes_missed_parts_and_no_grasp_beside_them() {
        barriers_die(&[4.0, 3.5, 3.0, 2.5, 1.0]);
    }

    #[test]
    #[ignore = "takes minutes: `just sorting-whole`"]
    fn fault_174_a_sensor_that_is_lost_in_mid_pick_is_a_named_fault_or_not_needed_any_more() {
        sensors_are_lost(&[3.0, 1.6, 0.8, 0.2, -0.3]);
    }
}
