//! Two arms carry a plate over a box: they hold it rigidly, on a motion that is planned.
//!
//! `cargo run -p mrroc-examples --example 03_carry_a_plate`

use std::cell::RefCell;
use std::error::Error;
use std::f64::consts::PI;
use std::rc::Rc;
use std::time::Duration;

use mrroc::observe::ServoRecord;
use mrroc_planning::goals_at;
use mrroc_robots::clearance::{Capsule, ClearanceError};
use mrroc_robots::{SerialOutline, Simulated, Six};

// ANCHOR: program
use mrroc::prelude::*;
use mrroc_generators::cooperation::BodyFrame;
use mrroc_generators::generators::RigidCarry;
use mrroc_planning::{HereAll, Holders, Planner};
use mrroc_robots::Serial;
use mrroc_robots::clearance::{Clearance, Obstacle, Stopping};
use nalgebra::Vector3;

/// The plate is brought to a pose of its middle: both arms hold it all the time.
fn bring(mp: &mut Mp, arms: &[Serial<6>; 2], mut planner: Planner, to: &Pose) -> Result<(), Fault> {
    let mut left = mp.robot::<Serial<6>>("left")?;
    let mut right = mp.robot::<Serial<6>>("right")?;
    let here = mp.wait_until((&mut left, &mut right), (), HereAll::<(Serial<6>, Serial<6>)>::default())?;
    let holders = Holders::new().and("left", &arms[0]).and("right", &arms[1]);
    let carried = planner.carry(&holders, BodyFrame::Centroid, &here.joints(), to)?;
    let carry = RigidCarry::along(BodyFrame::Centroid, carried.path());
    mp.move_robots((&mut left, &mut right), (), carry).map(drop)
}
// ANCHOR_END: program

/// Half of the distance between the arms' bases, and between the flanges \[m\].
const HALF: [f64; 2] = [0.35, 0.25];
/// Where the middle of the plate begins, behind the box \[m\].
pub const FROM: [f64; 3] = [-0.3, 0.0, 0.3];
/// Where it ends, before the box \[m\].
pub const TO: [f64; 3] = [-0.6, 0.0, 0.3];

/// The arms, side by side, and where they hold the plate at the start [rad].
///
/// # Errors
/// What is wrong with the URDF, or a place out of reach.
pub fn arms() -> Result<([Serial<6>; 2], Vec<f64>), Box<dyn Error>> {
    let urdf = include_str!("../../template/sets/ur5e/ur5e.urdf");
    let arm = Serial::<6>::from_urdf(urdf, "base", "tool0")?.with_acceleration(Six::repeat(8.0))?;
    let arms = [-1.0, 1.0].map(|side| arm.clone().with_base(Pose::translation(0.0, side * HALF[0], 0.0)));
    let mut start = Vec::new();
    for (arm, side) in arms.iter().zip([-1.0, 1.0]) {
        let down = Pose::new(Vector3::new(FROM[0], side * HALF[1], FROM[2]), Vector3::x() * PI);
        let near = [0.0, -1.6, 2.0, -2.0, -1.57, 0.0];
        start.extend(goals_at(arm, &down, &near).into_iter().next().ok_or("out of reach")?);
    }
    Ok((arms, start))
}

/// A table with a box between the two places; the left arm has grasped the plate, which the right one holds too.
pub fn world(arms: &[Serial<6>; 2], step: Duration) -> Result<Clearance, ClearanceError> {
    let half = Vector3::new(0.05, 0.1, 0.2);
    let mut builder = Clearance::with_margin(0.02)
        .obstacle("box", Obstacle::Box { X_WO: Pose::translation(-0.45, 0.0, 0.1), half })?
        .obstacle("table", Obstacle::table(-0.1))?
        .will_grasp("left", "plate");
    for (name, arm) in ["left", "right"].iter().zip(arms) {
        builder = builder
            .robot(name, SerialOutline::new(arm.clone(), 0.05))?
            .ignore((name, "link 0"), ("table", "table"))
            .ignore((name, "link 5"), ("left", "plate"))
            .ignore((name, "link 6"), ("left", "plate"));
    }
    let mut clearance = builder.build(Stopping::of_guard(step, 1))?;
    // Two bars along the plate, in the frame of the left flange, whose z axis points down.
    let bar = |x: f64| {
        let from = Vector3::new(x, 0.0, 0.08);
        Capsule::new(from, from - Vector3::y() * 2.0 * HALF[1], 0.02)
    };
    clearance.grasp("left", "plate", &[bar(-0.05), bar(0.05)])?;
    Ok(clearance)
}

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault.
pub fn main() -> Result<(), Box<dyn Error>> {
    let step = Duration::from_millis(2);
    let (arms, start) = arms()?;
    let planner = Planner::new(world(&arms, step)?)?;
    let flanges: [Rc<RefCell<Vec<Pose>>>; 2] = Default::default();
    let mut cell = Cell::new(step);
    for (i, name) in ["left", "right"].into_iter().enumerate() {
        let (arm, seen) = (arms[i].clone(), Rc::clone(&flanges[i]));
        let drives = Simulated::new(arm.clone(), &Six::from_column_slice(&start[6 * i..6 * i + 6]));
        let set_up = RobotSetup::new(name, arm.clone(), drives);
        cell = cell.robot(set_up.observe(move |record: &ServoRecord<Serial<6>>| {
            seen.borrow_mut().push(arm.forward(&record.demanded));
        }));
    }
    let to = Pose::translation(TO[0], TO[1], TO[2]);
    cell.program(move |mp| bring(mp, &arms, planner.clone(), &to)).run()?;

    let [left, right] = flanges.map(|flange| flange.take());
    let held = left[0].inv_mul(&right[0]);
    let off = left.iter().zip(&right).map(|(left, right)| held.inv_mul(&left.inv_mul(right)));
    let farthest = off.map(|off| off.translation.vector.norm().max(off.rotation.angle())).fold(0.0, f64::max);
    println!("one flange moves against the other by at most {farthest:.1e} m and rad");
    assert!(farthest < 1e-9, "{farthest}");
    let ends = (left[left.len() - 1].translation.vector + right[right.len() - 1].translation.vector) / 2.0;
    assert!((ends - to.translation.vector).norm() < 1e-9, "{ends}");
    Ok(())
}
