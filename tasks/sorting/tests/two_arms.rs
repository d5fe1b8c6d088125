//! Two arms share the belt. `just sorting-two-arms` tries more, and gives the figures.

use mrroc::fault::{Name, ProcessId, Role};
use mrroc::prelude::*;
use mrroc::testing::{Case, FaultySensor, Injected, SensorFault, Sweep};
use mrroc_sensors::virtual_sensors::CameraSensor;
use sorting::camera::clear::{CLOSING, MARGIN};
use sorting::camera::layout::{BEAM, STATIONS};
use sorting::camera::misses::Missed;
use sorting::camera::run::{Outcome, file};
use sorting::camera::settings::{Overhead, Settings};
use sorting::camera::sight::Sight;
use sorting::camera::summary::{Line, Table};
use sorting::monitor::Fate;

/// Parts that come faster than one arm could take them.
fn crowd() -> Settings {
    Settings::of(0.12, 4, 4.6, 12).by(2)
}

/// All sorted right, by both arms, which kept clear of each other.
fn shared(settings: &Settings) -> Outcome {
    let outcome = settings.run().expect("a cell");
    let line = Line::of(settings, &outcome);
    println!("{}{:?}", Table(vec![line.clone()]), outcome.nearness);
    assert!(outcome.report.is_ok(), "{:?}", outcome.report);
    assert_eq!((line.sorted, line.wrong, line.crashes), (settings.parts, 0, 0), "{:?}", line.missed);
    assert!(line.taken.iter().all(|taken| *taken > 0), "{:?}", line.taken);
    let closest = outcome.closest.as_ref().expect("both arms were seen");
    // What the guard relies on, and by how much it was kept: in each servo period of the whole run.
    assert!(closest.nearest.distance > MARGIN && outcome.nearness.least > MARGIN, "{closest:?}");
    assert!(outcome.nearness.closing <= CLOSING, "{:?}", outcome.nearness);
    outcome
}

#[test]
fn two_arms_take_what_comes_too_fast_for_one_and_never_come_near_each_other() {
    shared(&crowd());
    // One arm alone misses some of them: its cycle is longer than the time between two parts.
    let alone = crowd().by(1);
    let outcome = alone.run().expect("a cell");
    let line = Line::of(&alone, &outcome);
    println!("{}", Table(vec![line.clone()]));
    assert!(outcome.count(Fate::Sorted) < alone.parts && line.wrong == 0);
    // Each miss is explained, and by what it truly was: parts came sooner than one arm can take them.
    assert_eq!(line.sorted + line.missed.len(), alone.parts);
    assert!(line.missed.iter().all(|miss| matches!(miss.why, Missed::Cluster { .. })), "{:?}", line.missed);
}

#[test]
fn the_cell_s_file_says_where_the_program_believes_the_second_arm() {
    let file = file(2).expect("a file");
    for station in STATIONS {
        let entry = file.robots().iter().find(|robot| robot.name() == station.robots[0]).expect("an arm");
        assert_eq!(entry.base(), Pose::translation(0.0, station.along, 0.0));
    }
}

/// The first arm's barrier between its fingers sees nothing any more.
#[test]
fn fault_223_a_part_that_one_arm_could_not_take_is_taken_by_the_other() {
    let settings = Settings { parts: 2, ..crowd() };
    let sense = |file: &CellFile, cell: Cell, camera: CameraSensor<Sight>, plant: &sorting::plant::Plant| {
        let fingers = plant.fingers_before(BEAM, 4e-3);
        let fingers = FaultySensor::new(fingers, SensorFault::Stuck, 0, u64::MAX);
        let cell = cell.sensor(file.sensor("camera", camera)?);
        let cell = cell.sensor(file.sensor("encoder", mrroc_sensors::virtual_sensors::Encoder)?);
        Ok(cell.sensor(file.sensor("fingers", fingers)?))
    };
    let outcome = settings.sensed_by(|camera| camera, sense).expect("a cell").run();
    let line = Line::of(&settings, &outcome);
    println!("{}{:?}", Table(vec![line.clone()]), outcome.vain);
    assert!(outcome.report.is_ok(), "{:?}", outcome.report);
    assert!(!outcome.vain.is_empty() && outcome.vain.iter().all(|(_, arm)| *arm == 0), "{:?}", outcome.vain);
    assert_eq!((line.taken, line.wrong, line.crashes), ([0, line.sorted], 0, 0));
    // The one that the first arm tried is in the second one's bin.
    assert!(outcome.fates[outcome.vain[0].0 as usize - 1] == Fate::Sorted, "{:?}", outcome.fates);
}

