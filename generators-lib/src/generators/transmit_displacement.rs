//! Passes the coordinator's displacements on to the robot.

use core::marker::PhantomData;

use mrroc::prelude::*;

use mrroc_generators::cooperation::Displacement;

/// The ECP's half of tight cooperation by displacements: demands what the MP orders, and ends when the MP ends.
///
/// ```
/// use mrroc::generator::Generator;
/// use mrroc::prelude::*;
/// use mrroc_generators::cooperation::Displacement;
/// use mrroc_generators::generators::TransmitDisplacement;
/// use mrroc_generators::rehearsal::at_rest;
/// use mrroc_robots::{Irp6, Six};
///
/// let pose = Pose::translation(0.0, 0.0, 0.01);
/// let mut transmit = TransmitDisplacement::<Irp6>::new();
/// # let e = State::new(at_rest(&Irp6::nominal(), Six::zeros()));
/// # let t = Tick { step: 0, dt: 0.002, duration: 0.002 };
/// let step = transmit.next_step(&Order::new(Displacement { pose }), &e, &Reading::new(()), t)?;
/// assert_eq!(step, Step::Next(Demand::displacement(pose)));
/// # Ok::<(), Fault>(())
/// ```
pub struct TransmitDisplacement<R>(PhantomData<R>);

impl<R: Robot> TransmitDisplacement<R> {
    /// For a robot of kind `R`.
    #[must_use]
    pub fn new() -> Self {
        TransmitDisplacement(PhantomData)
    }
}

impl<R: Robot> Default for TransmitDisplacement<R> {
    fn default() -> Self {
        Self::new()
    }
}

#[generator(ecp)]
impl<R: Robot> TransmitDisplacement<R> {
    fn next_step(order: &Order<Displacement>) -> Always<R> {
        Always(Demand::displacement(order.value().pose))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::pose::Pose;
    use mrroc_robots::Irp6;

    #[test]
    fn what_is_ordered_is_demanded() {
        let pose = Pose::translation(0.1, 0.2, 0.3);
        let Always(demand) = TransmitDisplacement::<Irp6>::next_step(&Order::new(Displacement { pose }));
        assert_eq!(demand, Demand::displacement(pose));
    }
}
