//! Faults of the camera's cell: a named fault, or a part that passes; never a wrong grasp.

use core::cell::OnceCell;

use mrroc::fault::{Name, ProcessId, Role};
use mrroc::prelude::*;
use mrroc::testing::{Case, FaultySensor, Injected, SensorFault, Sweep};
use mrroc_sensors::aggregation::{FEATURES, Network};
use mrroc_sensors::physics::{Dark, Stuck};
use mrroc_sensors::virtual_sensors::{CameraSensor, Encoder, FingerBarrier};
use sorting::camera::layout::BEAM;
use sorting::camera::run::{Outcome, Ready};
use sorting::camera::settings::Settings;
use sorting::camera::sight::Sight;
use sorting::camera::summary::{Line, Table};
use sorting::monitor::Fate;
use sorting::plant::Plant;
use sorting::scene::AtTool;

use super::checked::first_hold;

const SPEED: f64 = 0.12;
const STEP: f64 = 4e-3;

fn settings() -> Settings {
    Settings::of(SPEED, 1, 2.0, 3)
}

thread_local! {
    static HELD: OnceCell<f64> = const { OnceCell::new() };
}

/// When the undisturbed run gets hold of its part \[s\].
fn held() -> f64 {
    HELD.with(|held| *held.get_or_init(|| first_hold(&settings())))
}

/// As [`super::checked::checked`]. Within that each pad of 24 mm lies on the shortest face, 30 mm, with all of its width.
fn checked(ready: Ready, case: &str) -> (Fate, Option<String>) {
    super::checked::checked(ready, case, 3e-3)
}

/// Every so many seconds from when the part is below the camera until it is held.
fn moments(step: f64) -> impl Iterator<Item = f64> {
    let held = held();
    (0..).map(move |i| held - 7.0 + step * f64::from(i)).take_while(move |time| *time < held + 0.5)
}

/// The cell with a camera that is changed, and one that is dark in the end.
fn with_camera(change: impl FnOnce(&mut CameraSensor<Sight>)) -> Ready {
    let changed = |mut camera: CameraSensor<Sight>| {
        change(&mut camera);
        camera
    };
    let all = |file: &CellFile, cell: Cell, camera: CameraSensor<Sight>, plant: &Plant| {
        let cell = cell.sensor(file.sensor("camera", camera)?).sensor(file.sensor("encoder", Encoder)?);
        Ok(cell.sensor(file.sensor("fingers", plant.fingers_before(BEAM, STEP))?))
    };
    settings().sensed_by(changed, all).expect("a cell")
}

/// The cell with sensors that fail from a time on, by name.
fn with_faults(name: &str, from: f64) -> Ready {
    let at = |sensor: &str| if sensor == name { (from / STEP) as u64 } else { u64::MAX };
    let sense = |file: &CellFile, cell: Cell, camera: CameraSensor<Sight>, plant: &Plant| {
        let fingers: FingerBarrier<AtTool> = plant.fingers_before(BEAM, STEP);
        let camera = FaultySensor::new(camera, SensorFault::Off, at("camera"), u64::MAX);
        let encoder = FaultySensor::new(Encoder, SensorFault::Off, at("encoder"), u64::MAX);
        let fingers = FaultySensor::new(fingers, SensorFault::Off, at("fingers"), u64::MAX);
        let cell = cell.sensor(file.sensor("camera", camera)?).sensor(file.sensor("encoder", encoder)?);
        Ok(cell.sensor(file.sensor("fingers", fingers)?))
    };
    settings().sensed_by(|camera| camera, sense).expect("a cell")
}

/// Dark from before the part comes: the camera says so. Dark after it was seen: nobody needs the camera any more.
fn darkened(dark: Dark) {
    let held = held();
    for (before, seen) in [(100.0, false), (8.0, false), (1.0, true)] {
        let case = format!("{dark:?} {before} s before");
        let ready = with_camera(|camera| camera.imager().darken(held - before, dark));
        let (fate, fault) = checked(ready, &case);
        if seen {
            assert_eq!((fate, fault), (Fate::Sorted, None), "{case}");
        } else {
            let named = fault.as_ref().is_some_and(|text| text.contains("lens covered or lamp off?"));
            assert!(named && fate == Fate::Missed, "{case}: {fate:?} {fault:?}");
        }
    }
}

#[test]
fn fault_190_a_covered_lens_is_a_named_fault_once_a_part_comes() {
    darkened(Dark::Covered);
}

#[test]
fn fault_191_a_lamp_that_is_off_is_a_named_fault_once_a_part_comes() {
    darkened(Dark::LampOff);
}

