//! An arm goes from one side of a box to the other and back, on motions that are planned when the program runs.
//!
//! `cargo run -p mrroc-examples --example 01_around_a_box`

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

// ANCHOR: program
use mrroc::prelude::*;
use mrroc_planning::{HereAll, Planner, goals_at};
use mrroc_robots::clearance::{Clearance, DryRun, Obstacle, Stopping};
use mrroc_robots::{Irp6, SimulatedIrp6, Six};
use nalgebra::Vector3;

/// What the planner knows: an arm and a box, which are to stay 20 mm apart.
fn world(step: Duration) -> Result<Clearance, Box<dyn std::error::Error>> {
    let half = Vector3::new(0.1, 0.1, 0.2); // edges of 0.2 x 0.2 x 0.4 m
    Ok(Clearance::with_margin(0.02)
        .robot("arm", Irp6::nominal())?
        .obstacle("box", Obstacle::Box { X_WO: Pose::translation(0.85, 0.0, 0.2), half })?
        .build(Stopping::of_guard(step, 1))?)
}

/// The flange goes to each of these poses in turn.
fn visit(mp: &mut Mp, mut planner: Planner, poses: &[Pose]) -> Result<(), Fault> {
    let mut arm = mp.robot::<Irp6>("arm")?;
    for pose in poses {
        let here = mp.wait_until((&mut arm,), (), HereAll::<(Irp6,)>::default())?.joints();
        let plan = planner.plan(&here, &goals_at(&Irp6::nominal(), pose, &here))?;
        println!("{:.2} s", plan.duration());
        mp.move_robot(&mut arm, (), plan.motion("arm")?)?;
    }
    Ok(())
}
// ANCHOR_END: program

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (robot, step) = (Irp6::nominal(), Duration::from_millis(2));
    let sides = [-0.7, 0.7].map(|turn| Irp6::READY + Six::x() * turn);
    let poses = [robot.forward(&sides[1]), robot.forward(&sides[0])];
    println!("{}", robot.forward(&Irp6::READY));
    let planner = Planner::new(world(step)?)?;

    let seen = Rc::new(RefCell::new(DryRun::new(world(step)?)));
    let watched = Rc::clone(&seen);
    let start = sides[0];
    Cell::new(step)
        .robot(RobotSetup::new("arm", robot.clone(), SimulatedIrp6::new(robot, &start)))
        .program(move |mp| visit(mp, planner.clone(), &poses))
        .watch(move |observation| watched.borrow_mut().observe(observation))
        .run()?;
    let mut seen = seen.borrow_mut();
    let closest = seen.closest()?.ok_or("nothing was seen")?;
    println!("{}", closest.nearest);
    assert!(closest.nearest.distance >= 0.02);
    Ok(())
}
