//! Wait in an ECP, eq. 4: readings and the robot's state in every step, until the condition holds; `e` does not
//! change.

use crate::control::sensing::{Readings, SensorsRead};
use crate::link::Sample;
use crate::link::message::{RequestKind, flag};
use crate::model::class::Uses;
use crate::model::fault::{Fault, FaultKind};
use crate::model::generator::Condition;
use crate::model::image::RobotImage;
use crate::model::list::{AnyRobots, PayloadType, RobotList, SensorsOf, State};
use crate::model::payload::Order;
use crate::model::robot::Robot;
use crate::model::step::Tick;
use crate::model::type_name::TypeName;
use crate::model::wire::{BadWords, Wire};
use crate::operator::state::InstructionKind;

use super::{Ecp, OfInstruction};

/// The images that a condition looks at in an ECP: its robot's or none.
#[doc(hidden)]
pub trait LooksAt<R: Robot>: RobotList {
    fn look(image: &RobotImage<R>) -> Self::Images;
}

impl<R: Robot> LooksAt<R> for R {
    fn look(image: &RobotImage<R>) -> RobotImage<R> {
        *image
    }
}

impl<R: Robot> LooksAt<R> for AnyRobots {
    fn look(_: &RobotImage<R>) {}
}

impl<R: Robot> Ecp<'_, R> {
    /// **Wait**: holds until the condition is met; returns it.
    ///
    /// # Errors
    /// The [`Fault`] that ended it.
    pub fn wait_until<C>(&mut self, sensors: impl SensorsOf<C::Sensors>, condition: C) -> Result<C, Fault>
    where
        C: Condition,
        C::Robots: LooksAt<R>,
    {
        self.wait_until_or(sensors, condition, None)
    }

    /// **Wait** with a time-out of `steps` steps.
    ///
    /// # Errors
    /// `TimedOut` when the condition was not met in that time; the [`Fault`] that ended it otherwise.
    pub fn wait_at_most<C>(
        &mut self,
        sensors: impl SensorsOf<C::Sensors>,
        condition: C,
        steps: u64,
    ) -> Result<C, Fault>
    where
        C: Condition,
        C::Robots: LooksAt<R>,
    {
        self.wait_until_or(sensors, condition, Some(steps))
    }

    fn wait_until_or<C>(
        &mut self,
        sensors: impl SensorsOf<C::Sensors>,
        condition: C,
        limit: Option<u64>,
    ) -> Result<C, Fault>
    where
        C: Condition,
        C::Robots: LooksAt<R>,
    {
        let by = TypeName::of::<C>();
        self.show_instruction(InstructionKind::Wait, by);
        let outcome = self.check_and_hold(sensors, condition, limit);
        self.show_instruction(InstructionKind::Nothing, by);
        outcome
    }

    fn check_and_hold<C>(
        &mut self,
        sensors: impl SensorsOf<C::Sensors>,
        condition: C,
        limit: Option<u64>,
    ) -> Result<C, Fault>
    where
        C: Condition,
        C::Robots: LooksAt<R>,
    {
        self.sensing.check(&sensors).map_err(|fault| fault.in_process(self.process))?;
        let mut awaited = Awaited { condition, sensors: Readings::of(sensors) };
        self.hold_until(&mut awaited, limit)?;
        Ok(awaited.condition)
    }

    /// Eq. 4: readings and the robot's state, until the condition holds.
    fn hold_until(&mut self, awaited: &mut dyn AnyAwaited<R>, limit: Option<u64>) -> Result<(), Fault> {
        let (uses, payload) = awaited.facts();
        self.check_ready()?;
        self.check_payload(payload, uses.order)?;
        self.settle()?;
        let mut step = 0;
        let end = loop {
            match self.next_of_instruction()? {
                OfInstruction::Step => {}
                OfInstruction::End => break Err(self.instruction_over(false)),
                OfInstruction::Abort => break Err(self.instruction_over(true)),
            }
            // The robot stands, so a late step stops nothing. But what a Wait took must not count as one step of the Move
            // after it.
            let own_time = self.host.meter.own_time();
            if step > 0 {
                self.host.meter.sample(Sample::Worked(own_time));
            }
            self.refresh(awaited.sensors(), uses.robots)?;
            let header = *self.orders.header();
            // Suspended, a Wait waits on.
            if !self.orders.is(flag::SUSPENDED) {
                let t = Tick { step, dt: header.dt, duration: header.duration };
                let is_met = awaited.is_met(self.orders.words(), &self.driver.image, t);
                match is_met.map_err(|_| self.fail(Fault::new(FaultKind::Message)))? {
                    Ok(true) => break Ok(()),
                    Ok(false) => {}
                    Err(fault) => return Err(self.fail(fault.thrown_by_program())),
                }
                step += 1;
                if limit.is_some_and(|limit| step > limit) {
                    let fault =
                        Fault::orderly(FaultKind::TimedOut).in_process(self.process).at_step(header.step);
                    let fault = fault.in_instruction(self.instruction());
                    break Err(fault.exceeds(step as f64, limit.unwrap_or(0) as f64, "step"));
                }
            }
            self.reply_with_state();
        };
        awaited.store();
        end
    }

    /// A Wait-style exchange: readings and the robot's state, while the demand does not change.
    pub(super) fn refresh(&mut self, sensors: &mut dyn SensorsRead, needs_state: bool) -> Result<(), Fault> {
        if needs_state || !sensors.places().is_empty() || self.orders.is(flag::WANT_STATE) {
            self.ask(RequestKind::Query, flag::WANT_STATE)?;
        }
        self.order_readings(sensors);
        let collected = self.sensing.collect(sensors, self.host.waiter, self.orders.header().step);
        collected.map_err(|fault| self.fail(fault))
    }

    /// Orders the readings of a step, with the state that the robot had last.
    pub(super) fn order_readings(&mut self, sensors: &dyn SensorsRead) {
        let robot = self.driver.effector_state();
        self.sensing.order(sensors, self.orders.header().step, &|of| of.and(robot));
    }
}

