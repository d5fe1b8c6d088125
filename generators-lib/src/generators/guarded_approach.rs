//! Moves the tool straight on until a sensor reports contact: a guarded motion.

use core::marker::PhantomData;

use mrroc::prelude::*;
use nalgebra::{Translation3, Unit, Vector3};

/// Moves the tool in one direction at a constant speed until a reading reports contact.
///
/// Ends in the step after the contact; the runtime brings the tool to a standstill. Throws a fault if there is no
/// contact within `travel`.
///
/// ```
/// use mrroc::{pose::Wrench, sensor::SensorImage};
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::GuardedApproach;
/// use mrroc_generators::rehearsal::rehearse_with;
/// use mrroc_robots::Irp6;
/// use nalgebra::Vector3;
///
/// # struct Wrist;
/// # impl Sensor for Wrist {
/// #     const KIND: &'static str = "wrist";
/// #     type Reading = Wrench;
/// #     type Configuration = ();
/// # }
/// // Down at 0.05 m/s, by 0.2 m at most, until the sensor feels more than 5 N.
/// let down = -Vector3::z_axis();
/// let approach = GuardedApproach::<Irp6, Wrist>::along(down, 0.05, 0.5, 0.2, |felt| felt.force.norm() > 5.0);
/// let irp6 = Irp6::nominal();
/// let table = irp6.forward(&Irp6::READY).translation.z - 0.02;
/// let demands = rehearse_with(approach, &irp6, Irp6::READY, 0.002, |arm| {
///     let touches = arm.measured().pose.translation.z < table;
///     let felt = Wrench::new(Vector3::z() * if touches { 10.0 } else { 0.0 }, Vector3::zeros());
///     (Order::new(()), Reading::new((SensorImage::new(felt, 0),)))
/// })?;
/// // It ends in the step after the one that touches: 0.1 mm a step.
/// let end = demands.last().and_then(Demand::as_pose);
/// assert!(end.is_some_and(|end| (table - 1.01e-4..table).contains(&end.translation.z)));
/// # Ok::<(), Fault>(())
/// ```
pub struct GuardedApproach<R, S: Sensor> {
    direction: Unit<Vector3<f64>>,
    speed: f64,
    acceleration: f64,
    travel: f64,
    contact: fn(&S::Reading) -> bool,
    start: Pose,
    travelled: f64,
    rate: f64,
    of: PhantomData<(R, S)>,
}

impl<R: Robot, S: Sensor> GuardedApproach<R, S> {
    /// Along `direction` in the world at `speed` [m/s], reached by `acceleration` [m/s²], for at most `travel`
    /// \[m\], until `contact` holds for a reading. All > 0.
    #[must_use]
    pub fn along(
        direction: Unit<Vector3<f64>>,
        speed: f64,
        acceleration: f64,
        travel: f64,
        contact: fn(&S::Reading) -> bool,
    ) -> Self {
        let start = Pose::identity();
        let travelled = 0.0;
        let rate = 0.0;
        GuardedApproach {
            direction,
            speed,
            acceleration,
            travel,
            contact,
            start,
            travelled,
            rate,
            of: PhantomData,
        }
    }

    fn advance(&mut self, v: &Reading<(S,)>, t: Tick) -> Result<Step<R>, Fault> {
        if v.0.reading().as_ref().is_some_and(self.contact) {
            return Ok(Step::Done);
        }
        self.rate = (self.rate + self.acceleration * t.dt).min(self.speed);
        self.travelled += self.rate * t.dt;
        if self.travelled > self.travel {
            return Err(Fault::thrown("no contact on the whole travel of a guarded approach"));
        }
        let moved = Translation3::from(self.direction.into_inner() * self.travelled);
        Ok(Step::Next(Demand::pose(moved * self.start)))
    }
}

#[generator(ecp)]
impl<R: Robot, S: Sensor> GuardedApproach<R, S> {
    fn first_step(&mut self, e: &State<R>, v: &Reading<(S,)>, t: Tick) -> Result<Step<R>, Fault> {
        if [self.speed, self.acceleration, self.travel].iter().any(|x| !(x.is_finite() && *x > 0.0)) {
            return Err(Fault::thrown(
                "speed, acceleration and travel of a guarded approach must be finite and > 0",
            ));
        }
        self.start = e.demanded().pose;
        self.advance(v, t)
    }

    fn next_step(&mut self, v: &Reading<(S,)>, t: Tick) -> Result<Step<R>, Fault> {
        self.advance(v, t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc_robots::{Irp6, SimulatedIrp6};
    use std::time::Duration;

    struct Probe;

    #[derive(Clone, Copy, Payload)]
    struct Contact {
        made: bool,
    }

    impl Sensor for Probe {
        const KIND: &'static str = "probe";
        type Reading = Contact;
        type Configuration = ();
    }

    /// A surface at this height in the world \[m\].
    struct Surface(f64);

    impl VirtualSensor for Surface {
        type Kind = Probe;
        fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Contact, Fault> {
            let tool = order.robot.ok_or_else(|| Fault::thrown("the probe is on no robot"))?;
            Ok(Contact { made: tool.pose.translation.z <= self.0 })
        }
    }

    #[test]
    fn the_tool_stops_at_the_surface() {
        let irp6 = Irp6::nominal();
        let start = Irp6::READY;
        let arm = SimulatedIrp6::new(irp6.clone(), &start);
        let shaft = arm.shaft();
        let surface = irp6.forward(&start).translation.z - 0.01;
        let robot = RobotSetup::new("irp6", irp6.clone(), arm).program(|ecp| {
            let mut probe = ecp.sensor::<Probe>("probe")?;
            let approach =
                GuardedApproach::along(-Vector3::z_axis(), 0.02, 0.2, 0.05, |contact: &Contact| contact.made);
            ecp.move_robot((&mut probe,), approach).map(drop)
        });
        let probe = SensorSetup::new("probe", Surface(surface)).of("irp6");
        let report =
            Cell::new(Duration::from_millis(2)).robot(robot).sensor(probe).run().expect("there is contact");
        // D / V + V / 2A to the surface, and a few steps to feel it, to end and to brake.
        let duration = report.time.as_secs_f64();
        assert!((0.55..0.60).contains(&duration), "{duration} s");
        let below = surface - irp6.forward(&shaft.state().position).translation.z;
        assert!((0.0..10.0 * 0.02 * 2e-3).contains(&below), "{below} m");
    }
}
