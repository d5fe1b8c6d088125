//! The task with a bar between the hands: how hard they press on it.

use mrroc::cell::CellError;
use mrroc::fault::FaultKind;
use mrroc::pose::Wrench;
use mrroc::prelude::CellFile;
use mrroc_calibration::Touches;
use mrroc_robots::grasp::SimulatedWrist;
use nalgebra::Vector3;
use transfer::monitor::{CellMonitor, RunMeasurements};
use transfer::places::{bar, legs};
use transfer::touching::touches;
use transfer::variant::{Bases, Ready, Sensors, Variant};
use transfer::{cell, file, plant, sensed};

/// Stiffness of a grasp [N/m].
const K: f64 = 5e4;

fn run(bases: Bases, sensors: Sensors) -> (RunMeasurements, mrroc::pose::Pose) {
    let file = file().expect("in order");
    let mut world = None;
    let seen = Variant::Bar { bases, sensors }.watched(&file, |cell, plant| {
        world = plant.map(|plant| plant.world.clone());
        cell
    });
    (seen.expect("within all limits"), world.expect("there is a bar").body().pose)
}

/// The bar stands where the legs lead, as far as bases that are off let it: they were off when it was grasped, too.
#[allow(non_snake_case)]
fn stands(pose: &mrroc::pose::Pose) {
    let X_WB = legs().iter().fold(bar(), |X_WB, X_BsB| X_WB * X_BsB);
    let error = X_WB.inv_mul(pose);
    assert!(error.translation.vector.norm() < 2e-3 && error.rotation.angle() < 5e-3, "{error}");
}

#[test]
fn force_sensors_take_at_least_four_fifths_of_the_stress_that_a_base_out_of_place_makes() {
    let (without, end) = run(Bases::Off, Sensors::Unused);
    stands(&end);
    let (with, end) = run(Bases::Off, Sensors::Used);
    stands(&end);
    assert!(without.is_held() && with.is_held());
    // Without sensors the body takes what the base's error makes of its path: two springs in a row, k d / 2.
    let expected = 0.5 * K * without.strain.distance;
    assert!((without.internal - expected).abs() < 0.15 * expected, "{} {expected}", without.internal);
    assert!(without.internal > 15.0, "{}", without.internal);
    assert!(with.internal <= without.internal / 5.0, "{} of {}", with.internal, without.internal);
    assert!(without.demanded.distance <= 1e-9 && without.demanded.angle <= 1e-9, "{:?}", without.demanded);
}

/// Suspends in one of `every` 145 steps, and resumes.
fn the_operator_suspends_and_resumes(every: usize) {
    let file = file().expect("in order");
    let variant = Variant::Bar { bases: Bases::Off, sensors: Sensors::Used };
    let (without, _) = run(Bases::Off, Sensors::Unused);
    assert!(without.is_held() && without.internal > 15.0, "{}", without.internal);
    // As in tests/task.rs, but less often.
    const PERIOD: u64 = 1160;
    for offset in (0..PERIOD).step_by(145 * every) {
        let seen = variant.watched(&file, |cell, _| {
            cell.on_step(move |step, operator| match (step + PERIOD - offset) % PERIOD {
                0 => operator.suspend(),
                400 => operator.resume(),
                _ => {}
            })
        });
        let seen = seen.unwrap_or_else(|error| panic!("suspended in step {offset} and later: {error}"));
        assert!(seen.is_held(), "a hand lost the bar when suspended in step {offset}");
        let (with, without) = (seen.internal, without.internal);
        assert!(with <= without / 5.0, "{with} N of {without} N when suspended in step {offset}");
    }
}

#[test]
fn wherever_the_operator_suspends_and_resumes_the_stress_stays_low() {
    the_operator_suspends_and_resumes(3);
}

mod whole {
    #[test]
    #[ignore = "takes minutes: `just test-whole`"]
    fn wherever_the_operator_suspends_and_resumes_the_stress_stays_low() {
        super::the_operator_suspends_and_resumes(1);
    }
}

