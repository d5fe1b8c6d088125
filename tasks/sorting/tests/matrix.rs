//! With the matrix: recognition, places, grasps. `just sorting-matrix` tries more.

use mrroc::prelude::*;
use mrroc_sensors::aggregation::Reliefs;
use mrroc_sensors::physics::Sounders;
use mrroc_sensors::ultrasound::Air;
use nalgebra::Vector3;
use sorting::camera::kinds::{KINDS, kinds};
use sorting::camera::settings::{Overhead, Settings};
use sorting::camera::studio::{Lying, Passing};
use sorting::camera::summary::{Line, Table};
use sorting::matrix::command::{counted, examination, rms};
use sorting::matrix::layout::{MATRIX, array};
use sorting::matrix::run::{network, sensors};
use sorting::matrix::studio::{Conditions, Trial, examine};
use sorting::monitor::Fate;
use sorting::summary::quantile;

/// Parts and strangers that no training has heard; so many of the parts are to be recognised.
fn examined(conditions: &Conditions, count: usize, share: f64) {
    let conditions = Conditions { stranger: 9, ..*conditions };
    let trials =
        examine(count, 3_000_000, &conditions, Box::new(network().expect("a network")), |_, _, _| ());
    let trials = trials.expect("it hears");
    println!("{}", examination(&trials));
    let counts = counted(&trials);
    let [right, misnamed, rejected] = counts.counts();
    assert_eq!(misnamed, 0, "misnamed");
    assert!(f64::from(right) >= share * f64::from(right + rejected), "{right} right, {rejected} rejected");
    // Not one stranger has a name.
    let row = counts.0[KINDS];
    assert!(row[KINDS] > 0 && row[..KINDS].iter().all(|count| *count == 0), "{row:?}");
    let known = || {
        trials.iter().filter(|trial: &&Trial| trial.heard.as_ref().is_some_and(|heard| heard.class.is_some()))
    };
    let off: Vec<f64> = known().map(|trial| trial.off[0].hypot(trial.off[1])).collect();
    let turned: Vec<f64> = known().map(|trial| trial.turned.to_degrees()).collect();
    assert!(
        rms(&off) <= 2e-3 && quantile(&turned, 0.95) <= 5.0,
        "{} m, {} deg",
        rms(&off),
        quantile(&turned, 0.95)
    );
}

#[test]
fn parts_that_no_training_has_heard_are_recognised_and_strangers_rejected() {
    examined(&Conditions::USUAL, 11, 0.98);
}

/// Each seed is another matrix, in air of another temperature, over a belt of another speed.
fn bare_belts_are_learned(seeds: core::ops::Range<u64>) {
    for seed in seeds {
        for conditions in [Conditions::USUAL, Conditions::HARD, Conditions::ALL] {
            let network = Box::new(network().expect("a network"));
            let trials = examine(1, seed, &conditions, network, |_, _, _| ());
            let trials = trials.unwrap_or_else(|deaf| panic!("seed {seed}, {conditions:?}: {deaf}"));
            assert!(trials[0].heard.is_some(), "seed {seed}, {conditions:?}: the part was not noticed");
        }
    }
}

#[test]
fn a_bare_belt_is_learned_before_a_part_comes_though_echoes_are_lost() {
    bare_belts_are_learned(0..6);
}

#[test]
fn a_tenth_of_the_echoes_may_be_lost_and_the_air_be_warmer_or_colder_by_5_kelvin() {
    examined(&Conditions::HARD, 11, 0.88);
}

/// Two parts of these kinds pass, as near behind each other as parts come, on a belt that is as slow as those of the long runs.
fn neighbours_are_heard_apart([first, second]: [usize; 2], seed: u64) {
    let (kinds, speed, spacing) = (kinds(), 0.0164, 0.2);
    let lying =
        |kind: usize, x: f64| Lying::of(Some(kind), kinds[kind].class.form.clone(), [x, 0.005], 1.2, 0.5);
    let parts = vec![lying(first, MATRIX[0] - 0.2), lying(second, MATRIX[0] - 0.2 - spacing)];
    let places: Vec<Vector3<f64>> = parts.iter().map(|part| part.pose.translation.vector).collect();
    let mut passing = Passing { parts, speed, run: 0.0, now: 0.0 };
    let array = array();
    let mut sounders = Sounders::over(&array, Air { celsius: 20.0 }, seed);
    let (mut reliefs, mut middles) = (Reliefs::by(array.clone()), Vec::new());
    for ping in 1_u32..9000 {
        passing.now = f64::from(ping) * array.period;
        passing.run = speed * passing.now;
        for (part, place) in passing.parts.iter_mut().zip(&places) {
            part.pose.translation.vector.x = place.x + passing.run;
        }
        let number = array.turn(ping.into());
        let echo = sounders.ping(&passing, number, passing.now);
        reliefs.take(number, echo, passing.run).expect("it hears");
        middles.extend(reliefs.passed(passing.run).map(|relief| {
            let along = || relief.samples.iter().map(|sample| sample.along);
            0.5 * (along().fold(f64::INFINITY, f64::min) + along().fold(f64::NEG_INFINITY, f64::max))
        }));
    }
    assert_eq!(middles.len(), 2, "{middles:?}");
    for (middle, place) in middles.iter().zip([-0.2, -0.2 - spacing]) {
        assert!((middle - MATRIX[0] - place).abs() < 0.03, "{middles:?}");
    }
}

