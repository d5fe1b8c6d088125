//! Passes the coordinator's displacements on to the robot.

use core::marker::PhantomData;

use mrroc::{Always, Demand, Order, Robot, generator};

use mrroc_generators::cooperation::Displacement;

/// The ECP's half of tight cooperation by displacements: demands what the MP orders, and ends when the MP ends.
pub struct TransmitDisplacement<R>(PhantomData<R>);

impl<R: Robot> TransmitDisplacement<R> {
    /// For a robot of kind `R`.
    #[must_use]
    pub const fn new() -> Self {
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
