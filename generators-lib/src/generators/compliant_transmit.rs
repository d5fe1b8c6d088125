//! Passes the coordinator's displacements on, displaced by a little where the tool is pushed.

use core::marker::PhantomData;

use mrroc::fault::FaultKind;
use mrroc::pose::Wrench;
use mrroc::prelude::*;

use mrroc_generators::cooperation::{Correction, Displacement, SqueezeLaw};

/// The ECP's half of tight cooperation by displacements for an arm that inserts, wipes or carries with others. By an
/// admittance its tool yields to the load that the wrist sensor reads. It is a fault if that would displace the tool by
/// more than the bounds of the law. The MP does not learn of the displacement.
///
/// ```
/// use mrroc::generator::Generator;
/// use mrroc::{pose::Wrench, sensor::SensorImage};
/// use mrroc::prelude::*;
/// use mrroc_generators::cooperation::{Displacement, GraspStiffness, SqueezeBounds, SqueezeGains, SqueezeLaw};
/// use mrroc_generators::generators::CompliantTransmit;
/// use mrroc_generators::rehearsal::at_rest;
/// use mrroc_robots::{Irp6, Six};
///
/// # struct Wrist;
/// # impl Sensor for Wrist {
/// #     const KIND: &'static str = "wrist";
/// #     type Reading = Wrench;
/// #     type Configuration = ();
/// # }
/// let stiffness = GraspStiffness { force: 2000.0, torque: 20.0 };
/// let gains = SqueezeGains { stiffness, rate: 5.0, inertia: 0.0 };
/// let bounds = SqueezeBounds { speed: 0.2, turning: 0.2, travel: 0.1, angle: 0.1 };
/// let law = SqueezeLaw::new(gains, bounds, 0.01).map_err(|bad| Fault::thrown(&bad.to_string()))?;
/// let mut transmit = CompliantTransmit::<Irp6, Wrist>::by(law, 1);
/// // Ordered 10 mm along z and pushed back by 20 N, the tool yields at a F / K = 5 * 20 / 2000 m/s: 0.1 mm in a step.
/// let order = Order::new(Displacement { pose: Pose::translation(0.0, 0.0, 0.01) });
/// let felt = Wrench::new(nalgebra::Vector3::z() * -20.0, nalgebra::Vector3::zeros());
/// let v = Reading::new((SensorImage::new(felt, 0),));
/// let t = Tick { step: 0, dt: 0.002, duration: 0.002 };
/// # let e = State::new(at_rest(&Irp6::nominal(), Six::zeros()));
/// let Step::Next(demand) = transmit.next_step(&order, &e, &v, t)? else { unreachable!() };
/// let z = demand.as_displacement().map(|pose| pose.translation.z);
/// assert!(z.is_some_and(|z| (z - 0.0099).abs() < 1e-12));
/// # Ok::<(), Fault>(())
/// ```
pub struct CompliantTransmit<R, S> {
    law: SqueezeLaw,
    oldest: u32,
    correction: Correction,
    of: PhantomData<(R, S)>,
}

impl<R: Robot, S: Sensor<Reading = Wrench>> CompliantTransmit<R, S> {
    /// The tool yields by `law`; readings may be up to `oldest` steps old.
    #[must_use]
    pub fn by(law: SqueezeLaw, oldest: u32) -> Self {
        CompliantTransmit { law, oldest, correction: Correction::default(), of: PhantomData }
    }
}

#[generator(ecp)]
impl<R: Robot, S: Sensor<Reading = Wrench>> CompliantTransmit<R, S> {
    fn next_step(
        &mut self,
        order: &Order<Displacement>,
        v: &Reading<(S,)>,
        t: Tick,
    ) -> Result<Step<R>, Fault> {
        let (load, dt) = v.0.reading().map_or((Wrench::default(), 0.0), |load| (load, t.dt));
        if dt > 0.0 && v.0.age() > self.oldest {
            let fault = Fault::new(FaultKind::SensorStale);
            return Err(fault.exceeds(v.0.age().into(), self.oldest.into(), "step"));
        }
        // Without a reading the correction stays as it is.
        let yielded = self.law.advance(&mut self.correction, &load, dt)?;
        Ok(Step::Next(Demand::displacement(order.value().pose * yielded)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::pose::Pose;
    use mrroc::sensor::SensorImage;
    use mrroc_generators::cooperation::{GraspStiffness, SqueezeBounds, SqueezeGains};
    use mrroc_robots::Irp6;
    use nalgebra::Vector3;

    struct Wrist;

    impl Sensor for Wrist {
        const KIND: &'static str = "wrist";
        type Reading = Wrench;
        type Configuration = ();
    }

    #[test]
    fn a_push_displaces_what_is_ordered() {
        let stiffness = GraspStiffness { force: 5e4, torque: 500.0 };
        let gains = SqueezeGains { stiffness, rate: 5.0, inertia: 0.0 };
        let bounds = SqueezeBounds { speed: 0.01, turning: 0.1, travel: 1e-3, angle: 0.01 };
        let law = SqueezeLaw::new(gains, bounds, 0.01).expect("reserve");
        let mut generator = CompliantTransmit::<Irp6, Wrist>::by(law, 1);
        let t = Tick { step: 0, dt: 2e-3, duration: 2e-3 };
        let order = Order::new(Displacement { pose: Pose::translation(0.0, 0.0, 0.125) });
        let push = |age| {
            let wrench = Wrench::new(Vector3::new(25.0, 0.0, 0.0), Vector3::zeros());
            Reading::new((SensorImage::new(wrench, age),))
        };
        // F / K a T = 25 / 5e4 * 5 * 2e-3 in every step.
        for n in 1..=4 {
            let step = generator.next_step(&order, &push(0), t).expect("within the bounds");
            let Step::Next(demand) = step else { panic!("it ended") };
            assert_eq!(demand, Demand::displacement(Pose::translation(5e-6 * f64::from(n), 0.0, 0.125)));
        }
        let fault = generator.next_step(&order, &push(2), t).expect_err("two steps old");
        assert_eq!(fault.kind(), FaultKind::SensorStale);
    }
}
