//! Generators and conditions: the parts of Move and Wait that a programmer writes.

use crate::model::class::{Class, Level, Uses};
use crate::model::fault::Fault;
use crate::model::list::{Reading, State};
use crate::model::list::{RobotList, Robots, SensorList};
use crate::model::payload::{Order, Payload};
use crate::model::step::{Always, Step, Tick};

/// The effector transfer function of a motion, `f_e*` of eq. 6: computes the demanded next state of every
/// robot of its list, step by step, until it is done.
///
/// The `#[generator]` attribute implements this trait for a step function; you may also implement it by hand. Arguments
/// that [`CLASS`](Generator::CLASS) does not name are not exchanged: they keep old values.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no generator",
    label = "not a generator",
    note = "a generator with state is passed as its state value, one without as `name {{}}`; write `#[generator(mp)]` or `#[generator(ecp)]` over its step function"
)]
pub trait Generator: Sized {
    /// The robots that it moves: a tuple or an array in an MP, one robot in an ECP.
    type Robots: Robots<Self::Language>;
    /// What it tells each robot: [`Motion`](crate::generator::Motion) for a demand, or the type of an order's payload.
    type Language: 'static;
    /// The virtual sensors that it reads.
    type Sensors: SensorList;
    /// The MP's order that it reads, `c0`; `()` for none.
    type Order: Payload;
    /// Which arguments it takes.
    const CLASS: Class;
    /// Whether it may return [`Step::Done`]; a motion that has no end of its own ends when its ECPs have finished.
    const ENDS: bool = true;

    /// Computes the first demand, `e^{i0+1}`, from the state at the start.
    ///
    /// # Errors
    /// A [`Fault`] of its own (`f_E`): the motion stops.
    fn first_step(
        &mut self,
        order: &Order<Self::Order>,
        e: &State<Self::Robots>,
        v: &Reading<Self::Sensors>,
        t: Tick,
    ) -> Result<Step<Self::Robots, Self::Language>, Fault>;

    /// Computes the next demand, `e^{i+1}`, or ends the motion. A demand is not executed in the step in which the
    /// motion ends.
    ///
    /// # Errors
    /// A [`Fault`] of its own (`f_E`): the motion stops.
    fn next_step(
        &mut self,
        order: &Order<Self::Order>,
        e: &State<Self::Robots>,
        v: &Reading<Self::Sensors>,
        t: Tick,
    ) -> Result<Step<Self::Robots, Self::Language>, Fault>;
}

/// An initial condition of a Wait, `f_I` of eq. 4.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no condition",
    label = "not a condition",
    note = "a condition with state is passed as its state value, one without as `name {{}}`; write `#[condition(mp)]` or `#[condition(ecp)]` over its function"
)]
pub trait Condition: Sized {
    /// The robots that it looks at; [`AnyRobots`](crate::generator::AnyRobots) for none.
    type Robots: RobotList;
    /// The virtual sensors that it reads.
    type Sensors: SensorList;
    /// The MP's order that it reads, `c0`; `()` for none.
    type Order: Payload;
    /// Which arguments it takes.
    const CLASS: Class;

    /// Whether the condition holds.
    ///
    /// # Errors
    /// A [`Fault`] of its own (`f_E`): the Wait ends.
    fn is_met(
        &mut self,
        order: &Order<Self::Order>,
        e: &State<Self::Robots>,
        v: &Reading<Self::Sensors>,
        t: Tick,
    ) -> Result<bool, Fault>;
}

/// The same orders or demands in every step: `f**() = const`, the MP's part of loose cooperation.
impl<L: Robots<O>, O: 'static> Generator for Always<L, O> {
    type Robots = L;
    type Language = O;
    type Sensors = ();
    type Order = ();
    const CLASS: Class = Class::new(Level::Mp, Uses::NOTHING);
    const ENDS: bool = false;

    fn first_step(
        &mut self,
        _: &Order<()>,
        _: &State<L>,
        _: &Reading<()>,
        _: Tick,
    ) -> Result<Step<L, O>, Fault> {
        Ok(Step::Next(self.0))
    }

    fn next_step(
        &mut self,
        _: &Order<()>,
        _: &State<L>,
        _: &Reading<()>,
        _: Tick,
    ) -> Result<Step<L, O>, Fault> {
        Ok(Step::Next(self.0))
    }
}