#[test]
fn fault_192_a_sensor_of_the_camera_cell_that_is_lost_in_mid_pick_is_a_named_fault_or_not_needed_any_more() {
    let held = held();
    for (name, before) in
        [("camera", 3.0), ("camera", 0.5), ("encoder", 2.0), ("encoder", 0.3), ("fingers", 0.5)]
    {
        let case = format!("{name} lost {before} s before the grasp");
        let (fate, fault) = checked(with_faults(name, held - before), &case);
        match fault {
            Some(text) => assert!(text.contains(name), "{case}: {text}"),
            None => assert_eq!(fate, Fate::Sorted, "{case}"),
        }
    }
}

#[test]
fn fault_192_a_vsp_of_the_camera_cell_that_is_killed_in_mid_pick_stops_all_robots_within_their_bounds() {
    let held = held();
    let sweep = Sweep::new(|| settings().ready().expect("a cell").cell);
    for name in ["camera", "encoder", "fingers"] {
        let process = ProcessId::new(Role::Vsp, Name::new(name).expect("a name"));
        let at = ((held - 0.4) / STEP) as u64;
        // Checked: limits, the cause, standstill within the bound, and that no gripper opens.
        let report = sweep.repeat(&Case { injected: Injected::Kill(process), at, seed: 1 });
        assert!(report.is_clean(), "{report}");
    }
}

/// A belt that stops or turns back, every so many seconds.
fn belt_changes(step: f64) {
    let mut sorted = 0;
    for share in [0.0, -0.8] {
        for time in moments(step) {
            let case = format!("share {share} from {time} s");
            let changed = Settings { profile: Box::leak(Box::new([(time, share)])), ..settings() };
            let (fate, fault) = checked(changed.ready().expect("a cell"), &case);
            assert_eq!(fault, None, "{case}");
            sorted += usize::from(fate == Fate::Sorted);
        }
    }
    // Once the arm is at the part it goes with it, also to a standstill.
    assert!(sorted > 0);
}

#[test]
fn fault_193_a_belt_that_stops_or_turns_back_is_followed_by_its_encoder_or_the_part_is_missed() {
    belt_changes(3.6);
}

#[test]
fn fault_194_a_stranger_or_a_part_turned_over_passes() {
    for which in 0..3 {
        let strange = Settings { stranger: Some(which), parts: 2, ..settings() };
        let ready = strange.ready().expect("a cell");
        let looks = ready.looks.clone();
        let outcome = ready.run();
        assert!(outcome.report.is_ok() && outcome.crashes == 0, "{:?}", outcome.report);
        // It was seen, and named by nobody; the part after it was sorted.
        assert!(looks.borrow().all.iter().any(|look| look.part == 0));
        assert!(looks.borrow().all.iter().all(|look| look.part != 0 || look.taken.is_none()));
        assert!(outcome.grips.iter().all(|grip| grip.part == 1), "{:?}", outcome.grips);
        assert_eq!(outcome.fates, [Fate::Passed, Fate::Sorted], "stranger {which}");
        // It is no part that was missed, and the share of parts that were sorted does not count it.
        let line = Line::of(&strange, &outcome);
        assert_eq!((line.parts, line.sorted, line.strangers, line.passed), (1, 1, 1, 1), "stranger {which}");
        assert!(line.missed.is_empty() && outcome.misses(1).is_empty(), "{:?}", line.missed);
        let gripped = Line { passed: 0, gripped: 1, ..line.clone() };
        assert!(Table(vec![line]).to_string().contains("strangers: 1 came, 1 passed, which is right\n"));
        let said = "0 passed, which is right; 1 a hand took for parts, and brought to no bin\n";
        assert!(Table(vec![gripped]).to_string().contains(said));
    }
}

#[test]
fn fault_195_a_dead_barrier_at_the_camera_makes_missed_parts() {
    for stuck in [Stuck::Open, Stuck::Covered] {
        let ready = with_camera(|camera| {
            if let Some(barrier) = camera.barrier() {
                barrier.fail(0.0, stuck);
            }
        });
        let (fate, fault) = checked(ready, &format!("{stuck:?}"));
        assert_eq!((fate, fault), (Fate::Missed, None), "{stuck:?}");
    }
}

#[test]
fn fault_196_a_finger_barrier_that_is_always_open_makes_missed_parts_and_one_always_covered_a_named_fault() {
    for stuck in [Stuck::Open, Stuck::Covered] {
        let sense = |file: &CellFile, cell: Cell, camera: CameraSensor<Sight>, plant: &Plant| {
            let mut fingers = plant.fingers_before(BEAM, STEP);
            fingers.barrier().fail(0.0, stuck);
            let cell = cell.sensor(file.sensor("camera", camera)?).sensor(file.sensor("encoder", Encoder)?);
            Ok(cell.sensor(file.sensor("fingers", fingers)?))
        };
        let ready = settings().sensed_by(|camera| camera, sense).expect("a cell");
        let (fate, fault) = checked(ready, &format!("{stuck:?}"));
        let named =
            fault.as_ref().is_some_and(|text| text.contains("the barrier between the fingers is covered"));
        assert!(fate == Fate::Missed && named == (stuck == Stuck::Covered), "{stuck:?}: {fate:?} {fault:?}");
    }
}

