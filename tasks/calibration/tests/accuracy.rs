//! How well arms and bases are found.

use std::time::Duration;

use calibration::estimate::estimate;
use calibration::mp::run;
use calibration::random::Random;
use calibration::scene::{Scene, posture};
use calibration::theodolite::SECOND;
use calibration::visits::{visits, without_a_cell};
use mrroc_robots::Six;

/// What friction leaves between a motor and its joint \[rad\]: nothing, since friction here acts on motors, whose encoders see what it does. Errors of
/// joints that all sights of a posture share would make the covariance, which takes sights for independent, too small.
const WINDUP: f64 = 0.0;

/// The root mean square of the errors of the base of one arm in the other [m, rad].
const LENGTH: f64 = 1e-4;
const ANGLE: f64 = 4e-5;

fn unseen(arm: usize) -> Vec<Six> {
    let mut random = Random(77);
    (0..200).map(|_| posture(arm, &mut random)).collect()
}

#[test]
fn an_irp6_is_calibrated_by_a_program_of_moves_and_waits() {
    let scene = Scene::new(2.0 * SECOND, WINDUP, 1);
    let visits = visits(&scene, 40, 5);
    let (sights, time, shared) =
        run(scene, &visits, Duration::from_millis(250)).unwrap_or_else(|why| panic!("{why}"));
    let estimate = estimate(&sights).expect("a fit");
    for arm in 0..2 {
        let accuracy = estimate.accuracy(&shared.scene.borrow(), arm, &unseen(arm));
        println!("{arm}: {accuracy:?} {time:?} {} sights", sights.sights.len());
        // The arm by itself; what is added in the world is the theodolites' own scale and level, one draw of a few numbers.
        assert!(accuracy.own < 3e-5, "{accuracy:?}");
        assert!(accuracy.rms < 3.0 * accuracy.foretold, "{accuracy:?}");
    }
}

/// How many seeds: 100 by MRROC_SEEDS=100, which takes minutes.
fn seeds() -> u64 {
    std::env::var("MRROC_SEEDS").ok().and_then(|seeds| seeds.parse().ok()).unwrap_or(20)
}

/// By what the covariance says: the six numbers of a base in the other each within two standard deviations.
#[test]
fn two_bases_are_found_and_what_is_foretold_of_their_errors_is_true() {
    let (mut within, mut lengths, mut angles, mut ratios) = (0, 0.0, 0.0, 0.0);
    for seed in 1..=seeds() {
        let mut scene = Scene::new(2.0 * SECOND, WINDUP, seed);
        let visits = visits(&scene, 40, seed);
        let measured = without_a_cell(&mut scene, &visits);
        let estimate = estimate(&measured).expect("a fit");
        let bases = estimate.bases(&scene);
        let balls = estimate.accuracy(&scene, 0, &unseen(0));
        ratios += (balls.rms / balls.foretold).powi(2) / seeds() as f64;
        within += bases.within as u64;
        lengths += bases.length.powi(2) / seeds() as f64;
        angles += bases.angle.powi(2) / seeds() as f64;
    }
    let (length, angle) = (f64::sqrt(lengths), f64::sqrt(angles));
    println!(
        "{within} of 6 x {} within two sigma; rms {length:.2e} m, {angle:.2e} rad; balls {:.2} of what is foretold",
        seeds(),
        ratios.sqrt()
    );
    assert!((1.0 / 1.5..1.5).contains(&ratios.sqrt()), "{}", ratios.sqrt());
    // 95.4 % of normally distributed numbers are.
    assert!(100 * within >= 91 * 6 * seeds(), "{within} of 6 x {}", seeds());
    assert!(length < LENGTH && angle < ANGLE, "{length} m, {angle} rad");
}
