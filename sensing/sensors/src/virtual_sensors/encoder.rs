//! The encoder of a belt: how far it has run.

use mrroc::prelude::*;

/// The kind of sensor: how far a belt has run. Its table in `cell.toml` says `of`, the belt.
#[derive(Clone, Copy, Debug)]
pub struct Encoder;

impl Sensor for Encoder {
    const KIND: &'static str = "encoder";
    type Reading = Run;
    type Configuration = ();
}

/// How far a belt has run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Run {
    /// \[m\].
    pub travel: f64,
    /// [m/s].
    pub speed: f64,
}

impl VirtualSensor for Encoder {
    type Kind = Encoder;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Run, Fault> {
        let belt = order.robot.ok_or_else(|| {
            Fault::thrown("an encoder is that of a robot: write of = \"BELT\" in its table of cell.toml")
        })?;
        Ok(Run { travel: belt.joints[0], speed: belt.velocity[0] })
    }
}