/// A sensor of a belt whose encoder's count stands for some steps and then runs on, while the belt runs.
struct Standing<V> {
    sensor: V,
    from: u64,
    until: u64,
    last: f64,
    /// What the count has lost \[m\].
    lost: f64,
}

impl<V: VirtualSensor> Standing<V> {
    fn of(sensor: V, from: f64, until: f64) -> Self {
        Self { sensor, from: (from / STEP) as u64, until: (until / STEP) as u64, last: 0.0, lost: 0.0 }
    }
}

impl<V: VirtualSensor<Kind = K>, K: Sensor> VirtualSensor for Standing<V> {
    type Kind = K;

    fn aggregate(&mut self, order: &ReadingOrder<K::Configuration>) -> Result<K::Reading, Fault> {
        let mut order = *order;
        if let Some(belt) = &mut order.robot {
            let truly = belt.joints[0];
            if (self.from..self.until).contains(&order.step) {
                self.lost += truly - self.last;
                belt.velocity[0] = 0.0;
            }
            self.last = truly;
            belt.joints[0] -= self.lost;
        }
        self.sensor.aggregate(&order)
    }
}

/// What comes of it when the count that camera and arm have of the belt stands from a time on, for so long \[s\].
fn standing(from: f64, long: f64) -> Outcome {
    let sense = |file: &CellFile, cell: Cell, camera: CameraSensor<Sight>, plant: &Plant| {
        let until = from + long;
        let (camera, encoder) = (Standing::of(camera, from, until), Standing::of(Encoder, from, until));
        let cell = cell.sensor(file.sensor("camera", camera)?).sensor(file.sensor("encoder", encoder)?);
        Ok(cell.sensor(file.sensor("fingers", plant.fingers_before(BEAM, STEP))?))
    };
    settings().sensed_by(|camera| camera, sense).expect("a cell").run()
}

/// A count that stands from a time on for so long \[s\].
fn the_count_stands(cases: impl IntoIterator<Item = (f64, f64)>) {
    let held = held();
    for (time, lasts) in cases {
        let case = format!("the count stands from {time} s on for {lasts} s, held at {held} s");
        let outcome = standing(time, lasts);
        match &outcome.report {
            Err(fault) => assert!(fault.to_string().contains("the count of the belt's encoder"), "{fault}"),
            // It has never run, or stood before the part came, or the part was held by then.
            Ok(_) => assert!(time == 0.0 || time > held, "{case}: no fault"),
        }
        assert_eq!(outcome.count(Fate::Wrong), 0, "{case}");
        assert!(outcome.grips.iter().all(|grip| grip.off.abs() < 3e-3), "{case}: {:?}", outcome.grips);
        // A belt takes longer to stop than an arm, so a part may run against a finger while they stop, whatever the cause.
        let crashes = outcome.crashes;
        let lost = || with_faults("encoder", time).run().crashes;
        assert!(crashes == 0 || crashes <= lost(), "{case}: fingers came down on a part");
    }
}

#[test]
fn fault_208_an_encoder_whose_count_stands_below_the_camera_makes_a_missed_part_or_a_named_fault() {
    // From the beginning; while the hand closes; and for a moment, which would put the arm 13 mm off.
    the_count_stands([(0.0, 100.0), (held() - 0.1, 100.0), (held() - 1.8, 0.1)]);
}

mod whole {
    use super::{belt_changes, moments, the_count_stands};

    #[test]
    #[ignore = "takes minutes: `just sorting-whole`"]
    fn fault_193_a_belt_that_stops_or_turns_back_is_followed_by_its_encoder_or_the_part_is_missed() {
        belt_changes(0.1);
    }

    #[test]
    #[ignore = "takes minutes: `just sorting-whole`"]
    fn fault_208_an_encoder_whose_count_stands_below_the_camera_makes_a_missed_part_or_a_named_fault() {
        the_count_stands(moments(0.2).flat_map(|time| [(time, 0.1), (time, 100.0)]));
    }
}

#[test]
fn fault_197_a_network_of_other_classes_or_no_network_is_refused() {
    let bytes = include_bytes!("../assets/parts.onnx");
    let other = Network::read(bytes.to_vec(), FEATURES, 9).expect_err("eight classes").to_string();
    assert!(other.contains("9 classes") && other.contains("train it anew"), "{other}");
    let broken =
        Network::read(bytes[..bytes.len() / 2].to_vec(), FEATURES, 8).expect_err("half a file").to_string();
    assert!(broken.contains("cannot be read"), "{broken}");
}
