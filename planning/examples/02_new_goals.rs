//! An arm on its way around a box is given new goals, and goes to them without a rest.
//!
//! `cargo run -p mrroc-examples --example 02_new_goals`

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::time::Duration;

use mrroc::prelude::*;
use mrroc_planning::{Following, HereAll, Planner, Replanned, Replanner};
use mrroc_robots::clearance::{Clearance, ClearanceError, Obstacle, Stopping};
use mrroc_robots::{Serial, SerialOutline, Simulated, Six};
use nalgebra::Vector3;

/// Right of the box, stretched out low \[rad\].
const START: Six = Six::new(-0.9, -0.3, 0.6, -1.8, -1.57, 0.0);
/// To its left, above it, and back on its right.
const GOALS: [Six; 3] = [
    Six::new(0.9, -0.3, 0.6, -1.8, -1.57, 0.0),
    Six::new(0.1, -1.6, 0.5, -0.5, -1.57, 0.0),
    Six::new(-0.7, -0.3, 0.6, -1.8, -1.57, 0.0),
];

fn world(arm: &Serial<6>, step: Duration) -> Result<Clearance, ClearanceError> {
    let half = Vector3::new(0.1, 0.1, 0.3);
    Clearance::with_margin(0.02)
        .robot("arm", SerialOutline::new(arm.clone(), 0.06))?
        .obstacle("box", Obstacle::Box { X_WO: Pose::translation(-0.55, -0.1, 0.2), half })?
        .obstacle("table", Obstacle::table(-0.1))?
        .ignore(("arm", "link 0"), ("table", "table"))
        .build(Stopping::of_guard(step, 1))
}

// ANCHOR: program
/// The arm goes to the first goal. On the way it is told of the others, one after the other.
fn pursue(mp: &mut Mp, replanner: &mut Replanner, goals: &[Six]) -> Result<(), Fault> {
    let mut arm = mp.robot::<Serial<6>>("arm")?;
    let here = mp.wait_until((&mut arm,), (), HereAll::<(Serial<6>,)>::default())?.joints();
    let plan = replanner.planner().plan(&here, &[goals[0].as_slice().to_vec()])?;
    let following = Following::new(&plan);
    mp.start_robot(&mut arm, following.motion("arm")?)?; // returns at once
    for goal in &goals[1..] {
        // Your program waits for a sensor here.
        mp.wait_until((), (), following.reached(following.time() + 0.3))?;
        match replanner.hand_over(mp, &following, 0.2, &[goal.as_slice().to_vec()])? {
            Replanned::HandedOver(plan) => println!("a new goal, reached at {:.3} s", plan.duration()),
            Replanned::Kept(why) => println!("no new plan: {}", why.message()),
        }
    }
    mp.wait_until((), (), following.reached(f64::INFINITY))?; // to its end
    mp.end_robot(&mut arm)
}
// ANCHOR_END: program

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let step = Duration::from_millis(2);
    let urdf = include_str!("../../template/sets/ur5e/ur5e.urdf");
    let robot = Serial::<6>::from_urdf(urdf, "base", "tool0")?.with_acceleration(Six::repeat(8.0))?;
    let replanner = RefCell::new(Replanner::new(Planner::new(world(&robot, step)?)?)?);
    let drives = Simulated::new(robot.clone(), &START);
    let demanded = Rc::new(Cell::new(START));
    let last = Rc::clone(&demanded);
    mrroc::prelude::Cell::new(step)
        .robot(RobotSetup::new("arm", robot, drives))
        .program(move |mp| pursue(mp, &mut replanner.borrow_mut(), &GOALS))
        .watch(move |servo| last.set(Six::from_column_slice(servo.demanded)))
        .run()?;
    assert!((demanded.get() - GOALS[2]).amax() < 1e-9, "{}", demanded.get());
    Ok(())
}
