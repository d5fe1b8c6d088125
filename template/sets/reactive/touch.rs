//! A virtual sensor: how near is what is in the way, and on which side?

use mrroc::prelude::*;
use nalgebra::Vector2;

/// The simulated post: its middle and its radius [m, world].
pub const POST: [f64; 3] = [0.87, 0.11, 0.05];

/// The kind of sensor.
pub struct Touch;

impl Sensor for Touch {
    const KIND: &'static str = "touch";
    type Reading = Near;
    type Configuration = ();
}

/// FILL IN: what the sensor tells.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Near {
    /// How far the tool is from it [m].
    pub gap: f64,
    /// The direction from it to the tool, of length 1 [world].
    pub away: [f64; 2],
}

/// FILL IN: when a behaviour begins that goes by what is near ..
pub fn near(v: &Reading<(Touch,)>) -> bool {
    v.0.reading().is_some_and(|near| near.gap < 0.015)
}

/// .. and when it ends: later, so that noise does not hand the robot to and fro.
pub fn clear(v: &Reading<(Touch,)>) -> bool {
    v.0.reading().is_some_and(|near| near.gap > 0.025)
}

// The sensor itself, simulated until there is a real one.

/// A round post, felt by the tool.
pub struct Post;

impl VirtualSensor for Post {
    type Kind = Touch;

    /// FILL IN: read the hardware, and make one reading of all that it gives.
    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Near, Fault> {
        let robot = order.robot.ok_or_else(|| {
            Fault::thrown("the sensor belongs to no robot: write `of` in its table of cell.toml")
        })?;
        let offset = robot.pose.translation.vector.xy() - Vector2::new(POST[0], POST[1]);
        Ok(Near { gap: offset.norm() - POST[2], away: offset.normalize().into() })
    }
}
