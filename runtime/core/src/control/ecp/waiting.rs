//! Wait in an ECP, eq. 4: readings and the robot's state in every step, until the condition holds; `e` does not
//! change.

use crate::link::Sample;
use crate::link::message::{RequestKind, flag};
use crate::model::fault::{Fault, FaultKind};
use crate::model::generator::Condition;
use crate::model::image::RobotImage;
use crate::model::list::{AnyRobots, RobotList, SensorList, SensorsOf};
use crate::model::list::{Reading, State};
use crate::model::robot::Robot;
use crate::model::step::Tick;
use crate::model::type_name::TypeName;
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
        let outcome = self.hold_until(sensors, condition, limit);
        self.show_instruction(InstructionKind::Nothing, by);
        outcome
    }

    /// Eq. 4: readings and the robot's state, until the condition holds.
    fn hold_until<C>(
        &mut self,
        mut sensors: impl SensorsOf<C::Sensors>,
        mut condition: C,
        limit: Option<u64>,
    ) -> Result<C, Fault>
    where
        C: Condition,
        C::Robots: LooksAt<R>,
    {
        let uses = const { C::CLASS.next };
        self.sensing.check(&sensors).map_err(|fault| fault.in_process(self.process))?;
        self.check_ready()?;
        self.check_payload::<C::Order>(uses.order)?;
        self.settle()?;
        let mut v = Reading::new(sensors.images());
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
            self.refresh(&sensors, &mut v, uses.robots)?;
            let header = *self.orders.header();
            // Suspended, a Wait waits on.
            if !self.orders.is(flag::SUSPENDED) {
                let order = self.read_order(uses.order)?;
                let e = State::new(C::Robots::look(&self.driver.image));
                let t = Tick { step, dt: header.dt, duration: header.duration };
                match condition.is_met(&order, &e, &v, t) {
                    Ok(true) => break Ok(condition),
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
        sensors.store(&v);
        end
    }

    /// A Wait-style exchange: readings and the robot's state, while the demand does not change.
    pub(super) fn refresh<S: SensorList>(
        &mut self,
        sensors: &impl SensorsOf<S>,
        v: &mut Reading<S>,
        needs_state: bool,
    ) -> Result<(), Fault> {
        if needs_state || S::LEN > 0 || self.orders.is(flag::WANT_STATE) {
            self.ask(RequestKind::Query, flag::WANT_STATE)?;
        }
        self.order_readings(sensors);
        self.collect_readings(sensors, v)
    }

    /// Orders the readings of a step, with the state that the robot had last.
    pub(super) fn order_readings<S: SensorList>(&mut self, sensors: &impl SensorsOf<S>) {
        let robot = self.driver.effector_state();
        self.sensing.order(sensors, self.orders.header().step, |of| of.and(robot));
    }

    /// Collects them.
    pub(super) fn collect_readings<S: SensorList>(
        &mut self,
        sensors: &impl SensorsOf<S>,
        v: &mut Reading<S>,
    ) -> Result<(), Fault> {
        let collected = self.sensing.collect(sensors, v, self.host.waiter, self.orders.header().step);
        collected.map_err(|fault| self.fail(fault))
    }
}
