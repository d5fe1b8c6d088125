//! Two arms that go to and fro, shown to others at the port `arms`. The tool of the left one is weighed at each turn.

use mrroc::launch::own_number;
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc_external::Subscribers;
use mrroc_generators::generators::{JointMove, Tell};
use mrroc_robots::sensors::{WristForce, WristOrder};
use mrroc_robots::{Irp6, Six, simulated};
use nalgebra::Vector3;

/// A simulated sensor at the wrist of the left arm: it feels the weight of a tool of 1 kg.
struct Wrist;

impl VirtualSensor for Wrist {
    type Kind = WristForce;

    fn aggregate(&mut self, order: &ReadingOrder<WristOrder>) -> Result<Wrench, Fault> {
        let turned = order.robot.map_or_else(Pose::identity, |robot| robot.pose).rotation;
        Ok(Wrench::new(turned.inverse() * Vector3::new(0.0, 0.0, -9.81), Vector3::zeros()))
    }
}

/// So many readings of the wrist.
struct Weigh(u32);

#[condition(mp)]
fn weigh(c: &mut Weigh, _: &Reading<(WristForce,)>) -> bool {
    c.0 -= 1;
    c.0 == 0
}

// ANCHOR: cell
/// Makes the cell of `cell.toml`.
///
/// # Errors
/// What is wrong in the file.
pub fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let wrist = SensorSetup::new("wrist", Wrist).of("left");
    Ok(file.cell(&simulated())?.sensor(wrist).program(to_and_fro).shown_to(Subscribers::at("arms")))
}
// ANCHOR_END: cell

fn to_and_fro(mp: &mut Mp) -> Result<(), Fault> {
    let turns = own_number("turns", 1000_u32)?;
    let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
    let to = |column: f64, arm: f64| {
        let mut q = Six::new(column, -1.57 + arm, 0.16 - 0.5 * arm, -0.16, 4.71, 0.8 * column);
        q[3] += 0.3 * arm;
        JointMove::<Irp6>::to(q, Six::repeat(0.4), Six::repeat(0.8))
    };
    let mut wrist = mp.sensor::<WristForce>("wrist")?;
    let gripper = left.output::<bool>("gripper")?;
    for turn in 0..turns {
        mp.move_robot(&mut left, (), Tell::output(gripper, turn % 2 == 1))?;
        mp.wait_until((&mut left,), (&mut wrist,), Weigh(100))?;
        mp.move_robots((&mut left, &mut right), (), Each::of((to(0.5, 0.3), to(-0.3, 0.2))))?;
        mp.move_robots((&mut left, &mut right), (), Each::of((to(-0.4, -0.1), to(0.4, 0.3))))?;
    }
    Ok(())
}
