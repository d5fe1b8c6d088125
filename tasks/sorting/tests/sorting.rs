//! Undisturbed runs: parts are acquired and sorted, at every speed of the belt.
//!
//! A share of the seeds; `MRROC_WHOLE=1` takes a thousand, as `just sorting-whole` does.

use sorting::run::{Sensing, Settings};
use sorting::summary::{SPEEDS, Summary, quantile};
use sorting::witness::Fate;

fn seeds() -> u64 {
    if std::env::var_os("MRROC_WHOLE").is_some() { 1000 } else { 2 * SPEEDS as u64 }
}

#[test]
fn parts_are_acquired_at_all_speeds_within_the_bounds() {
    let summary = Summary::sweep(seeds(), Sensing::Reactive).expect("a cell");
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
fn the_first_edge_alone_misses_most_parts() {
    let summary = Summary::sweep(seeds() / 2, Sensing::FirstEdge).expect("a cell");
    println!("{summary}");
    // Its speed is up to 20 % off on a way of 0.4 m, and a part is 0.05 to 0.1 m long: a third is within reach at best.
    assert!(summary.all().share() < 0.6, "{summary}");
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
