//! Faults of the matrix's cell: a named fault, or a part that passes; never a wrong grasp.

use core::cell::OnceCell;

use mrroc::fault::{Name, ProcessId, Role};
use mrroc::prelude::*;
use mrroc::testing::{Case, FaultySensor, Injected, SensorFault, Sweep};
use mrroc_sensors::aggregation::{Deaf, Hearing, Reliefs};
use mrroc_sensors::physics::{Silent, Sounders};
use mrroc_sensors::ultrasound::Air;
use mrroc_sensors::virtual_sensors::MatrixSensor;
use nalgebra::Vector3;
use sorting::camera::kinds::{classes, kinds};
use sorting::camera::run::Ready;
use sorting::camera::settings::{Overhead, Settings};
use sorting::camera::sight::Sight;
use sorting::camera::studio::{Lying, Passing};
use sorting::matrix::layout::{MATRIX, array};
use sorting::matrix::run::{network, sensors};
use sorting::monitor::Fate;

use super::checked::first_hold;

const STEP: f64 = 4e-3;

/// How many of its cases a test tries; `just sorting-matrix` tries all.
const SHARE: usize = 2;

fn settings() -> Settings {
    Settings::of(0.12, 1, 2.0, 3).below(Overhead::Matrix)
}

thread_local! {
    static HELD: OnceCell<f64> = const { OnceCell::new() };
}

/// When the undisturbed run gets hold of its part \[s\].
fn held() -> f64 {
    HELD.with(|held| *held.get_or_init(|| first_hold(&settings())))
}

/// As [`super::checked::checked`]. Within that each pad of 24 mm lies on the shortest face, 30 mm, with half of its width.
fn checked(ready: Ready, case: &str) -> (Fate, Option<String>) {
    super::checked::checked(ready, case, 6e-3)
}

/// The cell with a matrix that is changed.
fn with_matrix(change: impl FnOnce(&mut MatrixSensor<Sight>)) -> Ready {
    let changed = |mut matrix: MatrixSensor<Sight>| {
        change(&mut matrix);
        matrix
    };
    settings().heard_by(changed, sensors).expect("a cell")
}

fn transducers_are_dead(cases: usize) {
    // Dead from the beginning, or from before the part comes.
    for (from, silent) in
        [(0.0, Silent::All), (1.0, Silent::One(17)), (0.0, Silent::One(17))].into_iter().take(cases)
    {
        let ready = with_matrix(|matrix| matrix.sounders().silence(from, silent));
        let (fate, fault) = checked(ready, &format!("{silent:?} from {from} s"));
        let text = fault.expect("a fault");
        assert!(text.contains("ultrasonic transducer") && text.contains("dead, loose or covered?"), "{text}");
        assert!(silent == Silent::All || text.contains("transducer 18 of 32"), "{text}");
        assert_eq!(fate, Fate::Missed, "{silent:?}");
    }
}

#[test]
fn fault_198_a_dead_transducer_or_a_dead_matrix_is_a_named_fault() {
    transducers_are_dead(SHARE);
}

fn echoes_are_lost(cases: usize) {
    for lost in [0.1, 0.6, 0.3].into_iter().take(cases) {
        let ready = with_matrix(|matrix| *matrix.sounders() = matrix.sounders().clone().losing(lost));
        let (fate, fault) = checked(ready, &format!("{lost} lost"));
        assert_eq!(fault, None);
        assert!(fate == Fate::Sorted || lost > 0.1, "{lost}");
    }
}

#[test]
fn fault_199_echoes_that_are_lost_make_missed_parts_at_most() {
    echoes_are_lost(SHARE);
}

fn the_air_changes(cases: usize) {
    let held = held();
    // Before the part comes, and while it is below the matrix.
    for (time, kelvin, named) in
        [(1.0, 30.0, true), (held - 6.0, 5.0, false), (1.0, -5.0, false), (1.0, -30.0, true)]
            .into_iter()
            .take(cases)
    {
        let ready = with_matrix(|matrix| matrix.sounders().warm(time, Air { celsius: 20.0 + kelvin }));
        let (fate, fault) = checked(ready, &format!("{kelvin} K at {time} s"));
        assert_eq!(fault.is_some(), named, "{kelvin} K at {time} s: {fault:?}");
        if let Some(text) = fault {
            assert!(text.contains("mm from where it was") && fate == Fate::Missed, "{text}");
        }
    }
}

#[test]
fn fault_214_air_that_changes_is_followed_or_a_named_fault() {
    the_air_changes(SHARE);
}

fn parts_lie_below_the_matrix(cases: usize) {
    let array = array();
    // Whether what lies on a belt that stands is learned as bare belt.
    let learn = |parts: Vec<Lying>, celsius: f64, seed: u64| {
        let scene = Passing { parts, speed: 0.0, run: 0.0, now: 0.0 };
        let mut sounders = Sounders::over(&array, Air { celsius }, seed);
        let mut reliefs = Reliefs::by(array.clone());
        for ping in 1_u32..400 {
            let number = array.turn(ping.into());
            let echo = sounders.ping(&scene, number, f64::from(ping) * array.period);
            reliefs.take(number, echo, 0.0)?;
        }
        Ok::<_, Deaf>(reliefs.is_taught())
    };
    for (seed, celsius) in [(1, 20.0), (2, 5.0), (3, 35.0), (4, 20.0), (5, 20.0)].into_iter().take(cases) {
        assert_eq!(learn(Vec::new(), celsius, seed), Ok(true), "a bare belt at {celsius} °C");
        for (number, kind) in kinds().iter().enumerate() {
            let place = [MATRIX[0] + 0.02, -0.01];
            let lying = Lying::of(Some(number), kind.class.form.clone(), place, 0.7 * seed as f64, 0.5);
            let refused = learn(vec![lying], celsius, seed).expect_err(kind.class.name);
            assert!(matches!(refused, Deaf::Uneven { .. }), "{}: {refused}", kind.class.name);
        }
    }
}

