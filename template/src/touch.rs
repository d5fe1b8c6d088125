//! A virtual sensor: does the tool touch the table?

use mrroc::prelude::*;

/// Height of the simulated table [m, world].
pub const TABLE: f64 = 0.05;

/// The kind of sensor.
pub struct Touch;

impl Sensor for Touch {
    const KIND: &'static str = "touch";
    type Reading = Contact;
    type Configuration = ();
}

/// FILL IN: what the sensor tells.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Contact {
    pub made: bool,
}

/// FILL IN: what a Wait waits for; here, a tool that touches nothing.{% if levels != "ecp" %}
#[condition(mp)]
pub fn clear(v: &Reading<(Touch,)>) -> bool {
    v.0.reading().is_some_and(|contact| !contact.made)
}

// {% else %}
#[condition(ecp)]
pub fn open(v: &Reading<(Touch,)>) -> bool {
    v.0.reading().is_some_and(|contact| !contact.made)
}

// {% endif %}The sensor itself, simulated until there is a real one.

/// A table below the tool.
pub struct Table;

impl VirtualSensor for Table {
    type Kind = Touch;

    /// FILL IN: read the hardware, and make one reading of all that it gives.
    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Contact, Fault> {
        let robot = order.robot.ok_or_else(|| {
            Fault::thrown("the sensor belongs to no robot: write `of` in its table of cell.toml")
        })?;
        Ok(Contact { made: robot.pose.translation.z <= TABLE })
    }
}
