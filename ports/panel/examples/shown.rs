//! What the panel shows beside arms: a bar that an arm holds, the wrench at its wrist, a lamp and a switch, and the shapes of a URDF's
//! links: `cargo run --release -p mrroc-examples --example shown --features panel -- --cell ports/panel/examples/shown/cell.toml
//! --processes --panel`.
//!
//! `--turns` behind a `--` says how often they go, a thousand times by default.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::launch::own_number;
use mrroc::nalgebra::Vector3;
use mrroc::prelude::*;
use mrroc::sensor::VspMode;
use mrroc_generators::generators::{JointMove, Tell};
use mrroc_robots::grasp::{Body, Grasp, Hand, SimulatedWrist, World};
use mrroc_robots::sensors::WristForce;
use mrroc_robots::{Irp6, Serial, Simulated, Six, simulated};

/// What the arm holds \[kg\], and its edges \[m\].
const BAR: (f64, [f64; 3]) = (2.0, [0.06, 0.5, 0.06]);

/// The sensor at its wrist runs by itself, whether a program reads it or not.
const FREE: VspMode = VspMode::NonInteractive(Duration::from_millis(10));

/// The stiffness of its grasp [N/m, N m/rad].
const GRASP: [f64; 2] = [2e4, 200.0];

fn main() -> std::process::ExitCode {
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let held = Rc::<RefCell<Option<(World, Hand)>>>::default();
    let holds = Rc::clone(&held);
    let kinds = simulated().with("holder", move |entry| {
        let robot = Irp6::nominal().with_base(entry.base());
        let start: Six = entry.start(&robot)?;
        let at = robot.forward(&start) * entry.tool();
        let (mass, edges) = BAR;
        let refused =
            |why: &dyn core::fmt::Display| entry.refuse_start(why.to_string(), "mend the example".to_owned());
        let world = World::new(&Body::block(mass, edges).at(at)).map_err(|why| refused(&why))?;
        let [stiffness, rotational] = GRASP;
        let grasp = Grasp::new(stiffness, rotational).with_tool(entry.tool());
        let arm = world.arm(Simulated::new(robot.clone(), &start), grasp).map_err(|why| refused(&why))?;
        // It holds the bar from the beginning.
        arm.hand().close().map_err(|why| refused(&why))?;
        *holds.borrow_mut() = Some((world, arm.hand()));
        Ok(RobotSetup::new(entry.name(), robot, arm))
    });
    let cell = file.cell(&kinds)?;
    let Some((world, hand)) = held.take() else { return Ok(cell) };
    Ok(cell
        .shows_body("bar", BAR.1, move || world.body().pose)
        .sensor(
            SensorSetup::new("wrist", SimulatedWrist::new(hand)).of("holder").readers(["holder"]).mode(FREE),
        )
        .program(carry))
}

/// The bar has hung still for so many steps: the arm stands, and the force has changed by less than a newton.
struct Still {
    steps: u32,
    last: f64,
}

#[condition(mp)]
fn still(c: &mut Still, e: &State<(Irp6,)>, v: &Reading<(WristForce,)>) -> bool {
    let force = v.0.reading().map_or(f64::INFINITY, |reading| reading.force.norm());
    let is_same = e.0.measured().velocity.amax() < 0.02 && (force - c.last).abs() < 1.0;
    (c.steps, c.last) = (if is_same { c.steps + 1 } else { 0 }, force);
    c.steps >= 250
}

fn carry(mp: &mut Mp) -> Result<(), Fault> {
    let turns = own_number("turns", 1000_u32)?;
    let (mut holder, mut shown) = (mp.robot::<Irp6>("holder")?, mp.robot::<Serial<3>>("shown")?);
    let mut wrist = mp.sensor::<WristForce>("wrist")?;
    let lamp = holder.output::<bool>("lamp")?;
    let to = |column: f64, arm: f64| {
        let q = Six::new(column, -1.57 + arm, 0.16 - 0.5 * arm, -0.16, 4.71, 0.8 * column);
        JointMove::<Irp6>::to(q, Six::repeat(0.3), Six::repeat(0.6))
    };
    let swing = |turn: f64, shoulder: f64, elbow: f64| {
        let q = Vector3::new(turn, shoulder, elbow);
        JointMove::<Serial<3>>::to(q, Vector3::repeat(0.3), Vector3::repeat(0.6))
    };
    for _ in 0..turns {
        mp.move_robot(&mut holder, (), Tell::output(lamp, true))?;
        mp.move_robots((&mut holder, &mut shown), (), Each::of((to(0.4, 0.2), swing(0.6, 0.2, 1.2))))?;
        mp.wait_until((&mut holder,), (&mut wrist,), Still { steps: 0, last: f64::INFINITY })?;
        mp.move_robot(&mut holder, (), Tell::output(lamp, false))?;
        mp.move_robots((&mut holder, &mut shown), (), Each::of((to(-0.3, 0.0), swing(-0.5, 0.6, 0.4))))?;
    }
    Ok(())
}
