//! A summary of what SAFETY.md promises, with the tests of each promise.

use mrroc::testing::SweepReport;

use crate::safety::cells::{cooperating, interpolated, sensing, transparent};
use crate::safety::sensors::{MODES, failing};
use crate::safety::sweeps::everything;

/// The rows of the table: a number, the fault, the names of its tests.
fn rows() -> Vec<(String, String, usize)> {
    let table = include_str!("../../SAFETY.md").split("## Rows").nth(1).expect("a table").lines();
    let cells = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let rows = table.filter(|line| line.starts_with('|')).map(cells).skip(2);
    rows.filter_map(|row| match &row[..] {
        [_, number, fault, .., tests, _] => {
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
