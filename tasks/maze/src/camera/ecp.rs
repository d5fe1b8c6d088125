//! The arm's program: over the walls to where the path begins, and then along it, step by step. A touch is a fault.

use mrroc::prelude::*;
use mrroc_generators::generators::StraightLine;
use mrroc_robots::Irp6;

use super::orders::{Along, Errand};
use crate::places::{HIGH, LOW, MIDDLE, Sizes, free, tool};
use crate::plant::TouchProbe;

/// Demands what the coordinator orders, for as long as nothing is touched.
#[generator(ecp)]
fn follow(order: &Order<Along>, v: &Reading<(TouchProbe,)>) -> Result<Step<Irp6>, Fault> {
    if v.0.reading().is_some_and(|touch| touch.touching) {
        return Err(Fault::thrown(
            "the ball touches a wall on a path that the camera said is free: look whether the camera or the maze was moved",
        ));
    }
    let Along { x, y } = order.value();
    Ok(Step::Next(Demand::pose(tool(x, y, LOW))))
}

/// The arm.
///
/// # Errors
/// The first fault of the cell; a wall is touched.
pub fn arm(ecp: &mut Ecp<Irp6>, sizes: &Sizes) -> Result<(), Fault> {
    let mut probe = ecp.sensor::<TouchProbe>("probe")?;
    ecp.serve(|ecp, Errand::Hop { x, y }| {
        let here = ecp.image().demanded().pose.translation.vector;
        let high = tool(here.x, here.y, HIGH.max(here.z - MIDDLE[2]));
        ecp.move_robot((), StraightLine::to(high, free()))?;
        ecp.move_robot((), StraightLine::to(tool(x, y, HIGH), free()))?;
        ecp.move_robot((), StraightLine::to(tool(x, y, LOW), sizes.careful())).map(drop)
    })?;
    ecp.serve(|ecp, _: Along| ecp.move_robot((&mut probe,), follow {}).map(drop))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feeling::Touch;
    use mrroc::sensor::SensorImage;

    #[test]
    fn what_is_ordered_is_demanded_until_something_is_touched() {
        let order = Order::new(Along { x: 0.8, y: 0.1 });
        let at = |touching| Reading::new((SensorImage::new(Touch { touching, ..Touch::default() }, 0),));
        let step = follow(&order, &at(false)).expect("free");
        assert_eq!(step, Step::Next(Demand::pose(tool(0.8, 0.1, LOW))));
        assert!(follow(&order, &at(true)).expect_err("touched").message().contains("touches a wall"));
    }
}
