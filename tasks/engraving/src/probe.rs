//! The touch probe: a virtual sensor that tells when the tool's tip touches the plate, and where.

use mrroc::prelude::*;
use mrroc_robots::{Irp6, Shaft};

/// The kind of sensor: the circuit between the tool's tip and the plate.
pub struct TouchProbe;

impl Sensor for TouchProbe {
    const KIND: &'static str = "touch probe";
    type Reading = Touch;
    type Configuration = ();
}

/// What the probe says.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Touch {
    /// The tip touches the plate.
    pub contact: bool,
    /// Height at which the encoders saw the tip when it first touched [m, world]; 0 before.
    pub height: f64,
}

/// A plate under a simulated arm: closes the probe's circuit when the arm's true tip is at its surface.
pub struct PlateSurface {
    arm: Irp6,
    tool: Pose,
    shaft: Shaft,
    surface: f64,
    touched: Option<f64>,
}

impl PlateSurface {
    /// A plate whose surface lies at the height `surface` [m, world] under the arm with this tool, `X_FE`.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn new(arm: Irp6, X_FE: Pose, shaft: Shaft, surface: f64) -> Self {
        PlateSurface { arm, tool: X_FE, shaft, surface, touched: None }
    }
}

impl VirtualSensor for PlateSurface {
    type Kind = TouchProbe;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Touch, Fault> {
        let tip = self.arm.forward(&self.shaft.state().position) * self.tool;
        let contact = tip.translation.z <= self.surface;
        let seen = order.robot.ok_or_else(|| Fault::thrown("the touch probe got no state of its arm"))?;
        self.touched = if contact { Some(self.touched.unwrap_or(seen.pose.translation.z)) } else { None };
        Ok(Touch { contact, height: self.touched.unwrap_or(0.0) })
    }

    fn is_simulated(&self) -> bool {
        true
    }
}

/// The circuit has been open for so many steps: the probe is fit to be used.
pub struct Open {
    steps: u32,
    seen: u32,
}

impl Open {
    /// For `steps` steps in a row.
    #[must_use]
    pub fn for_steps(steps: u32) -> Self {
        Open { steps, seen: 0 }
    }
}

#[condition(ecp)]
fn open(c: &mut Open, v: &Reading<(TouchProbe,)>) -> bool {
    match v.0.reading() {
        Some(touch) if !touch.contact => c.seen += 1,
        _ => c.seen = 0,
    }
    c.seen >= c.steps
}
