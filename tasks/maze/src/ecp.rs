//! The arm's program: what it does in each task. It knows no maze.

use mrroc::generator::SensorHandle;
use mrroc::prelude::*;
use mrroc_generators::generators::StraightLine;
use mrroc_robots::Irp6;

use crate::generators::Leg;
use crate::orders::Task;
use crate::places::{HIGH, LOW, MIDDLE, Sizes, free, tool};
use crate::plant::TouchProbe;

/// The arm: straight to where it is told until it touches, and back; or over the walls.
///
/// # Errors
/// The first fault of the cell.
pub fn arm(ecp: &mut Ecp<Irp6>, sizes: &Sizes) -> Result<(), Fault> {
    let mut probe = ecp.sensor::<TouchProbe>("probe")?;
    ecp.serve_all(|ecp, task| match task {
        Task::Go { x, y } => go(ecp, &mut probe, [x, y], sizes),
        Task::Hop { x, y } => hop(ecp, [x, y], sizes),
        Task::Leave { .. } => {
            Err(Fault::thrown("this arm is led by a map: it cannot leave a maze by itself"))
        }
    })
}

/// Straight to a place until the probe touches; then back by a little.
pub(crate) fn go(
    ecp: &mut Ecp<Irp6>,
    probe: &mut SensorHandle<TouchProbe>,
    [x, y]: [f64; 2],
    sizes: &Sizes,
) -> Result<(), Fault> {
    let from = ecp.image().demanded().pose;
    let leg = ecp.move_robot((&mut *probe,), Leg::to(tool(x, y, LOW), sizes.careful()))?;
    if !leg.has_touched() {
        return Ok(());
    }
    // Back along the path by which it came, from where it touched.
    let touch = probe.reading().unwrap_or_default();
    let leg = tool(x, y, LOW).translation.vector - from.translation.vector;
    let back = leg.normalize() * sizes.back;
    let clear = tool(touch.x - back.x, touch.y - back.y, LOW);
    ecp.move_robot((), StraightLine::to(clear, sizes.careful())).map(drop)
}

/// Over the walls to a place, and down.
pub(crate) fn hop(ecp: &mut Ecp<Irp6>, [x, y]: [f64; 2], sizes: &Sizes) -> Result<(), Fault> {
    let here = ecp.image().demanded().pose.translation.vector;
    let high = tool(here.x, here.y, HIGH.max(here.z - MIDDLE[2]));
    ecp.move_robot((), StraightLine::to(high, free()))?;
    ecp.move_robot((), StraightLine::to(tool(x, y, HIGH), free()))?;
    ecp.move_robot((), StraightLine::to(tool(x, y, LOW), sizes.careful())).map(drop)
}