#[test]
fn wherever_the_operator_aborts_the_hands_keep_the_bar_and_the_stress_stays_low() {
    let file = file().expect("in order");
    let (without, _) = run(Bases::Off, Sensors::Unused);
    // While the bar is carried, from some 8.5 s to 17.5 s: in the middle of the legs up, over and down.
    for at in [4900, 6600, 8300] {
        let plant = plant::Plant::new(plant::calibration_error()).expect("in order");
        let ready = cell(&file, &plant.kinds()).expect("in order");
        let (world, monitor) = (plant.world.clone(), CellMonitor::new());
        let ready = monitor.watch(plant.with_wrists(ready), Some(&plant), |_| Ok(()));
        let outcome = ready.program(sensed::coordinate).on_step(move |step, operator| {
            if step == at {
                operator.abort();
            }
        });
        let Err(CellError::Fault(fault)) = outcome.run() else { panic!("aborted in step {at}") };
        assert_eq!(fault.kind(), FaultKind::Aborted, "{fault}");
        let seen = monitor.into_seen();
        assert!(seen.is_held(), "a hand lost the bar when aborted in step {at}");
        let (with, without) = (seen.internal, without.internal);
        assert!(with > 0.0 && with <= without / 5.0, "{with} N of {without} N when aborted in step {at}");
        // Above the table, at rest but for what grasps as soft as these still swing, and between both hands.
        let body = world.body();
        assert!(body.velocity.norm() < 1e-3, "{} when aborted in step {at}", body.velocity);
        let height = body.pose.translation.z - bar().translation.z;
        assert!((1e-3..0.121).contains(&height), "{height} m up when aborted in step {at}");
    }
}

#[test]
fn bases_where_they_are_believed_to_be_leave_what_the_drives_are_off_by() {
    let (seen, end) = run(Bases::Calibrated, Sensors::Unused);
    stands(&end);
    // 0.15 mm, about k d / 2.
    assert!(seen.measured.distance < 1.5e-4 && seen.measured.angle < 3e-4, "{:?}", seen.measured);
    assert!(seen.internal < 0.5 * K * 1.5e-4, "{}", seen.internal);
}

/// The same program, and no sensor: what has changed is `base = ".."` of Polycrank in cell.toml.
#[test]
fn bases_from_touched_points_leave_the_bar_the_force_that_true_ones_leave() {
    let (before, _) = run(Bases::Off, Sensors::Unused);
    assert!(before.internal > 25.0, "{}", before.internal);
    let folder = std::env::temp_dir().join(format!("mrroc-touched-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    // As `transfer --touches` writes it and `calibrate bases` reads it.
    let table = Touches::text(&touches(1));
    let found = Touches::parse(&table).expect("a table").base("polycrank", "rnt").expect("a base");
    std::fs::write(folder.join("polycrank.base.toml"), found.text("polycrank", "rnt", "2026-11-24"))
        .expect("written");
    let believed = "base = { xyz = [1.8, -0.3, -0.45], rpy = [0.0, 0.0, 3.141592653589793] }";
    let text = include_str!("../cell.toml").replace(believed, "base = \"polycrank.base.toml\"");
    assert!(text.contains("polycrank.base.toml"), "cell.toml has another base");
    let name = folder.join("cell.toml").display().to_string();
    let file = CellFile::parse(&name, &text).expect("in order");
    let variant = Variant::Bar { bases: Bases::Off, sensors: Sensors::Unused };
    let after = variant.watched(&file, |cell, _| cell).expect("within all limits");
    println!("{} N before, {} N after; {found}", before.internal, after.internal);
    assert!(after.is_held() && after.internal <= 4.0, "{} N", after.internal);
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn a_sensor_that_saturates_is_a_fault_and_no_reading() {
    let file = file().expect("in order");
    let plant = plant::Plant::new(plant::calibration_error()).expect("in order");
    let ready = cell(&file, &plant.kinds()).expect("in order");
    // Half the weight of the bar, 9.8 N, 45 degrees off the axes of the sensor, is 6.9 N along two of them.
    let small = Wrench::new(Vector3::repeat(5.0), Vector3::repeat(5.0));
    let outcome = plant.with_wrists_of(ready, |hand, _| SimulatedWrist::new(hand).with_range(small));
    let Err(CellError::Fault(fault)) = outcome.program(sensed::coordinate).run() else {
        panic!("the sensor bears 5 N")
    };
    assert_eq!(fault.kind(), FaultKind::SensorFailed, "{fault}");
    assert!(fault.to_string().contains("saturates"), "{fault}");
}

#[test]
fn runs_with_a_bar_are_the_same_to_the_bit() {
    let run = || {
        let file = file().expect("in order");
        let variant = Variant::Bar { bases: Bases::Off, sensors: Sensors::Used };
        let Ready { cell, plant } = variant.ready(&file).expect("in order");
        let report = cell.run().expect("within all limits");
        let body = plant.expect("there is a bar").world.body();
        let numbers = body
            .pose
            .to_homogeneous()
            .iter()
            .chain(body.velocity.iter())
            .copied()
            .map(f64::to_bits)
            .collect::<Vec<_>>();
        (report.steps, numbers)
    };
    assert_eq!(run(), run());
}
