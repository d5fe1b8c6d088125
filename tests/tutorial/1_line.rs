//! Chapter 1 of the tutorial: a line, one that asks too much, and a circle.

#[path = "1_line/point_to_point.rs"]
mod circle;

use super::point_to_point as line;
use super::support::{ONE, extent, file, matches, printed, shows, watched};
use crate::arm::{self, Arm};

#[test]
fn a_line_goes_up_and_down_again() {
    let cell = file(ONE).cell(&arm::kinds()).expect("known").program(|mp| {
        let mut arm = mp.robot::<Arm>("arm")?;
        mp.move_robots((&mut arm,), (), line::PointToPoint::by(0.0, 0.0, 0.1))?;
        mp.move_robots((&mut arm,), (), line::PointToPoint::by(0.0, 0.0, -0.1)).map(drop)
    });
    let (cell, paths) = watched(cell);
    let report = cell.run().expect("within the limits");
    let (low, high) = extent(&paths, "arm", 2);
    assert!(low > -1e-3 && (high - 0.1).abs() < 1e-3, "{low} {high}");
    shows("1-line.md", &printed(&report));
}

#[test]
fn a_line_of_half_a_metre_is_refused_as_the_page_says() {
    let cell = file(ONE).cell(&arm::kinds()).expect("known").program(|mp| {
        let mut arm = mp.robot::<Arm>("arm")?;
        mp.move_robots((&mut arm,), (), line::PointToPoint::by(0.0, 0.0, 0.5)).map(drop)
    });
    let fault = cell.run().expect_err("beyond a limit");
    shows("1-line.md", &format!("error: {fault}"));
}

#[test]
fn two_circles_make_an_eight() {
    let cell = file(ONE).cell(&arm::kinds()).expect("known").program(|mp| {
        let mut arm = mp.robot::<Arm>("arm")?;
        mp.move_robots((&mut arm,), (), circle::PointToPoint::by(0.0, 0.0, 0.1))?;
        mp.move_robots((&mut arm,), (), circle::PointToPoint::by(0.0, 0.0, -0.1)).map(drop)
    });
    let (cell, paths) = watched(cell);
    cell.run().expect("within the limits");
    for (axis, expected) in [(1, 0.05), (2, 0.1)] {
        let (low, high) = extent(&paths, "arm", axis);
        assert!((low + expected).abs() < 1e-3 && (high - expected).abs() < 1e-3, "{axis}: {low} {high}");
    }
}

#[test]
fn what_is_shown_matches_with_gaps() {
    assert!(matches("not .. m", "not 0.2 m") && matches("a", "a") && matches("a..c..", "abcd"));
    assert!(!matches("not .. m", "not 0.2 s") && !matches("a", "ab"));
}
