//! A Wait for a part that sits firmly behind a closed door, as seen by a switch that bounces, or for a time-out.
//!
//! `cargo run -p mrroc-examples --example 06_conditions`

use std::time::Duration;

use mrroc::prelude::*;
use mrroc_generators::conditions::{ConditionExt, all, any, elapsed, not};
use mrroc_robots::{Irp6, SimulatedIrp6, Six};

/// The kind of sensor: the inputs of a fixture.
pub struct Fixture;

impl Sensor for Fixture {
    const KIND: &'static str = "fixture";
    type Reading = Inputs;
    type Configuration = ();
}

/// What it says.
#[derive(Clone, Copy, Payload)]
pub struct Inputs {
    /// The switch below the part is closed.
    pub switch: bool,
    /// The door is open.
    pub door: bool,
}

/// A simulated one: milliseconds since the start.
pub struct Simulated(pub u64);

impl VirtualSensor for Simulated {
    type Kind = Fixture;

    fn aggregate(&mut self, _: &ReadingOrder<()>) -> Result<Inputs, Fault> {
        let now = self.0;
        self.0 += 2;
        // The switch closes at 300 ms and bounces until 338 ms; the door is open until 500 ms, and again from 700 ms on.
        let bounced = (310..318).contains(&now) || (332..338).contains(&now);
        Ok(Inputs { switch: now >= 300 && !bounced, door: !(500..700).contains(&now) })
    }
}

/// The switch below the part is closed.
#[condition(mp)]
pub fn seated(v: &Reading<(Fixture,)>) -> bool {
    v.0.reading().is_some_and(|inputs| inputs.switch)
}

/// The door is not shut, or nothing is known of it.
#[condition(mp)]
pub fn door_open(v: &Reading<(Fixture,)>) -> bool {
    v.0.reading().is_none_or(|inputs| inputs.door)
}

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault.
pub fn main() -> Result<(), CellError> {
    let start = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    let arm = SimulatedIrp6::new(Irp6::nominal(), &start);
    Cell::new(Duration::from_millis(2))
        .robot(RobotSetup::new("irp6", Irp6::nominal(), arm))
        .sensor(SensorSetup::new("fixture", Simulated(0)))
        .program(|mp| {
            let mut fixture = mp.sensor::<Fixture>("fixture")?;
            let begun = mp.step() + 1;
            let ready = all((seated {}.held_for(0.1), not(door_open {})));
            mp.wait_until((), (&mut fixture,), any((ready, elapsed(0.8))))?;
            let waited = 2 * (mp.step() - begun);
            println!("ready after {waited} ms");
            // It sits firmly from 338 + 100 ms on, and the door is shut at 500 ms.
            assert_eq!(waited, 500);
            Ok(())
        })
        .run()
        .map(drop)
}
