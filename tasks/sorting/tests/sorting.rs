//! Undisturbed runs: parts are acquired and sorted, at every speed of the belt.
//!
//! A share of the seeds; `just sorting-whole` takes a thousand.

use sorting::monitor::Fate;
use sorting::run::{Sensing, Settings};
use sorting::summary::{SPEEDS, Summary, quantile};

/// A share of the seeds: two at each speed.
const SEEDS: u64 = 2 * SPEEDS as u64;

fn parts_are_acquired(seeds: u64) {
    let summary = Summary::sweep(seeds, Sensing::Reactive).expect("a cell");
    println!("{summary}");
    let all = summary.all();
    // 99.5 % of the parts; where fewer than 200 come, all of them.
    assert!(all.share() >= 0.995, "{} of {} acquired\n{summary}", all.sorted, all.parts);
    assert_eq!((all.wrong, all.faults, all.crashes), (0, 0, 0), "{summary}");
    let off = quantile(&all.off, 0.95);
    assert!(off <= 3e-3, "{off} m off the middle (p95)");
    let slip = quantile(&all.slip, 1.0);
    assert!(slip <= 5e-3, "{slip} m/s relative speed at the first touch");
}

#[test]
fn parts_are_acquired_at_all_speeds_within_the_bounds() {
    parts_are_acquired(SEEDS);
}

fn most_parts_are_missed_by_the_first_edge(seeds: u64) {
    let summary = Summary::sweep(seeds, Sensing::FirstEdge).expect("a cell");
    println!("{summary}");
    // Its speed is up to 20 % off over a distance of 0.4 m, and a part is 0.05 to 0.1 m long: a third is within reach at best.
    assert!(summary.all().share() < 0.6, "{summary}");
}

#[test]
fn the_first_edge_alone_misses_most_parts() {
    most_parts_are_missed_by_the_first_edge(SEEDS / 2);
}

mod whole {
    #[test]
    #[ignore = "takes minutes: `just sorting-whole`"]
    fn parts_are_acquired_at_all_speeds_within_the_bounds() {
        super::parts_are_acquired(1000);
    }

    #[test]
    #[ignore = "takes minutes: `just sorting-whole`"]
    fn the_first_edge_alone_misses_most_parts() {
        super::most_parts_are_missed_by_the_first_edge(500);
    }
}

#[test]
fn parts_one_after_another_go_to_their_trays() {
    let settings = Settings { parts: 6, ..Settings::one(0.1, 5) };
    let outcome = settings.run().expect("a cell");
    assert_eq!(
        outcome.count(Fate::Sorted),
        6,
        "{:?} {:?}",
        outcome.fates,
        outcome.report.map(|report| report.time)
    );
}

#[test]
fn the_same_seed_gives_the_same_run_to_the_bit() {
    let settings = Settings::one(0.12, 9);
    let [one, two] = [(), ()].map(|()| settings.run().expect("a cell").grips);
    assert!(!one.is_empty() && one == two, "{one:?} {two:?}");
}
