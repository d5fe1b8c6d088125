//! Wait in the MP, eq. 4: readings and the robots' states in every step, until the condition holds; `e` does not
//! change.

use crate::control::sensing::{Readings, SensorsRead};
use crate::link::message::{OrderKind, flag};
use crate::model::fault::{Fault, FaultKind};
use crate::model::generator::Condition;
use crate::model::list::{RobotsOf, SensorsOf, State};
use crate::model::payload::Order;
use crate::model::step::Tick;
use crate::model::type_name::TypeName;

use crate::operator::state::InstructionKind;

use super::Mp;
use super::robots::RobotPorts;

impl Mp<'_> {
    /// **Wait**: holds until the condition is met; returns it. The robots' images are refreshed in every step.
    ///
    /// # Errors
    /// The [`Fault`] that ended it.
    pub fn wait_until<C: Condition>(
        &mut self,
        robots: impl RobotsOf<C::Robots>,
        sensors: impl SensorsOf<C::Sensors>,
        condition: C,
    ) -> Result<C, Fault> {
        self.wait_until_or(robots, sensors, condition, None)
    }

    /// **Wait** with a time-out of `steps` steps.
    ///
    /// # Errors
    /// `TimedOut` when the condition was not met in that time; the [`Fault`] that ended it otherwise.
    pub fn wait_at_most<C: Condition>(
        &mut self,
        robots: impl RobotsOf<C::Robots>,
        sensors: impl SensorsOf<C::Sensors>,
        condition: C,
        steps: u64,
    ) -> Result<C, Fault> {
        self.wait_until_or(robots, sensors, condition, Some(steps))
    }

    fn wait_until_or<C: Condition>(
        &mut self,
        mut robots: impl RobotsOf<C::Robots>,
        sensors: impl SensorsOf<C::Sensors>,
        condition: C,
        limit: Option<u64>,
    ) -> Result<C, Fault> {
        self.check_handles(&robots, &sensors)?;
        let indices = robots.indices();
        let indices = indices.as_ref();
        let order = Order::unread().map_err(|_| self.conclude(Fault::new(FaultKind::Message)))?;
        let (e, sensors) = (State::new(robots.images()), Readings::of(sensors));
        let mut awaited = Awaited { condition, sensors, e, order };
        let outcome = self.wait_for(TypeName::of::<C>(), indices, &mut awaited, limit);
        self.robots.each_image(indices, &mut |i, words| robots.refresh(i, words))?;
        awaited.sensors.store();
        outcome.map(|()| awaited.condition)
    }

    fn wait_for(
        &mut self,
        by: TypeName,
        indices: &[usize],
        awaited: &mut dyn AnyAwaited,
        limit: Option<u64>,
    ) -> Result<(), Fault> {
        self.instruction(InstructionKind::Wait, by, |mp| mp.wait_step(indices, awaited, limit))
    }

    /// Eq. 4: order and collect the readings, refresh the robots' states, until the condition holds.
    fn wait_step(
        &mut self,
        indices: &[usize],
        awaited: &mut dyn AnyAwaited,
        limit: Option<u64>,
    ) -> Result<(), Fault> {
        self.settle()?;
        let mut step = 0;
        loop {
            self.begin_step()?;
            if self.is_ending() && self.background.is_empty() {
                return Err(self.ending());
            }
            if self.is_at_rest_on_path()? {
                return self.abort(&[]);
            }
            self.learn_states(awaited.sensors())?;
            self.order_readings(awaited.sensors());
            self.exchange(indices, OrderKind::Query, flag::WANT_STATE)?;
            self.sensing.collect(awaited.sensors(), self.host.waiter, self.clock.step())?;
            awaited.look(&self.robots, indices)?;
            if self.clock.is_suspended() || self.is_ending() {
                // Suspended, a Wait waits on; one that is to end does so when the robots in the background stand.
                continue;
            }
            if awaited.is_met(self.clock.tick(step)).map_err(Fault::thrown_by_program)? {
                return Ok(());
            }
            step += 1;
            if let Some(limit) = limit.filter(|&limit| step > limit) {
                let fault = Fault::orderly(FaultKind::TimedOut).at_step(self.clock.step());
                return Err(fault.exceeds(step as f64, limit as f64, "step"));
            }
        }
    }
}

/// A condition that is waited for, with what it is shown.
struct Awaited<C: Condition, H: SensorsOf<C::Sensors>> {
    condition: C,
    sensors: Readings<C::Sensors, H>,
    e: State<C::Robots>,
    order: Order<C::Order>,
}

/// The same, whatever its type.
trait AnyAwaited {
    fn sensors(&mut self) -> &mut dyn SensorsRead;
    /// Shows it the images in the replies of its robots, which are at `indices`.
    fn look(&mut self, robots: &RobotPorts, indices: &[usize]) -> Result<(), Fault>;
    fn is_met(&mut self, t: Tick) -> Result<bool, Fault>;
}

impl<C: Condition, H: SensorsOf<C::Sensors>> AnyAwaited for Awaited<C, H> {
    fn sensors(&mut self) -> &mut dyn SensorsRead {
        &mut self.sensors
    }

    fn look(&mut self, robots: &RobotPorts, indices: &[usize]) -> Result<(), Fault> {
        robots.read_images::<C::Robots>(indices, &mut self.e)
    }

    fn is_met(&mut self, t: Tick) -> Result<bool, Fault> {
        self.condition.is_met(&self.order, &self.e, &self.sensors.v, t)
    }
}
