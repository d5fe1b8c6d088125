//! The transparent ECP: passes the MP's demands on, for tight cooperation programmed in the MP alone.

use core::marker::PhantomData;

use crate::control::ecp::Ecp;
use crate::model::class::{Class, Level, Uses};
use crate::model::demand::Demand;
use crate::model::fault::{Fault, FaultKind};
use crate::model::generator::Generator;
use crate::model::list::{Motion, PayloadType, Reading, State};
use crate::model::payload::Order;
use crate::model::robot::Robot;
use crate::model::step::{Step, Tick};

/// Demands what the MP orders: `f*4(c0, c)`.
pub struct Transparent<R>(PhantomData<R>);

impl<R: Robot> Transparent<R> {
    /// For a robot of kind `R`.
    #[must_use]
    pub const fn new() -> Self {
        Transparent(PhantomData)
    }
}

impl<R: Robot> Default for Transparent<R> {
    fn default() -> Self {
        Self::new()
    }
}

#[diagnostic::do_not_recommend]
impl<R: Robot> Generator for Transparent<R> {
    type Robots = R;
    type Language = Motion;
    type Sensors = ();
    type Order = Demand<R>;
    const CLASS: Class = Class::new(Level::Ecp, Uses { order: true, ..Uses::NOTHING });
    const ENDS: bool = false;

    fn first_step(
        &mut self,
        order: &Order<Demand<R>>,
        _: &State<R>,
        _: &Reading<()>,
        _: Tick,
    ) -> Result<Step<R>, Fault> {
        Ok(Step::Next(order.value()))
    }

    fn next_step(
        &mut self,
        order: &Order<Demand<R>>,
        e: &State<R>,
        v: &Reading<()>,
        t: Tick,
    ) -> Result<Step<R>, Fault> {
        self.first_step(order, e, v, t)
    }
}

/// The program of an ECP that has none of its own, for demands that the MP calls `demand`.
pub(crate) fn program<R: Robot>(ecp: &mut Ecp<R>, demand: PayloadType) -> Result<(), Fault> {
    loop {
        let pass_on =
            |ecp: &mut Ecp<R>, _: Demand<R>| ecp.move_by_orders(Transparent::new(), demand).map(drop);
        match ecp.serve_orders(demand, pass_on) {
            // An abort ends an instruction, not the robot's service.
            Err(fault) if fault.kind() != FaultKind::Aborted => return Err(fault),
            Ok(()) | Err(_) => {}
        }
    }
}
