//! How well arms and bases are found.

use std::time::Duration;

use calibration::estimate::estimate;
use calibration::mp::run;
use calibration::random::Random;
use calibration::scene::{Scene, posture};
use calibration::theodolite::SECOND;
use calibration::visits::{visits, without_a_cell};
use mrroc_robots::Six;

/// What friction leaves between a motor and its joint \[rad\] (assumed).
const WINDUP: f64 = 1e-5;

fn unseen() -> Vec<Six> {
    let mut random = Random(77);
    (0..200).map(|_| posture(&mut random)).collect()
}

#[test]
fn an_irp6_is_calibrated_by_a_program_of_moves_and_waits() {
    let scene = Scene::new(2.0 * SECOND, WINDUP, 1);
    let visits = visits(&scene, 40, 5);
    let (sights, time, shared) =
        run(scene, &visits, Duration::from_millis(100)).unwrap_or_else(|why| panic!("{why}"));
    let estimate = estimate(&sights).expect("a fit");
    for arm in 0..2 {
        let accuracy = estimate.accuracy(&shared.scene.borrow(), arm, &unseen());
        println!("{arm}: {accuracy:?} {time:?} {} sights", sights.sights.len());
        assert!(accuracy.rms < 3e-5, "{accuracy:?}");
        assert!(accuracy.rms < 1.5 * accuracy.foretold, "{accuracy:?}");
    }
}

#[test]
fn two_bases_are_found_and_their_covariance_is_true_in_95_of_100_seeds() {
    let mut within = 0;
    for seed in 1..=100 {
        let mut scene = Scene::new(2.0 * SECOND, WINDUP, seed);
        let visits = visits(&scene, 40, seed);
        let measured = without_a_cell(&mut scene, &visits);
        let (length, angle, distance) = estimate(&measured).expect("a fit").bases(&scene);
        if seed < 8 {
            println!("{length:e} {angle:e} {distance}");
        }
        within += u32::from(distance < 2.0);
        assert!(length < 9e-5 && angle < 9e-5, "seed {seed}: {length} m, {angle} rad");
    }
    assert!(within >= 95, "{within} of 100");
}
