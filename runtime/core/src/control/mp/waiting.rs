//! Wait in the MP, eq. 4: readings and the robots' states in every step, until the condition holds; `e` does not
//! change.

use crate::link::message::{OrderKind, flag};
use crate::model::fault::{Fault, FaultKind};
use crate::model::generator::Condition;
use crate::model::list::{Reading, State};
use crate::model::list::{RobotsOf, SensorsOf};
use crate::model::payload::Order;
use crate::model::type_name::TypeName;

use crate::operator::state::InstructionKind;

use super::Mp;

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
        mut sensors: impl SensorsOf<C::Sensors>,
        mut condition: C,
        limit: Option<u64>,
    ) -> Result<C, Fault> {
        self.check_handles(&robots, &sensors)?;
        let indices = robots.indices();
        let indices = indices.as_ref();
        let mut e = State::new(robots.images());
        let mut v = Reading::new(sensors.images());
        let outcome = self.instruction(InstructionKind::Wait, TypeName::of::<C>(), |mp| {
            mp.wait_step(indices, &sensors, &mut condition, &mut e, &mut v, limit)
        });
        self.robots.each_image(indices, |i, words| robots.refresh(i, words))?;
        sensors.store(&v);
        outcome.map(|()| condition)
    }

    /// Eq. 4: order and collect the readings, refresh the robots' states, until the condition holds.
    fn wait_step<C: Condition>(
        &mut self,
        indices: &[usize],
        sensors: &impl SensorsOf<C::Sensors>,
        condition: &mut C,
        e: &mut State<C::Robots>,
        v: &mut Reading<C::Sensors>,
        limit: Option<u64>,
    ) -> Result<(), Fault> {
        let order = Order::unread().map_err(|_| Fault::new(FaultKind::Message))?;
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
            self.learn_states(sensors)?;
            self.order_readings(sensors);
            self.exchange(indices, OrderKind::Query, flag::WANT_STATE)?;
            self.sensing.collect(sensors, v, self.host.waiter, self.clock.step())?;
            self.robots.read_images::<C::Robots>(indices, e)?;
            if self.clock.is_suspended() || self.is_ending() {
                // Suspended, a Wait waits on; one that is to end does so when the robots in the background stand.
                continue;
            }
            let t = self.clock.tick(step);
            if condition.is_met(&order, e, v, t).map_err(Fault::thrown_by_program)? {
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