#[test]
fn parts_that_come_close_behind_each_other_on_a_slow_belt_are_heard_apart() {
    // Half-cylinder and step.
    neighbours_are_heard_apart([5, 6], 3);
}

/// So many parts at each speed \[m/s\], of which at least a share is sorted.
fn parts_go_to_their_bins(parts: usize, speeds: &[f64], least: f64) {
    for &speed in speeds {
        let settings = Settings::of(speed, parts, Settings::CYCLE / 0.6, 4).below(Overhead::Matrix);
        let outcome = settings.run().expect("a cell");
        let line = Line::of(&settings, &outcome);
        println!("{}", Table(vec![line.clone()]));
        assert!(outcome.report.is_ok(), "{:?}", outcome.report);
        assert_eq!((line.wrong, line.crashes), (0, 0));
        // What is not recognised passes; there are no other misses.
        assert!(outcome.count(Fate::Sorted) as f64 >= least * parts as f64, "{:?}", line.missed);
        assert!(rms(&line.places) <= 2e-3, "{} m", rms(&line.places));
    }
}

#[test]
fn parts_heard_by_the_matrix_go_to_the_bins_of_their_kinds() {
    parts_go_to_their_bins(1, &[0.1], 1.0);
}

/// The programs are the same functions, because one line of `camera/run.rs` gives them to both cells.
#[test]
fn the_cells_of_camera_and_matrix_differ_in_the_sensors_table_alone() {
    let tables = |text: &str| -> Vec<String> {
        let lines = text.lines().filter(|line| !line.starts_with('#') && !line.trim().is_empty());
        lines.map(|line| line.replace("[sensors.matrix]", "[sensors.camera]")).collect()
    };
    let files = [include_str!("../cell-camera.toml"), include_str!("../cell-matrix.toml")];
    assert_eq!(tables(files[0]), tables(files[1]));
}

/// The modes of a VSP other than the one of the cell's file.
const MODES: [&str; 2] = ["mode = \"free running\"\nperiod_ms = 4", "mode = \"interactive\""];

fn parts_are_placed_and_sorted_in(modes: &[&str]) {
    let text = include_str!("../cell-matrix.toml");
    let table = "readers = []\nmode = \"with delay\"";
    assert!(text.contains(table));
    for mode in modes {
        let text = text.replace(table, &format!("readers = []\n{mode}"));
        let file = CellFile::parse("cell-matrix.toml", &text).expect("a file");
        let settings = Settings::of(0.1, 1, 10.0, 4).below(Overhead::Matrix);
        let outcome = settings.heard_in(file, |matrix| matrix, sensors).expect("a cell").run();
        let line = Line::of(&settings, &outcome);
        assert_eq!((outcome.count(Fate::Sorted), line.crashes), (1, 0), "{mode}: {outcome:?}");
        assert!(line.places[0] < 3e-3, "{mode}: {:?}", line.places);
    }
}

#[test]
fn parts_are_placed_within_3_mm_and_sorted_in_each_mode_of_the_matrix_s_vsp() {
    parts_are_placed_and_sorted_in(&MODES[..1]);
}

#[test]
fn the_same_seed_gives_the_same_run_with_the_matrix_to_the_bit() {
    let settings = Settings::of(0.12, 1, 10.0, 9).below(Overhead::Matrix);
    let [one, two] = [(), ()].map(|()| settings.run().expect("a cell"));
    assert!(!one.looks.is_empty() && (one.grips, one.looks) == (two.grips, two.looks));
}

mod whole {
    use super::{
        Conditions, MODES, bare_belts_are_learned, examined, parts_are_placed_and_sorted_in,
        parts_go_to_their_bins,
    };

    #[test]
    #[ignore = "takes minutes: `just sorting-matrix`"]
    fn a_bare_belt_is_learned_before_a_part_comes_though_echoes_are_lost() {
        bare_belts_are_learned(0..1000);
    }

    #[test]
    #[ignore = "takes minutes: `just sorting-matrix`"]
    fn parts_that_no_training_has_heard_are_recognised_and_strangers_rejected() {
        examined(&Conditions::USUAL, 2250, 0.98);
    }

    #[test]
    #[ignore = "takes minutes: `just sorting-matrix`"]
    fn a_tenth_of_the_echoes_may_be_lost_and_the_air_be_warmer_or_colder_by_5_kelvin() {
        examined(&Conditions::HARD, 2250, 0.95);
    }

    #[test]
    #[ignore = "takes minutes: `just sorting-matrix`"]
    fn parts_heard_by_the_matrix_go_to_the_bins_of_their_kinds() {
        parts_go_to_their_bins(200, &[0.05, 0.1, 0.15], 0.97);
    }

    #[test]
    #[ignore = "takes minutes: `just sorting-matrix`"]
    fn parts_are_placed_within_3_mm_and_sorted_in_each_mode_of_the_matrix_s_vsp() {
        parts_are_placed_and_sorted_in(&MODES);
    }
}
