//! Undisturbed runs: the exit is found by touch alone.
//!
//! A few mazes; `MRROC_WHOLE=1` takes a hundred by chance.

use maze::plant::stylus::TRAVEL;
use maze::run::Ready;
use maze::summary::Summary;
use mrroc_map::Layout;

fn shipped() -> Vec<(String, Layout)> {
    [("islands", include_str!("../mazes/islands.txt")), ("comb", include_str!("../mazes/comb.txt"))]
        .map(|(name, text)| (name.to_owned(), text.parse().expect("a maze")))
        .into()
}

#[test]
fn the_exit_is_found_by_touch_without_a_fault_or_over_travel() {
    let mut mazes = shipped();
    let count = if std::env::var_os("MRROC_WHOLE").is_some() { 100 } else { 1 };
    mazes.extend((0..count).map(|seed| (format!("seed {seed}"), Layout::random(16, seed))));
    let summary = Summary::sweep(maze::options::EffectorKind::Arm, &mazes);
    println!("{summary}");
    assert_eq!(summary.faults(), 0, "{summary}");
    for row in &summary.0 {
        assert!(row.travel < TRAVEL, "{summary}");
        // No way of a ball is shorter than the shortest one, which is 0.3 % too short at most.
        assert!(row.ratio > 0.999, "{summary}");
    }
}

#[test]
fn the_left_hand_rule_goes_round_an_island_where_the_map_finds_the_exit() {
    let (_, islands) = &shipped()[0];
    assert_eq!(islands.cells_by_the_left_hand(), None);
}

#[test]
fn the_same_seed_gives_the_same_run_to_the_bit() {
    let (_, comb) = &shipped()[1];
    let [one, two] = [(), ()].map(|()| Ready::new(comb, 4).expect("a cell").run());
    assert!(one.way.to_bits() == two.way.to_bits() && one.trace == two.trace && one.contacts == two.contacts);
}
