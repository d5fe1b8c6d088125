//! A summary of the faults of docs/safety, with the tests of each.

use mrroc::testing::SweepReport;

use crate::safety::cells::{cooperating, interpolated, sensing, transparent};
use crate::safety::sensors::{MODES, failing};
use crate::safety::sweeps::everything;

/// The rows of the page that `.ci/safety-rows` writes: a number, the fault, how many tests it has.
fn rows() -> Vec<(String, String, usize)> {
    let lines = include_str!("../../docs/src/faults.md").lines().filter(|line| line.starts_with('|'));
    let cells = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let rows = lines.map(cells);
    rows.filter_map(|row| match &row[..] {
        [_, number, fault, .., tests, _] if number.starts_with(|first: char| first.is_ascii_digit()) => {
            let count = tests.matches('`').count() / 2;
            Some((number.clone(), fault.clone(), count))
        }
        _ => None,
    })
    .collect()
}

#[test]
fn every_row_of_the_table_names_a_test() {
    let rows = rows();
    assert!(rows.len() >= 40, "{} rows", rows.len());
    for (number, fault, tests) in rows {
        assert!(tests > 0, "row {number} ({fault}) names no test");
    }
}

/// `just safety`.
#[test]
#[ignore = "takes a minute"]
fn summary() {
    for (number, fault, tests) in rows() {
        println!("{number:>6}  {tests} tests  {fault}");
    }
    let mut all = SweepReport::default();
    for cell in [transparent, cooperating, interpolated, sensing] {
        all.absorb(everything(cell).every(13).run());
    }
    for mode in MODES {
        all.absorb(failing(mode, true, 7));
    }
    println!("\n{all}");
    assert!(all.is_clean(), "{all}");
}
