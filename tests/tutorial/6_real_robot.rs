//! Chapter 6 of the tutorial: the program of a project with the drives of a Franka, which simulated ones stand in for here.

#[path = "6_real_robot/arm.rs"]
mod arm;

use mrroc::cell_file::CellFile;
use mrroc::prelude::*;
use mrroc_generators::generators::{JointMove, StraightLine};
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_robots::Seven;

use super::page::{Edit, Step, chapters, read, root, steps};
use super::support::{extent, watched};

fn cell() -> Cell {
    let file = CellFile::read(root().join("tests/tutorial/6_real_robot/cell.toml")).expect("in order");
    file.cell(&arm::kinds()).expect("known")
}

/// The tool goes so far, seen from itself [m].
fn by(x: f64, y: f64, z: f64) -> StraightLine<arm::Arm> {
    let limits = |velocity, acceleration| ProfileLimits { velocity, acceleration };
    let limits = ToolLimits { translation: limits(0.1, 0.2), rotation: limits(0.5, 1.0) };
    StraightLine::by(Pose::translation(x, y, z), limits)
}

#[test]
fn from_where_the_simulator_begins_the_arm_rises_once_it_is_bent() {
    let cell = cell().program(|mp| {
        let mut arm = mp.robot::<arm::Arm>("arm")?;
        let ready = Seven::from([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]); // [rad]
        mp.move_robot(&mut arm, (), JointMove::to(ready, Seven::repeat(0.3), Seven::repeat(0.6)))?;
        let bent = arm.demanded().pose.translation.z;
        mp.move_robot(&mut arm, (), by(0.0, 0.0, -0.1))?;
        assert!((arm.demanded().pose.translation.z - bent - 0.1).abs() < 1e-6);
        Ok(())
    });
    let (cell, paths) = watched(cell.simulated().expect("drives stand in"));
    cell.run().expect("within the limits");
    assert!(extent(&paths, "arm", 2).1 > 0.05);
}

#[test]
fn beside_the_shoulders_singularity_the_message_says_what_to_do() {
    let cell = cell().program(|mp| {
        let mut arm = mp.robot::<arm::Arm>("arm")?;
        mp.move_robot(&mut arm, (), by(0.0, 0.1, 0.0)).map(drop)
    });
    let refused = cell.simulated().expect("drives stand in").run().expect_err("beside a singularity");
    let mrroc::cell::CellError::Fault(fault) = refused else { panic!("{refused}") };
    assert!(fault.message().contains("near the shoulder singularity"), "{fault}");
    assert!(fault.help().is_some_and(|help| help.contains("demand joints")), "{:?}", fault.help());
}

/// The lines that the chapter adds to the template's program are those of the test above.
#[test]
fn the_chapter_adds_the_posture_that_is_tested() {
    let (_, text) =
        chapters().into_iter().find(|(name, _)| name.contains("6-real-robot")).expect("a chapter");
    let tested = read(root().join("tests/tutorial/6_real_robot.rs"));
    let mut added = 0;
    for step in steps("6-real-robot", &text) {
        if let Step::Edit(file, Edit::Line(_, new)) = step
            && file == "src/mp.rs"
        {
            for line in new.lines().filter(|line| line.contains("ready")) {
                assert!(tested.lines().any(|tested| tested.trim() == line.trim()), "{line}");
                added += 1;
            }
        }
    }
    assert_eq!(added, 2);
}
