//! The arm's program with a force sensor: what it does in each task. It knows no maze.

use mrroc::prelude::*;
use mrroc_generators::generators::StraightLine;
use mrroc_robots::Irp6;
use nalgebra::Vector2;

use super::sensor::{Going, THRESHOLD, WallForce};
use super::slide::Slide;
use crate::ecp::hop;
use crate::generators::Leg;
use crate::orders::Task;
use crate::places::{LOW, Sizes, tool};

/// It goes off what it touches so many times at most: a light force, as that of friction where a wall ends, may push it to another wall.
const RETREATS: usize = 4;

/// The sensor's bias is known.
#[condition(ecp)]
fn is_zeroed(v: &Reading<(WallForce,)>) -> bool {
    v.0.reading().is_some_and(|felt| felt.is_zeroed)
}

/// The arm: straight to where it is told until it touches, along the wall that it touches, and off it; or over the walls.
///
/// # Errors
/// The first fault of the cell.
pub fn arm(ecp: &mut Ecp<Irp6>, sizes: &Sizes) -> Result<(), Fault> {
    let mut wrist = ecp.sensor::<WallForce>("force")?;
    let mut legs = 0;
    ecp.serve_all(|ecp, task| {
        ecp.wait_until((&mut wrist,), is_zeroed {})?;
        let (x, y) = match task {
            Task::Go { x, y } => (x, y),
            Task::Hop { x, y } => return hop(ecp, [x, y], sizes),
            Task::Leave { .. } => return Err(Fault::thrown("an arm with a force sensor is led by a map")),
        };
        legs += 1;
        wrist.configure(Going { leg: legs });
        let leg = ecp.move_robot((&mut wrist,), Leg::to(tool(x, y, LOW), sizes.careful()))?;
        if !leg.has_touched() {
            return Ok(());
        }
        ecp.wait_until((&mut wrist,), is_zeroed {})?;
        let felt = wrist.reading().unwrap_or_default();
        if let Some(slide) = Slide::towards(Vector2::new(x, y), &felt, sizes)? {
            ecp.move_robot((&mut wrist,), slide)?;
            ecp.wait_until((&mut wrist,), is_zeroed {})?;
        }
        // Off what it still touches, in the direction in which that pushes; once more where that was towards another wall.
        for _ in 0..RETREATS {
            let felt = wrist.reading().unwrap_or_default();
            if felt.force().norm() < 0.5 * THRESHOLD {
                break;
            }
            let clear = felt.ball() + felt.force().normalize() * sizes.back;
            ecp.move_robot((), StraightLine::to(tool(clear.x, clear.y, LOW), sizes.careful()))?;
            ecp.wait_until((&mut wrist,), is_zeroed {})?;
        }
        Ok(())
    })
}
