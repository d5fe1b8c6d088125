//! Undisturbed walks.
//!
//! Short ones; `just legs-whole` takes a hundred whole ones by chance.

use legs::plant::Drawn;
use legs::run::{LENGTH, Ready};
use legs::summary::{Row, Summary};
use legs::walk::Gait;

/// Walks over steps by chance, of so many seeds. None falls, and each but the `known` ones keeps its bounds.
fn walks(gait: Gait, seeds: u64, known: &[u64]) {
    let mut summary = Summary { gait, rows: Vec::new() };
    for seed in 0..seeds {
        let outcome = Ready::new(&Drawn::by(seed, LENGTH), &gait, seed).expect("a cell").run();
        summary.rows.push(Row::of(seed, &outcome));
    }
    println!("{summary}");
    assert!(summary.rows.iter().all(|row| !row.fallen), "{summary}");
    let mut bad = summary.rows.iter().filter(|row| !row.is_good(&gait)).map(|row| row.seed);
    assert!(bad.all(|seed| known.contains(&seed)), "{summary}");
    // cos 1°, by which a walk may be aside, is 0.9998.
    assert!(summary.rows.iter().all(|row| row.speed > 0.0995), "{summary}");
}

#[test]
fn it_walks_over_steps_by_chance_without_a_fall_and_keeps_its_margin_and_its_feet() {
    walks(Gait { footsteps: 8, ..Gait::default() }, 2, &[]);
}

mod whole {
    use super::{Gait, walks};

    #[test]
    #[ignore = "takes minutes: `just legs-whole`"]
    fn it_walks_over_steps_by_chance_without_a_fall_and_keeps_its_margin_and_its_feet() {
        // These miss a bound, or end with a fault: the README says why.
        walks(Gait::default(), 100, &[21, 52, 64, 71, 93]);
    }
}

#[test]
fn the_same_seed_gives_the_same_walk_to_the_bit() {
    let gait = Gait { footsteps: 2, ..Gait::default() };
    let walk = || Ready::new(&Drawn::by(3, LENGTH), &gait, 3).expect("a cell").run().seen;
    let bits = |seen: legs::seen::RunMeasurements| -> Vec<u64> {
        seen.film.iter().flat_map(|now| now.centre.iter().map(|x| x.to_bits()).collect::<Vec<_>>()).collect()
    };
    assert_eq!(bits(walk()), bits(walk()));
}

#[test]
fn the_ground_is_felt_with_the_trunk_level_to_a_degree() {
    let gait = Gait { footsteps: 8, ..Gait::default() };
    let outcome = Ready::new(&Drawn::level(0.6), &gait, 1).expect("a cell").run();
    outcome.report.expect("no fault");
    let last = outcome.seen.film.last().expect("a film");
    // It ends where its gait ends, over its feet.
    let distance = gait.advance(gait.ends()) - gait.advance(-gait.ramp);
    assert!((last.X_WT.translation.x - distance).abs() < 2e-3, "{} {distance}", last.X_WT.translation.x);
    assert!(outcome.seen.lean < 1.0_f64.to_radians(), "{}", outcome.seen.lean);
    let weight = 28.4 * legs::leg::GRAVITY;
    let up: f64 = last.forces.iter().map(|force| force.z).sum();
    assert!((up / weight - 1.0).abs() < 0.01, "{up} {weight}");
}
