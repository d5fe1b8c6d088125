//! Chapter 3 of the tutorial: two robots that cooperate tightly. Its loose half is the template's own.

#[path = "3_tight/ecp.rs"]
mod ecp;
#[path = "3_tight/mp.rs"]
mod mp;

use super::support::{TWO, extent, file, printed, shows, watched};
use crate::arm;

#[test]
fn both_tools_are_equally_high_in_every_servo_period() {
    let cell = file(TWO).cell(&arm::kinds()).expect("known");
    let (cell, paths) = watched(ecp::programs(cell).program(mp::coordinate));
    let report = cell.run().expect("within the limits");
    assert!((4.0..4.02).contains(&report.time.as_secs_f64()), "{report:?}");
    shows("3-pair.md", &printed(&report));
    for robot in ["left", "right"] {
        let (low, high) = extent(&paths, robot, 2);
        assert!(low > -1e-3 && (high - 0.1).abs() < 1e-3, "{robot}: {low} {high}");
    }
    let heights = |robot| {
        paths.borrow().iter().filter(|(name, _)| name == robot).map(|(_, at)| at[2]).collect::<Vec<_>>()
    };
    let (left, right) = (heights("left"), heights("right"));
    assert_eq!(left.len(), right.len());
    assert!(left.iter().zip(&right).all(|(left, right)| (left - right).abs() < 1e-9));
}

#[test]
fn halves_that_disagree_are_refused_before_anything_moves() {
    #[derive(Clone, Copy, mrroc::payload::Payload)]
    enum Phase {
        Out,
    }
    #[mrroc::generator(mp)]
    fn ask() -> mrroc::generator::Always<(arm::Arm, arm::Arm), Phase> {
        mrroc::generator::Always((Phase::Out, Phase::Out))
    }
    let cell = ecp::programs(file(TWO).cell(&arm::kinds()).expect("known")).program(|mp| {
        let (mut left, mut right) = (mp.robot("left")?, mp.robot("right")?);
        mp.move_robots((&mut left, &mut right), (), ask {}).map(drop)
    });
    let (cell, paths) = watched(cell);
    let fault = cell.run().expect_err("the halves disagree").to_string();
    assert!(fault.contains("disagree about the order"), "{fault}");
    let (low, high) = extent(&paths, "left", 2);
    assert!(low > -1e-4 && high < 1e-4);
}
