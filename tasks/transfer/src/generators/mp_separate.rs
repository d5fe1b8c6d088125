//! Separate motions, the coordinator's half: a constant order, `f**() = const`.

use core::marker::PhantomData;

use mrroc::generator::RobotsEach;
use mrroc::prelude::*;

use crate::orders::Phase;

/// Tells all robots of the list `L` to carry out one phase, until each has finished it.
pub struct Trigger<L> {
    phase: Phase,
    of: PhantomData<L>,
}

impl<L> Trigger<L> {
    /// To this phase.
    #[must_use]
    pub const fn to(phase: Phase) -> Self {
        Trigger { phase, of: PhantomData }
    }
}

#[generator(mp)]
impl<L: RobotsEach<Phase, Phase>> Trigger<L> {
    fn next_step(&mut self) -> Always<L, Phase> {
        Always(L::each(|_| self.phase))
    }
}
