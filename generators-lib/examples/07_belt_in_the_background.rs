//! A belt runs in the background while an arm moves there and back; then it runs slower, and at the end it stops.
//!
//! `cargo run -p mrroc-examples --example 07_belt_in_the_background`

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::observe::ServoRecord;
use mrroc::prelude::*;
use mrroc_generators::generators::{JointMove, JointVelocity};
use mrroc_robots::{Conveyor, Irp6, One, Simulated, SimulatedIrp6, Six};

/// Time between two servo periods of the simulated drives \[s\].
pub const PERIOD: f64 = 0.002;

/// The position of the belt \[m\] and the first joint of the arm [rad] as demanded, in every servo period.
pub fn positions() -> Result<[Vec<f64>; 2], CellError> {
    let rest = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    let seen: [Rc<RefCell<Vec<f64>>>; 2] = Default::default();
    let [of_belt, of_arm] = seen.each_ref().map(Rc::clone);
    let arm = RobotSetup::new("arm", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &rest))
        .observe(move |record: &ServoRecord<Irp6>| of_arm.borrow_mut().push(record.demanded[0]));
    let drives = Simulated::new(Conveyor::new(), &One::new(0.0));
    let belt = RobotSetup::new("belt", Conveyor::new(), drives)
        .stop_time(Duration::from_secs(5))
        .observe(move |record: &ServoRecord<Conveyor>| of_belt.borrow_mut().push(record.demanded[0]));
    Cell::new(Duration::from_secs_f64(PERIOD))
        .robot(arm)
        .robot(belt)
        .program(move |mp| {
            let (mut arm, mut belt) = (mp.robot::<Irp6>("arm")?, mp.robot::<Conveyor>("belt")?);
            let run = |speed: f64| JointVelocity::of(One::new(speed), One::new(0.04));
            let to = |by: f64| JointMove::to(rest + Six::x() * by, Six::repeat(0.4), Six::repeat(0.8));
            mp.start_robot(&mut belt, run(0.04))?;
            mp.move_robot(&mut arm, (), to(0.4))?;
            mp.start_robot(&mut belt, run(0.02))?;
            mp.move_robot(&mut arm, (), to(0.0))?;
            mp.end_robot(&mut belt)
        })
        .run()?;
    Ok(seen.map(|positions| positions.take()))
}

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault.
pub fn main() -> Result<(), CellError> {
    let [belt, arm] = positions()?;
    let speed = |i: usize| (belt[i + 1] - belt[i]) / PERIOD;
    // Each Move of the arm takes 0.4 / 0.4 + 0.4 / 0.8 = 1.5 s; the belt's velocity changes in 1 s, and in 0.5 s.
    let both = belt.iter().zip(&arm).map(|(belt, arm)| (*belt, *arm));
    let moving: Vec<(f64, f64)> = both.skip_while(|(belt, _)| *belt == 0.0).collect();
    assert!((moving[749].1 - 0.4).abs() < 0.01, "{:?}", moving[749]);
    assert!((moving[749].0 - (0.02 + 0.02)).abs() < 0.001, "{:?}", moving[749]);
    let fastest = (0..belt.len() - 1).map(speed).fold(0.0, f64::max);
    assert!((fastest - 0.04).abs() < 1e-9);
    let slower = (0..belt.len() - 1).filter(|&i| (speed(i) - 0.02).abs() < 1e-9).count();
    println!("the belt ran by {:.3} m, {slower} periods of it at 0.02 m/s", belt[belt.len() - 1]);
    assert!((490..510).contains(&slower));
    Ok(())
}
