//! Presses as hard as the coordinator orders, with a tool whose weight is known.

use core::marker::PhantomData;

use mrroc::pose::Wrench;
use mrroc::prelude::*;
use nalgebra::Vector3;

use mrroc_generators::force::{Behaviour, Bound, ForceControl, Give};

/// What the coordinator orders: tight cooperation by a force and a velocity.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Pressing {
    /// Force of the tool on its surroundings along its z axis \[N\].
    pub force: f64,
    /// Velocity across it, along its x and y axes [m/s].
    pub across: [f64; 2],
}

/// Keeps the ordered force along the tool's z axis while it moves across as ordered, without turning; ends with the
/// coordinator's motion. The sensor also feels the weight of the tool; the *measured* orientation tells its component
/// along each axis.
///
/// ```
/// use mrroc::generator::Generator;
/// use mrroc::{pose::Wrench, sensor::SensorImage};
/// use mrroc::prelude::*;
/// use mrroc_generators::force::{Bound, Give};
/// use mrroc_generators::generators::{OrderedForce, Pressing};
/// use mrroc_generators::rehearsal::at_rest;
/// use mrroc_robots::Irp6;
/// use nalgebra::Vector3;
///
/// # struct Wrist;
/// # impl Sensor for Wrist {
/// #     const KIND: &'static str = "wrist";
/// #     type Reading = Wrench;
/// #     type Configuration = ();
/// # }
/// // A tool of 13.18 N that hangs down freely and is ordered to press with 10 N: the law is m dv/dt + v / b = 10 N.
/// let give = Give { reciprocal_damping: 0.005, inertia: 0.0 };
/// let mut press = OrderedForce::<Irp6, Wrist>::with_tool(13.18, give, Bound { speed: 0.1, travel: 0.05 });
/// let arm = at_rest(&Irp6::nominal(), Irp6::READY);
/// let order = Order::new(Pressing { force: 10.0, across: [0.0, 0.0] });
/// let weight = arm.measured().pose.rotation.inverse_transform_vector(&(Vector3::z() * -13.18));
/// let v = Reading::new((SensorImage::new(Wrench::new(weight, Vector3::zeros()), 0),));
/// let t = Tick { step: 0, dt: 0.002, duration: 0.002 };
/// let Step::Next(demand) = press.first_step(&order, &State::new(arm), &v, t)? else { unreachable!() };
/// // Without inertia v = b F, which makes 0.005 * 10 * 0.002 m = 0.1 mm in a step.
/// let depth = demand.as_pose().map(|pose| arm.demanded().pose.inv_mul(&pose).translation.z);
/// assert!(depth.is_some_and(|depth| (depth - 1e-4).abs() < 1e-9), "{depth:?}");
/// # Ok::<(), Fault>(())
/// ```
pub struct OrderedForce<R, S> {
    weight: f64,
    law: Result<ForceControl, Fault>,
    give: Give,
    within: Bound,
    pose: Pose,
    of: PhantomData<(R, S)>,
}

impl<R: Robot, S: Sensor<Reading = Wrench>> OrderedForce<R, S> {
    /// With a tool of this weight \[N\], whose centre of gravity matters for torques alone, a compliance along z, and how fast
    /// and how far it may go along z for its load.
    #[must_use]
    pub fn with_tool(weight: f64, give: Give, within: Bound) -> Self {
        let law = ForceControl::new([Behaviour::Unguarded { velocity: 0.0 }; 6]);
        let law = law.map_err(|bad| Fault::thrown(&bad.to_string()));
        OrderedForce { weight, law, give, within, pose: Pose::identity(), of: PhantomData }
    }
}

#[generator(ecp)]
impl<R: Robot, S: Sensor<Reading = Wrench>> OrderedForce<R, S> {
    fn first_step(
        &mut self,
        order: &Order<Pressing>,
        e: &State<R>,
        v: &Reading<(S,)>,
        t: Tick,
    ) -> Result<Step<R>, Fault> {
        self.pose = e.demanded().pose;
        self.next_step(order, e, v, t)
    }

    fn next_step(
        &mut self,
        order: &Order<Pressing>,
        e: &State<R>,
        v: &Reading<(S,)>,
        t: Tick,
    ) -> Result<Step<R>, Fault> {
        let Pressing { force: load, across: [x, y] } = order.value();
        let law = self.law.as_mut().map_err(|fault| fault.clone())?;
        let behaviours = [x, y].map(|velocity| Behaviour::Unguarded { velocity });
        let contact = Behaviour::Contact { load, give: self.give, within: self.within };
        for (axis, behaviour) in behaviours.into_iter().chain([contact]).enumerate() {
            law.set(axis, behaviour).map_err(|bad| Fault::thrown(&bad.to_string()))?;
        }
        if let Some(felt) = v.0.reading() {
            let down = e.measured().pose.rotation.inverse_transform_vector(&-Vector3::z());
            self.pose *= law.advance(&(felt - Wrench::new(down * self.weight, Vector3::zeros())), t.dt)?;
        }
        Ok(Step::Next(Demand::pose(self.pose)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc::sensor::SensorImage;
    use mrroc_robots::{Irp6, Six};
    use std::f64::consts::PI;

    struct Wrist;

    impl Sensor for Wrist {
        const KIND: &'static str = "wrist";
        type Reading = Wrench;
        type Configuration = ();
    }

    #[test]
    fn the_weight_of_the_tool_is_no_contact_and_the_order_is_the_load_on_a_spring() {
        let down = Pose::new(Vector3::new(0.8, 0.0, 0.3), Vector3::x() * PI);
        let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose: down };
        let e = State::<Irp6>::new(RobotImage::new(state, state));
        let order = Order::new(Pressing { force: 10.0, across: [0.01, 0.0] });
        let t = Tick { step: 0, dt: 2e-3, duration: 2e-3 };
        let stiffness = 2000.0;
        let mut generator =
            OrderedForce::<Irp6, Wrist>::with_tool(13.18, Give::FORCE, Bound { speed: 0.1, travel: 0.05 });
        let mut z = 0.0_f64;
        for i in 0..3000 {
            // The tool hangs along its z; the spring pushes against it.
            let felt = Wrench::new(Vector3::new(0.0, 0.0, 13.18 - stiffness * z.max(0.0)), Vector3::zeros());
            let v = Reading::new((SensorImage::new(felt, 0),));
            let step = match i {
                0 => generator.first_step(&order, &e, &v, t),
                _ => generator.next_step(&order, &e, &v, t),
            };
            assert_eq!(step.expect("finite"), Step::Next(Demand::pose(generator.pose)));
            z = down.inv_mul(&generator.pose).translation.z;
        }
        assert!((stiffness * z - 10.0).abs() < 1e-6, "{} N", stiffness * z);
        assert!((generator.pose.translation.x - 0.8 - 0.01 * 6.0).abs() < 1e-9);
    }
}
