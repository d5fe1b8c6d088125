//! A virtual sensor, a Wait with a time-out, and a motion that a sensor ends.
//!
//! `cargo run -p mrroc-examples --example 02_wait`

use std::time::Duration;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};

/// The kind of sensor: a light barrier across the arm's way.
struct LightBarrier;

impl Sensor for LightBarrier {
    const KIND: &'static str = "light barrier";
    type Reading = Beam;
    type Configuration = ();
}

/// What it says.
#[derive(Clone, Copy, Payload)]
struct Beam {
    broken: bool,
}

/// A simulated one: the arm breaks the beam when its column is turned by more than 0.3 rad.
struct Simulated;

impl VirtualSensor for Simulated {
    type Kind = LightBarrier;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Beam, Fault> {
        // The state of the robot that the sensor belongs to comes with every order (eq. 14 of the paper).
        let arm = order.robot.ok_or_else(|| Fault::thrown("the barrier belongs to no arm"))?;
        Ok(Beam { broken: arm.joints[0] > 0.3 })
    }
}

/// Turns the column at 0.2 rad/s until the beam breaks; the runtime brakes the arm then.
#[derive(Debug)]
struct Sweep {
    q: Six,
    speed: f64,
}

#[generator(ecp, first = begin, until = beam_broken, sensors = (LightBarrier,))]
fn sweep(c: &mut Sweep, t: Tick) -> Step<Irp6> {
    c.speed = (c.speed + 0.5 * t.dt).min(0.2);
    c.q[0] += c.speed * t.dt;
    Step::Next(Demand::joints(c.q))
}

fn begin(c: &mut Sweep, e: &State<Irp6>, t: Tick) -> Step<Irp6> {
    c.q = e.demanded().joints;
    sweep(c, t)
}

/// The terminal condition of the motion, and the initial condition of the Wait below.
fn beam_broken(v: &Reading<(LightBarrier,)>) -> bool {
    v.0.reading().is_some_and(|beam| beam.broken)
}

#[condition(ecp)]
fn interrupted(v: &Reading<(LightBarrier,)>) -> bool {
    beam_broken(v)
}

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault.
pub fn main() -> Result<(), CellError> {
    let start = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    let arm = SimulatedIrp6::new(Irp6::nominal(), &start);
    let irp6 = RobotSetup::new("irp6", Irp6::nominal(), arm).program(|ecp| {
        let mut barrier = ecp.sensor::<LightBarrier>("barrier")?;
        // Nobody is in the beam yet: the Wait times out, which a program may handle.
        let early = ecp.wait_at_most((&mut barrier,), interrupted {}, 100).map(drop);
        assert_eq!(early.map_err(|fault| fault.kind()), Err(FaultKind::TimedOut));
        ecp.move_robot((&mut barrier,), Sweep { q: Six::zeros(), speed: 0.0 })?;
        let reached = ecp.image().demanded().joints[0];
        println!("stopped at {reached:.4} rad");
        // 0.3 rad, two steps until the reading acts, braking from 0.2 rad/s at 7 rad/s², and the arm's lag.
        assert!((0.3..0.31).contains(&reached));
        ecp.wait_until((&mut barrier,), interrupted {})?;
        Ok(())
    });
    Cell::new(Duration::from_millis(2))
        .robot(irp6)
        .sensor(SensorSetup::new("barrier", Simulated).of("irp6"))
        .run()?;
    Ok(())
}