/// EDPs, each of which is killed so many seconds before the second arm takes its part.
fn edps_are_killed(cases: &[(&str, f64)]) {
    let settings = Settings { parts: 3, ..crowd() };
    let outcome = settings.run().expect("a cell");
    // The second arm is down at its part, and the first one on its way.
    let held = outcome.grips.iter().find(|grip| grip.arm == 1).expect("the second arm took one").time;
    let sweep = Sweep::new(|| settings.ready().expect("a cell").cell);
    for &(name, before) in cases {
        let process = ProcessId::new(Role::Edp, Name::new(name).expect("a name"));
        // Checked: limits, the cause, standstill within the bound, and that no gripper opens.
        let at = ((held - before) / 4e-3) as u64;
        let report = sweep.repeat(&Case { injected: Injected::Kill(process), at, seed: 1 });
        assert!(report.is_clean(), "{name}: {report}");
    }
}

#[test]
fn fault_224_an_edp_of_one_of_two_arms_that_is_killed_stops_both() {
    edps_are_killed(&[("arm-2", 0.4)]);
}

#[test]
fn fault_225_arms_that_come_nearer_than_they_may_are_stopped_by_the_guard() {
    // Nearer than they ever are is too near here.
    let settings = Settings { margin: 1.3, parts: 2, ..crowd() };
    let outcome = settings.run().expect("a cell");
    let fault = outcome.report.as_ref().expect_err("too near").to_string();
    assert!(fault.contains("arm-2") && fault.contains("too close"), "{fault}");
    // They stand before they have closed in by more than is allowed for that.
    let closest = outcome.closest.as_ref().expect("both arms were seen").nearest.distance;
    assert!(closest > settings.margin - MARGIN, "{closest} m");
    assert_eq!((outcome.count(Fate::Wrong), outcome.crashes), (0, 0));
}

#[test]
fn two_arms_share_the_belt_below_the_matrix_by_the_same_programs() {
    shared(&Settings { parts: 3, ..crowd() }.below(Overhead::Matrix));
}

/// So many parts quite at random, and sooner than the arm can take them.
fn misses_are_explained(parts: usize) {
    let settings = Settings { regular: 0.0, ..Settings::of(0.15, parts, 5.0, 8) };
    let outcome = settings.run().expect("a cell");
    let line = Line::of(&settings, &outcome);
    println!("{}", Table(vec![line.clone()]));
    assert!(outcome.report.is_ok() && line.wrong == 0 && line.crashes == 0, "{:?}", outcome.report);
    assert!(!line.missed.is_empty());
    assert_eq!(line.sorted + line.missed.len(), settings.parts);
    for miss in &line.missed {
        // Found again in what happened: a cluster leaves less time than the arm needs.
        assert_eq!(outcome.fates[miss.part], Fate::Missed);
        if let Missed::Cluster { parts, within } = miss.why {
            assert!(within < (parts - 1) as f64 * Settings::CYCLE, "{miss:?}");
        } else {
            assert!(!outcome.late.contains(&(miss.part as u32 + 1)) || miss.why == Missed::Late, "{miss:?}");
        }
    }
}

#[test]
fn fault_207_each_part_that_is_not_sorted_is_explained_by_name() {
    misses_are_explained(5);
}

mod whole {
    use super::{edps_are_killed, misses_are_explained};

    #[test]
    #[ignore = "takes minutes: `just sorting-two-arms`"]
    fn fault_224_an_edp_of_one_of_two_arms_that_is_killed_stops_both() {
        edps_are_killed(&[("arm-2", 0.4), ("hand", 0.2)]);
    }

    #[test]
    #[ignore = "takes minutes: `just sorting-two-arms`"]
    fn fault_207_each_part_that_is_not_sorted_is_explained_by_name() {
        misses_are_explained(40);
    }
}
