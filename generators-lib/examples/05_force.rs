//! The tool of an arm goes down to a table that it does not know, and presses on it with 10 N.
//!
//! `cargo run -p mrroc-examples --example 05_force`

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::observe::ServoRecord;
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc_generators::force::{Behaviour, Bound, ForceControl, Give};
use mrroc_generators::generators::ForceLaw;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};
use nalgebra::Vector3;

/// Time between two servo periods of the simulated drives \[s\].
pub const PERIOD: f64 = 0.002;
/// How hard the tool is to press \[N\].
pub const LOAD: f64 = 10.0;
/// How far the table is below the tool at the start \[m\].
pub const GAP: f64 = 0.005;
/// How stiff the table is [N/m].
pub const STIFFNESS: f64 = 2000.0;
/// How fast the tool may look for the table, and how far [m/s], [m].
const WITHIN: Bound = Bound { speed: 0.1, travel: 0.05 };

/// A force sensor at the wrist.
struct Wrist;

impl Sensor for Wrist {
    const KIND: &'static str = "wrist";
    type Reading = Wrench;
    type Configuration = ();
}

/// What it feels of a table whose surface is at this height \[m\].
struct Table(f64);

impl VirtualSensor for Table {
    type Kind = Wrist;
    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Wrench, Fault> {
        let tool = order.robot.ok_or_else(|| Fault::thrown("the sensor is on no robot"))?;
        let up = Vector3::z() * STIFFNESS * (self.0 - tool.pose.translation.z).max(0.0);
        Ok(Wrench::new(tool.pose.rotation.inverse_transform_vector(&up), Vector3::zeros()))
    }
}

/// How far the tool, as measured, is below where it started, in every servo period \[m\].
pub fn depths() -> Result<Vec<f64>, CellError> {
    let irp6 = Irp6::nominal();
    let joints = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    let start = irp6.forward(&joints).translation.z;
    let recorded = Rc::new(RefCell::new(Vec::new()));
    let recorder = Rc::clone(&recorded);
    let robot = RobotSetup::new("irp6", irp6.clone(), SimulatedIrp6::new(irp6.clone(), &joints))
        .observe(move |record: &ServoRecord<Irp6>| {
            recorder.borrow_mut().push(start - irp6.forward(&record.measured.position).translation.z);
        })
        .program(|ecp| {
            let mut wrist = ecp.sensor::<Wrist>("wrist")?;
            // Along its z axis, which points down, the tool is to press; in all other directions it stays.
            let mut axes = [Behaviour::Unguarded { velocity: 0.0 }; 6];
            axes[2] = Behaviour::Contact { load: LOAD, give: Give::FORCE, within: WITHIN };
            let law = ForceControl::new(axes).map_err(|bad| Fault::thrown(&bad.to_string()))?;
            ecp.move_robot((&mut wrist,), ForceLaw::lasting(law, 4.0, 1)).map(drop)
        });
    let wrist = SensorSetup::new("wrist", Table(start - GAP)).of("irp6");
    Cell::new(Duration::from_secs_f64(PERIOD)).robot(robot).sensor(wrist).run()?;
    Ok(recorded.take())
}

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault.
pub fn main() -> Result<(), CellError> {
    let depths = depths()?;
    let force = |depth: &f64| STIFFNESS * (depth - GAP).max(0.0);
    let end = depths.last().map_or(0.0, force);
    println!("the tool presses with {end:.2} N");
    // An encoder count is about 10 um, which is 0.02 N.
    assert!((end - LOAD).abs() < 0.2);
    Ok(())
}