#[test]
fn fault_218_a_part_that_lies_below_the_matrix_from_the_beginning_is_not_learned_as_belt() {
    parts_lie_below_the_matrix(SHARE);
}

fn the_count_stands(cases: usize) {
    // Of all kinds and at any angle: what passes a matrix that believes the belt to stand.
    let kinds = kinds();
    for (kind, of) in kinds.iter().enumerate().take(cases) {
        let mut passing = Passing {
            parts: vec![Lying::of(Some(kind), of.class.form.clone(), [MATRIX[0] - 0.25, 0.01], 0.7, 0.5)],
            speed: 0.1,
            run: 0.0,
            now: 0.0,
        };
        let begin: Vector3<f64> = passing.parts[0].pose.translation.vector;
        let array = array();
        let mut sounders = Sounders::over(&array, Air { celsius: 20.0 }, 8);
        let mut reliefs = Reliefs::by(array.clone());
        let mut hearing = Hearing::new(&array, classes(), Box::new(network().expect("a network")));
        let mut evaluated = 0;
        for ping in 1_u32..1600 {
            // The count stands while the part comes below the matrix, and then runs on.
            let counted = passing.speed * array.period * f64::from(ping.min(300) + ping.saturating_sub(520));
            passing.now = f64::from(ping) * array.period;
            passing.run = passing.speed * passing.now;
            passing.parts[0].pose.translation.vector.x = begin.x + passing.run;
            let number = array.turn(ping.into());
            let echo = sounders.ping(&passing, number, passing.now);
            reliefs.take(number, echo, counted).expect("it hears");
            if let Some(relief) = reliefs.passed(counted) {
                evaluated += 1;
                assert_eq!(hearing.evaluate(&relief).class, None, "{}", of.class.name);
            }
        }
        println!("{}: {evaluated} things passed, none of which is a kind", of.class.name);
        assert!(evaluated > 0, "{}", of.class.name);
    }
}

#[test]
fn fault_215_an_encoder_whose_count_stands_makes_missed_parts() {
    the_count_stands(SHARE);
}

#[test]
fn fault_216_a_sensor_of_the_matrix_cell_that_is_lost_or_killed_in_mid_pick_is_a_named_fault_or_not_needed_any_more()
 {
    let held = held();
    for (name, before) in [("matrix", 3.0), ("matrix", 0.5)] {
        let sense =
            |file: &CellFile, cell: Cell, matrix: MatrixSensor<Sight>, plant: &sorting::plant::Plant| {
                let step = ((held - before) / STEP) as u64;
                let matrix = FaultySensor::new(matrix, SensorFault::Off, step, u64::MAX);
                let cell = cell.sensor(file.sensor("matrix", matrix)?);
                let cell = cell.sensor(file.sensor("encoder", mrroc_sensors::virtual_sensors::Encoder)?);
                Ok(cell.sensor(
                    file.sensor("fingers", plant.fingers_before(sorting::camera::layout::BEAM, STEP))?,
                ))
            };
        let ready = settings().heard_by(|matrix| matrix, sense).expect("a cell");
        let (fate, fault) = checked(ready, &format!("{name} lost {before} s before the grasp"));
        match fault {
            Some(text) => assert!(text.contains(name), "{text}"),
            None => assert_eq!(fate, Fate::Sorted),
        }
    }
    let sweep = Sweep::new(|| settings().ready().expect("a cell").cell);
    let process = ProcessId::new(Role::Vsp, Name::new("matrix").expect("a name"));
    // Checked: limits, the cause, standstill within the bound, and that no gripper opens.
    let report =
        sweep.repeat(&Case { injected: Injected::Kill(process), at: ((held - 0.4) / STEP) as u64, seed: 1 });
    assert!(report.is_clean(), "{report}");
}

mod whole {
    use super::{
        echoes_are_lost, parts_lie_below_the_matrix, the_air_changes, the_count_stands, transducers_are_dead,
    };

    #[test]
    #[ignore = "takes minutes: `just sorting-matrix`"]
    fn fault_198_a_dead_transducer_or_a_dead_matrix_is_a_named_fault() {
        transducers_are_dead(usize::MAX);
    }

    #[test]
    #[ignore = "takes minutes: `just sorting-matrix`"]
    fn fault_199_echoes_that_are_lost_make_missed_parts_at_most() {
        echoes_are_lost(usize::MAX);
    }

    #[test]
    #[ignore = "takes minutes: `just sorting-matrix`"]
    fn fault_214_air_that_changes_is_followed_or_a_named_fault() {
        the_air_changes(usize::MAX);
    }

    #[test]
    #[ignore = "takes minutes: `just sorting-matrix`"]
    fn fault_218_a_part_that_lies_below_the_matrix_from_the_beginning_is_not_learned_as_belt() {
        parts_lie_below_the_matrix(usize::MAX);
    }

    #[test]
    #[ignore = "takes minutes: `just sorting-matrix`"]
    fn fault_215_an_encoder_whose_count_stands_makes_missed_parts() {
        the_count_stands(usize::MAX);
    }
}
