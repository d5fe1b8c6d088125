//! Move in an ECP, eq. 6: the demands of one robot, one per step, until its generator is done.
//!
//! In: orders (`c0`, path time `dt`), the robot's image (`e`), readings (`v`). Out: one demand per step to the EDP.
//! Path time that does not pass holds the robot, whatever the generator returns; END makes a generator with a path
//! of its own slow down on it.

use crate::control::overruns::periods_in;
use crate::control::sensing::{Readings, SensorsRead};
use crate::link::Sample;
use crate::link::message::{RequestKind, flag};
use crate::model::class::Uses;
use crate::model::demand::Demand;
use crate::model::fault::{Fault, FaultKind};
use crate::model::generator::Generator;
use crate::model::image::RobotImage;
use crate::model::list::{Motion, PayloadType, SensorsOf, State};
use crate::model::payload::Order;
use crate::model::robot::Robot;
use crate::model::step::{Step, Tick};
use crate::model::type_name::TypeName;
use crate::model::wire::{BadWords, Wire};
use crate::operator::state::InstructionKind;
use crate::safety::rate::{DEFAULT_CHANGE, Feed};

use super::{Ecp, OfInstruction, Trouble};

/// What becomes of a motion that ends while it moves.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ending {
    /// The braking tail is appended.
    Standstill,
    /// The next motion takes over in the very next step.
    Blend,
}

impl<R: Robot> Ecp<'_, R> {
    /// **Move**: generates the robot's next states, one per step, until the generator is done; returns it.
    ///
    /// A generator that ends while moving gets the braking tail: the Move returns at standstill.
    ///
    /// # Errors
    /// The [`Fault`] that ended the motion, at standstill.
    pub fn move_robot<G>(&mut self, sensors: impl SensorsOf<G::Sensors>, generator: G) -> Result<G, Fault>
    where
        G: Generator<Robots = R, Language = Motion>,
    {
        self.run(sensors, generator, PayloadType::of::<G::Order>(), Ending::Standstill)
    }

    /// **Move** that hands a moving robot over: the next Move starts in the very next step, from this one's
    /// last demand and its velocity. Anything else than a Move brakes first.
    ///
    /// # Errors
    /// The [`Fault`] that ended the motion, at standstill.
    pub fn blend_robot<G>(&mut self, sensors: impl SensorsOf<G::Sensors>, generator: G) -> Result<G, Fault>
    where
        G: Generator<Robots = R, Language = Motion>,
    {
        self.run(sensors, generator, PayloadType::of::<G::Order>(), Ending::Blend)
    }

    /// As [`move_robot`](Self::move_robot), by a generator that reads no sensors, and orders that the MP calls `payload`.
    pub(in crate::control) fn move_by_orders<G>(
        &mut self,
        generator: G,
        payload: PayloadType,
    ) -> Result<G, Fault>
    where
        G: Generator<Robots = R, Language = Motion, Sensors = ()>,
    {
        self.run((), generator, payload, Ending::Standstill)
    }

    fn run<G>(
        &mut self,
        sensors: impl SensorsOf<G::Sensors>,
        generator: G,
        payload: PayloadType,
        ending: Ending,
    ) -> Result<G, Fault>
    where
        G: Generator<Robots = R, Language = Motion>,
    {
        self.sensing.check(&sensors).map_err(|fault| fault.in_process(self.process))?;
        let order = Order::unread().map_err(|_| self.fail(Fault::new(FaultKind::Message)))?;
        let e = State::<R>::new(self.driver.image);
        let mut progress = Progress { generator, sensors: Readings::of(sensors), e, payload, order };
        let by = TypeName::of::<G>();
        self.jogging.begin_move();
        self.show_instruction(InstructionKind::Move, by);
        let end = self.generate(&mut progress, ending);
        self.jogging.end_move();
        self.show_instruction(InstructionKind::Nothing, by);
        progress.sensors.store();
        end.map(|()| progress.generator)
    }

    fn generate(&mut self, progress: &mut dyn AnyProgress<R>, ending: Ending) -> Result<(), Fault> {
        let Facts { first_uses, next_uses, order } = progress.facts();
        self.check_ready()?;
        self.check_payload(order, first_uses.order || next_uses.order)?;
        let mut step = 0;
        let mut own = Feed::new(DEFAULT_CHANGE);
        let mut flags = flag::FIRST;
        let mut refreshed = false;
        loop {
            let ending_now = match self.next_of_instruction()? {
                OfInstruction::Step => false,
                // What transmits orders has none to transmit any more; what has no path of its own cannot
                // slow down on it; what is handed over shall not.
                OfInstruction::End
                    if next_uses.order || !next_uses.tick || step == 0 || self.orders.hands_over() =>
                {
                    break;
                }
                OfInstruction::End => true,
                OfInstruction::Abort => {
                    self.settle()?;
                    if let Trouble::New(fault) | Trouble::Told(fault) = self.trouble.clone() {
                        return Err(self.fail(fault));
                    }
                    return Err(self.instruction_over(true));
                }
            };
            self.count_own_time(step)?;
            self.jogging.hear(self.orders.jog());
            let mut dt = self.orders.header().dt;
            let mut duration = self.orders.header().duration;
            if step == 0 && !self.driver.moving && duration > 0.0 {
                // No period of this motion can have been skipped.
                let period = self.pace.period as f64 * 1e-9;
                dt = dt / duration * period;
                duration = period;
            }
            if ending_now {
                // The MP may be slowing down as well: both bound the change of the one rate that counts.
                own.limit(self.driver.reply().header.rate_margin);
                let slower = own.clone().advance(0.0, duration);
                if slower == 0.0 {
                    break;
                }
                dt = dt.min(slower * duration);
            }
            own.follow(if duration > 0.0 { dt / duration } else { 0.0 }, duration);
            let uses = if step == 0 { first_uses } else { next_uses };
            if dt == 0.0 {
                // Suspended: the robot holds whatever the generator says, which may only end.
                if step == 0 || !next_uses.tick {
                    self.execute(progress.sensors(), RequestKind::Brake, 0, uses.robots)?;
                } else {
                    self.driver.set_demand(&Demand::hold(), dt);
                    self.execute(progress.sensors(), RequestKind::Demand, 0, uses.robots)?;
                    let t = Tick { step, dt, duration };
                    let next = progress.next(Some(&self.driver.image), t);
                    self.see_who_asks();
                    match next.map_err(|fault| self.fail(fault.thrown_by_program()))? {
                        Step::Done => break,
                        Step::Next(_) => {}
                    }
                }
                self.reply_with_state();
                continue;
            }
            if step == 0 && (first_uses.robots || first_uses.sensors) && !refreshed {
                let began = self.host.waiter.now();
                self.refresh(progress.sensors(), first_uses.robots)?;
                refreshed = true;
                if self.is_late_since(began) {
                    self.reply_with_state();
                    continue;
                }
            }
            if uses.order && progress.take_order(self.orders.words()).is_err() {
                return Err(self.fail(Fault::new(FaultKind::Message)));
            }
            let image = uses.robots.then_some(&self.driver.image);
            let next = progress.next(image, Tick { step, dt, duration });
            self.see_who_asks();
            let demand = match &next {
                Ok(Step::Next(demand)) => demand,
                Ok(Step::Done) => break,
                Err(fault) => return Err(self.fail(fault.clone().thrown_by_program())),
            };
            self.driver.set_demand(demand, dt / duration * self.orders.header().duration);
            self.driver.moving = true;
            self.execute(progress.sensors(), RequestKind::Demand, flags, next_uses.robots)?;
            step += 1;
            flags = 0;
            self.reply_with_state();
        }
        match ending {
            Ending::Standstill => self.settle_unless_blending(),
            Ending::Blend => Ok(()),
        }
    }

    /// A step that took the ECP itself too long is one of those that may be too many; before the first one its program
    /// had no step to be in time for.
    fn count_own_time(&mut self, step: u64) -> Result<(), Fault> {
        let own_time = self.host.meter.own_time();
        if step == 0 {
            return Ok(());
        }
        self.host.meter.sample(Sample::Worked(own_time));
        self.overruns.note(periods_in(own_time, self.pace.period)).map_err(|fault| self.fail(fault))
    }

    /// One step of eq. 6: order the readings, send the demand, collect the reply and the readings.
    fn execute(
        &mut self,
        sensors: &mut dyn SensorsRead,
        kind: RequestKind,
        flags: u32,
        needs_state: bool,
    ) -> Result<(), Fault> {
        let wanted = if needs_state || !sensors.places().is_empty() { flag::WANT_STATE } else { 0 };
        self.order_readings(sensors);
        self.ask(kind, flags | wanted)?;
        let collected = self.sensing.collect(sensors, self.host.waiter, self.orders.header().step);
        match collected {
            // The demands are as sound as they were: the MP lets the robot stop on its path.
            Err(fault) if fault.leaves_demands_sound() && self.driver.moving => {
                if self.trouble == Trouble::None {
                    let fault = fault.at_step(self.orders.header().step);
                    self.trouble = Trouble::New(fault.in_instruction(self.instruction()));
                }
                Ok(())
            }
            Err(fault) => Err(self.fail(fault)),
            Ok(()) => Ok(()),
        }
    }
}

