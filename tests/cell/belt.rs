//! A belt in the background of an arm's Moves: started, changed, waited for, taken over by a Move, started again. The arm
//! switches a vacuum meanwhile, and waits for its switch.

use std::time::Duration;

use mrroc::cell::{InputSetup, OutputSetup};
use mrroc::prelude::*;
use mrroc::robot::{Channel, Input};
use mrroc_generators::generators::{JointMove, JointVelocity, Tell};
use mrroc_robots::{Conveyor, Irp6, One, Simulated, SimulatedIrp6, Six};

/// The cell.
pub fn cell() -> Cell {
    let rest = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    let arm = RobotSetup::new("arm", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &rest));
    let arm = arm
        .output(OutputSetup::new("vacuum", Channel::Digital(0)).holds_body())
        .input(InputSetup::new("sucked", Channel::Digital(1)).follows("vacuum", Duration::from_millis(30)));
    let drives = Simulated::new(Conveyor::new(), &One::new(0.0));
    let belt = RobotSetup::new("belt", Conveyor::new(), drives).stop_time(Duration::from_secs(5));
    Cell::new(Duration::from_millis(2)).robot(arm).robot(belt).program(move |mp| {
        let (mut arm, mut belt) = (mp.robot::<Irp6>("arm")?, mp.robot::<Conveyor>("belt")?);
        let run = |speed: f64| JointVelocity::of(One::new(speed), One::new(0.04));
        let to = |by: f64| JointMove::to(rest + Six::x() * by, Six::repeat(0.4), Six::repeat(0.8));
        let (vacuum, sucked) = (arm.output("vacuum")?, arm.input("sucked")?);
        mp.start_robot(&mut belt, run(0.04))?;
        mp.move_robot(&mut arm, (), to(0.4))?;
        mp.move_robot(&mut arm, (), Tell::output(vacuum, true))?;
        mp.wait_until((&mut arm,), (), Sucked(sucked))?;
        mp.start_robot(&mut belt, run(0.02))?;
        mp.wait_until((&mut belt,), (), Beyond(0.07))?;
        mp.move_robots((&mut arm, &mut belt), (), Each::of((to(0.0), run(0.0))))?;
        mp.start_robot(&mut belt, run(-0.04))?;
        mp.move_robot(&mut arm, (), to(0.2))?;
        mp.end_robot(&mut belt)
    })
}

struct Sucked(Input<bool>);

#[condition(mp)]
fn has_sucked(c: &mut Sucked, e: &State<(Irp6,)>) -> bool {
    e.0.value(c.0)
}

struct Beyond(f64);

#[condition(mp)]
fn beyond(c: &mut Beyond, e: &State<(Conveyor,)>) -> bool {
    e.0.demanded().joints[0] > c.0
}
