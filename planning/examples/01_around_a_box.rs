//! An arm goes from one side of a box to the other and back, on motions that are planned while the program runs.
//!
//! `cargo run -p mrroc-examples --example 01_around_a_box`

use std::cell::RefCell;
use std::rc::Rc;

use mrroc_robots::clearance::DryRun;
use mrroc_robots::{Simulated, Six};

// ANCHOR: program
use std::time::Duration;

use mrroc::prelude::*;
use mrroc_planning::{HereAll, Planner, goals_at};
use mrroc_robots::clearance::{Clearance, ClearanceError, Obstacle, Stopping};
use mrroc_robots::{Serial, SerialOutline};
use nalgebra::Vector3;

/// What is around the arm, which is to stay 20 mm apart from it.
fn world(arm: &Serial<6>, step: Duration) -> Result<Clearance, ClearanceError> {
    let half = Vector3::new(0.1, 0.1, 0.3); // a box of 0.2 x 0.2 x 0.6 m
    Clearance::with_margin(0.02)
        .robot("arm", SerialOutline::new(arm.clone(), 0.06))? // links with a radius of 60 mm
        .obstacle("box", Obstacle::Box { X_WO: Pose::translation(-0.55, -0.1, 0.2), half })?
        .obstacle("table", Obstacle::table(-0.1))?
        .ignore(("arm", "link 0"), ("table", "table")) // the arm stands on it
        .build(Stopping::of_guard(step, 1))
}

/// The flange goes to one pose after the other.
fn visit(mp: &mut Mp, robot: &Serial<6>, mut planner: Planner, poses: &[Pose]) -> Result<(), Fault> {
    let mut arm = mp.robot::<Serial<6>>("arm")?;
    for pose in poses {
        let here = mp.wait_until((&mut arm,), (), HereAll::<(Serial<6>,)>::default())?.joints();
        let plan = planner.plan(&here, &goals_at(robot, pose, &here))?;
        mp.move_robot(&mut arm, (), plan.motion("arm")?)?;
    }
    Ok(())
}
// ANCHOR_END: program

/// Right and left of the box, stretched out low \[rad\].
const SIDES: [Six; 2] =
    [Six::new(-0.9, -0.3, 0.6, -1.8, -1.57, 0.0), Six::new(0.9, -0.3, 0.6, -1.8, -1.57, 0.0)];

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let step = Duration::from_millis(2);
    let urdf = include_str!("../../template/sets/ur5e/ur5e.urdf");
    let robot = Serial::<6>::from_urdf(urdf, "base", "tool0")?.with_acceleration(Six::repeat(8.0))?;
    let poses = [robot.forward(&SIDES[1]), robot.forward(&SIDES[0])];
    let planner = Planner::new(world(&robot, step)?)?;
    let straight = world(&robot, step)?.nearest_at(&[((SIDES[0] + SIDES[1]) / 2.0).as_slice()])?;
    assert!(straight.distance < 0.0, "straight from side to side it would meet the box: {straight}");

    // The first of its motions as it is planned: how near it comes, and how near its stops do.
    let here = SIDES[0].as_slice();
    let plan = planner.clone().plan(here, &goals_at(&robot, &poses[0], here))?;
    let closest = plan.closest(&mut world(&robot, step)?, step.as_secs_f64())?;
    println!("{closest}");
    assert!(closest.distance() >= 0.02, "{closest}");

    let seen = Rc::new(RefCell::new(DryRun::new(world(&robot, step)?)));
    let watched = Rc::clone(&seen);
    let drives = Simulated::new(robot.clone(), &SIDES[0]);
    let arm = robot.clone();
    Cell::new(step)
        .robot(RobotSetup::new("arm", robot, drives))
        .program(move |mp| visit(mp, &arm, planner.clone(), &poses))
        .watch(move |observation| watched.borrow_mut().observe(observation))
        .run()?;
    let mut seen = seen.borrow_mut();
    let closest = seen.closest()?.ok_or("nothing was seen")?;
    println!("{} at {:.3} s", closest.nearest, closest.time);
    // Demands are in double precision; encoders round what simulated drives stand at to less than 0.1 mm.
    assert!(closest.nearest.distance >= 0.0199, "{}", closest.nearest);
    Ok(())
}