/// A generator in progress, with the handles of its sensors.
struct Progress<R: Robot, G: Generator<Robots = R, Language = Motion>, H: SensorsOf<G::Sensors>> {
    generator: G,
    sensors: Readings<G::Sensors, H>,
    /// What it is shown of its robot.
    e: State<R>,
    payload: PayloadType,
    order: Order<G::Order>,
}

/// What a generator's type says.
struct Facts {
    first_uses: Uses,
    next_uses: Uses,
    order: PayloadType,
}

/// A generator in progress, whatever its type: what moves a robot by it is compiled once for each kind of robots.
trait AnyProgress<R: Robot> {
    fn facts(&self) -> Facts;
    fn sensors(&mut self) -> &mut dyn SensorsRead;
    /// Takes the words of an order.
    fn take_order(&mut self, words: &[u64]) -> Result<(), BadWords>;
    /// What it says for a step, shown this image or the last one.
    fn next(&mut self, image: Option<&RobotImage<R>>, t: Tick) -> Result<Step<R>, Fault>;
}

impl<R, G, H> AnyProgress<R> for Progress<R, G, H>
where
    R: Robot,
    G: Generator<Robots = R, Language = Motion>,
    H: SensorsOf<G::Sensors>,
{
    fn facts(&self) -> Facts {
        Facts {
            first_uses: const { G::CLASS.first_uses() },
            next_uses: const { G::CLASS.next_uses() },
            order: self.payload,
        }
    }

    fn sensors(&mut self) -> &mut dyn SensorsRead {
        &mut self.sensors
    }

    fn take_order(&mut self, words: &[u64]) -> Result<(), BadWords> {
        self.order = Order::new(Wire::get(words)?);
        Ok(())
    }

    fn next(&mut self, image: Option<&RobotImage<R>>, t: Tick) -> Result<Step<R>, Fault> {
        if let Some(image) = image {
            *self.e = *image;
        }
        let v = &self.sensors.v;
        match t.step {
            0 => self.generator.first_step(&self.order, &self.e, v, t),
            _ => self.generator.next_step(&self.order, &self.e, v, t),
        }
    }
}
