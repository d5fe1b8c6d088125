//! Faults of the maze task: each is named, and the arm stops.

use maze::feeling::Touch;
use maze::plant::{Plant, Probe, TouchProbe};
use maze::run::Ready;
use mrroc::prelude::*;
use mrroc_map::Layout;

use crate::usage::islands;

/// Undisturbed it takes some 6,000 steps.
/// A probe that fails from a step on.
struct Failing {
    probe: Probe,
    from: u64,
}

impl VirtualSensor for Failing {
    type Kind = TouchProbe;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Touch, Fault> {
        if order.step >= self.from {
            return Err(Fault::thrown("the cable of the probe is off"));
        }
        self.probe.aggregate(order)
    }

    fn is_simulated(&self) -> bool {
        true
    }
}

/// Runs with a probe that fails from a step on: the fault, and the largest deflection of the stylus \[m\].
fn failing(from: u64) -> (String, f64) {
    let ready = Ready::sensed_by(&islands(), 0, |plant, file, cell| {
        let failing = Failing { probe: plant.probe(), from };
        Ok(cell.sensor(file.sensor("probe", failing)?))
    });
    let outcome = ready.expect("a cell").run();
    (outcome.report.expect_err("a fault").to_string(), outcome.travel)
}

/// Steps of 4 ms into the run: while the frame is looked for, and in legs between the walls.
const STEPS: [u64; 4] = [1200, 3200, 4000, 5000];

#[test]
fn fault_221_a_probe_that_is_lost_in_mid_leg_is_a_named_fault_and_the_arm_stops() {
    for from in STEPS {
        let (fault, travel) = failing(from);
        assert!(fault.contains("probe") && fault.contains("cable"), "{fault}");
        assert!(travel < 4e-3, "{travel} m, from step {from}");
    }
}

#[test]
fn fault_222_a_maze_without_a_path_ends_with_a_fault_that_says_so() {
    let closed: Layout = "o---o---o\n|   | G |\no   o---o\n| S     |\no---o---o".parse().expect("a maze");
    let outcome = Ready::new(&closed, 2).expect("a cell").run();
    let fault = outcome.report.expect_err("no path").to_string();
    assert!(fault.contains("no path to the exit"), "{fault}");
    assert!(outcome.travel < 4e-3 && outcome.contacts.len() < 160, "{} touches", outcome.contacts.len());
}

/// A probe whose switch no longer closes from a step on.
struct Breaking {
    probe: Probe,
    plant: Plant,
    from: u64,
}

impl VirtualSensor for Breaking {
    type Kind = TouchProbe;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Touch, Fault> {
        self.plant.world().borrow_mut().stylus.stuck = order.step >= self.from;
        self.probe.aggregate(order)
    }

    fn is_simulated(&self) -> bool {
        true
    }
}

#[test]
fn fault_226_a_switch_that_no_longer_closes_is_a_fault_by_over_travel() {
    for from in [0, STEPS[1], STEPS[2], STEPS[3]] {
        let ready = Ready::sensed_by(&islands(), 0, |plant, file, cell| {
            let breaking = Breaking { probe: plant.probe(), plant: plant.clone(), from };
            Ok(cell.sensor(file.sensor("probe", breaking)?))
        });
        let outcome = ready.expect("a cell").run();
        let fault = outcome.report.expect_err("a fault").to_string();
        assert!(fault.contains("over-travel"), "from step {from}: {fault}");
        // 4 mm, and what the arm goes on from 60 mm/s while it brakes evenly in the longest stop time, 0.6 s.
        assert!(outcome.travel < 4e-3 + 0.5 * 0.06 * 0.6, "from step {from}: {} m", outcome.travel);
    }
}
