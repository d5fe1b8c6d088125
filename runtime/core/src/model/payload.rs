//! The typed payloads of orders, readings and sensor configurations.

use crate::model::shape::Shape;
use crate::model::wire::{BadWords, WORDS, Wire};

/// What travels between processes as one value: an MP's order, a sensor's reading or its configuration.
///
/// Derive it: `#[derive(Clone, Copy, mrroc::payload::Payload)]`. An `enum` is an order of *loose* cooperation (an
/// ECP acts on it on its own and may finish early); its variants may carry data, such as the number of a part and the pose
/// that it lies in. A `struct` of numbers is one of *tight* cooperation (every step counts; finishing early is a fault).
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no payload",
    label = "cannot travel between processes",
    note = "derive it over the type: `#[derive(Clone, Copy, mrroc::payload::Payload)]`"
)]
pub trait Payload: Wire {
    /// The type's name, for messages.
    const NAME: &'static str;

    /// Whether cooperation by this payload is tight.
    const TIGHT: bool;

    /// What identifies the type on the wire: two halves of a motion that differ in it are refused before
    /// anything moves.
    const ID: u64 = Self::LAYOUT;
}

/// No payload at all: the order of a program that has none, the configuration of a sensor without one.
impl Payload for () {
    const NAME: &'static str = "()";
    const TIGHT: bool = false;
}

/// The order of the triggering MP: the constant that starts every ECP program of a cell without an MP program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trigger;

impl Wire for Trigger {
    const LEN: usize = 0;
    // Its first name identifies it on the wire, as before.
    const LAYOUT: u64 = crate::model::wire::layout_hash(0, "mrroc::payload::Nudge");
    const SHAPE: &'static Shape = &Shape::Fields(&[]);
    fn put(&self, _: &mut [u64]) {}
    fn get(_: &[u64]) -> Result<Self, crate::model::wire::BadWords> {
        Ok(Trigger)
    }
}

impl Payload for Trigger {
    const NAME: &'static str = "Trigger";
    const TIGHT: bool = false;
}

/// The MP's order as an ECP's step function sees it: `c0` of the paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order<P> {
    value: P,
}

impl<P: Payload> Order<P> {
    /// An order of `value`, for calling a step function in a test.
    #[must_use]
    pub const fn new(value: P) -> Self {
        Order { value }
    }

    /// The order of a step function that reads none: its words are zeros.
    pub(crate) fn unread() -> Result<Self, BadWords> {
        P::get(&[0; WORDS]).map(Order::new)
    }

    /// What the MP ordered in this step.
    #[must_use]
    pub const fn value(&self) -> P {
        self.value
    }
}
