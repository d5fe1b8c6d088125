//! Chapter 5 of the tutorial: drives of one's own in the place of the simulated ones.

#[path = "5_driver/arm.rs"]
mod arm;

use mrroc::cell_file::Kinds;
use mrroc::fault::FaultKind;
use mrroc::prelude::*;

use super::point_to_point as line;
use super::support::{ONE, extent, file, printed, shows, watched};

fn cell(kinds: &Kinds) -> Cell {
    file(ONE).cell(kinds).expect("known").program(|mp| {
        let mut arm = mp.robot::<arm::Arm>("arm")?;
        mp.move_robots((&mut arm,), (), line::PointToPoint::by(0.0, 0.0, 0.1))?;
        mp.move_robots((&mut arm,), (), line::PointToPoint::by(0.0, 0.0, -0.1)).map(drop)
    })
}

#[test]
fn the_program_moves_the_other_drives() {
    let (cell, paths) = watched(cell(&arm::kinds()));
    shows("5-driver.md", &printed(&cell.run().expect("within the limits")));
    let (low, high) = extent(&paths, "arm", 2);
    assert!(low > -1e-4 && (high - 0.1).abs() < 1e-4, "{low} {high}");
}

#[test]
fn drives_that_do_not_answer_stop_the_cell_as_the_page_says() {
    let kinds = Kinds::new().with("irp6", |entry| {
        let arm = arm::Arm::nominal();
        let counts = std::array::from_fn(|i| (entry.start(&arm).expect("given")[i] / 1e-5) as i64);
        let drives = arm::Drives { bus: arm::Bus { counts, connected: false }, velocity: Default::default() };
        Ok(RobotSetup::new(entry.name(), arm, drives))
    });
    let mrroc::cell::CellError::Fault(fault) = cell(&kinds).run().expect_err("no answer") else { panic!() };
    assert_eq!(fault.kind(), FaultKind::DriveFault);
    shows("5-driver.md", &format!("error: {fault}"));
}
