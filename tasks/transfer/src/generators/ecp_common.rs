//! The common motion, an arm's half: only transmits.

use core::marker::PhantomData;

use mrroc::prelude::*;
use mrroc_generators::cooperation::Displacement;

/// Demands of an arm of kind `R` what the coordinator orders.
pub struct Transmit<R>(pub PhantomData<R>);

#[generator(ecp)]
impl<R: Robot> Transmit<R> {
    fn next_step(order: &Order<Displacement>) -> Always<R> {
        Always(Demand::displacement(order.value().pose))
    }
}