/// A condition that is waited for, with the handles of its sensors.
struct Awaited<C: Condition, H: SensorsOf<C::Sensors>> {
    condition: C,
    sensors: Readings<C::Sensors, H>,
}

/// The same, whatever its type.
trait AnyAwaited<R: Robot> {
    /// What it looks at, and the order that it reads.
    fn facts(&self) -> (Uses, PayloadType);
    fn sensors(&mut self) -> &mut dyn SensorsRead;
    /// Keeps what was read for the time between instructions.
    fn store(&mut self);
    /// Whether it is met, or what it throws, shown the words of an order and an image.
    fn is_met(
        &mut self,
        words: &[u64],
        image: &RobotImage<R>,
        t: Tick,
    ) -> Result<Result<bool, Fault>, BadWords>;
}

impl<R: Robot, C: Condition, H: SensorsOf<C::Sensors>> AnyAwaited<R> for Awaited<C, H>
where
    C::Robots: LooksAt<R>,
{
    fn facts(&self) -> (Uses, PayloadType) {
        (const { C::CLASS.next }, PayloadType::of::<C::Order>())
    }

    fn sensors(&mut self) -> &mut dyn SensorsRead {
        &mut self.sensors
    }

    fn store(&mut self) {
        self.sensors.store();
    }

    fn is_met(
        &mut self,
        words: &[u64],
        image: &RobotImage<R>,
        t: Tick,
    ) -> Result<Result<bool, Fault>, BadWords> {
        // One that does not read it is given zeros.
        let order =
            if const { C::CLASS.next }.order { Order::new(Wire::get(words)?) } else { Order::unread()? };
        let e = State::new(C::Robots::look(image));
        Ok(self.condition.is_met(&order, &e, &self.sensors.v, t))
    }
}
