//! Move in the MP, eq. 6: the next states of all robots of a motion, step by step, until its generator is done.
//!
//! In: the robots' images (`e`), the MP's readings (`v`), the step's path time. Out: one demand or order per robot.

use crate::control::sensing::SensorsRead;
use crate::link::message::{OrderKind, flag};
use crate::model::each::Each;
use crate::model::fault::Fault;
use crate::model::generator::Generator;
use crate::model::list::{Motion, PayloadType, RobotHandle, RobotsOf, SensorsOf};
use crate::model::moved::RobotsMovedBy;
use crate::model::payload::Trigger;
use crate::model::robot::Robot;
use crate::model::type_name::TypeName;

use crate::operator::state::InstructionKind;

use super::Mp;
use super::background::is_together;
use super::progress::{AnyProgress, Facts, Progress, Said};

impl Mp<'_> {
    /// **Move**: generates the next states of the robots, step by step, until the generator is done (a motion
    /// without an end of its own: until every ECP has finished); returns the generator.
    ///
    /// Robots that still move then brake: the Move returns at standstill.
    ///
    /// # Errors
    /// The [`Fault`] that ended the motion, at standstill.
    pub fn move_robots<G: Generator>(
        &mut self,
        robots: impl RobotsMovedBy<G, G::Language, G::Robots>,
        sensors: impl SensorsOf<G::Sensors>,
        generator: G,
    ) -> Result<G, Fault> {
        self.run(robots, sensors, generator, 0)
    }

    /// **Move** of one robot, by any generator that an ECP could move it with; returns the generator. Those of several robots
    /// at once are one motion by [`Each`].
    ///
    /// # Errors
    /// The [`Fault`] that ended the motion, at standstill.
    ///
    /// # Example
    /// ```
    /// # use mrroc_core as mrroc;
    /// use mrroc::generator::{Generator, Motion, RobotHandle};
    /// use mrroc::prelude::*;
    ///
    /// /// There and back.
    /// fn to_and_fro<R: Robot>(
    ///     mp: &mut Mp,
    ///     arm: &mut RobotHandle<R>,
    ///     there: impl Generator<Robots = R, Language = Motion, Sensors = (), Order = ()>,
    ///     back: impl Generator<Robots = R, Language = Motion, Sensors = (), Order = ()>,
    /// ) -> Result<(), Fault> {
    ///     mp.move_robot(arm, (), there)?;
    ///     mp.move_robot(arm, (), back)?;
    ///     Ok(())
    /// }
    /// ```
    pub fn move_robot<R, G>(
        &mut self,
        robot: &mut RobotHandle<R>,
        sensors: impl SensorsOf<G::Sensors>,
        generator: G,
    ) -> Result<G, Fault>
    where
        R: Robot,
        G: Generator<Robots = R, Language = Motion, Order = ()>,
    {
        self.move_robots((robot,), sensors, Each::of((generator,))).map(|each| each.motions.0)
    }

    /// The same Move that hands the moving robot over, as [`blend_robots`](Self::blend_robots) does.
    ///
    /// # Errors
    /// The [`Fault`] that ended the motion, at standstill.
    pub fn blend_robot<R, G>(
        &mut self,
        robot: &mut RobotHandle<R>,
        sensors: impl SensorsOf<G::Sensors>,
        generator: G,
    ) -> Result<G, Fault>
    where
        R: Robot,
        G: Generator<Robots = R, Language = Motion, Order = ()>,
    {
        self.blend_robots((robot,), sensors, Each::of((generator,))).map(|each| each.motions.0)
    }

    /// **Move** that hands moving robots over: the next Move, which must name them, starts in the very next
    /// step. Anything else than a Move brakes first.
    ///
    /// # Errors
    /// The [`Fault`] that ended the motion, at standstill.
    pub fn blend_robots<G: Generator>(
        &mut self,
        robots: impl RobotsMovedBy<G, G::Language, G::Robots>,
        sensors: impl SensorsOf<G::Sensors>,
        generator: G,
    ) -> Result<G, Fault> {
        self.run(robots, sensors, generator, flag::BLEND)
    }

    fn run<G: Generator>(
        &mut self,
        mut robots: impl RobotsOf<G::Robots>,
        sensors: impl SensorsOf<G::Sensors>,
        generator: G,
        ending: u32,
    ) -> Result<G, Fault> {
        self.check_handles(&robots, &sensors)?;
        let indices = robots.indices();
        let indices = indices.as_ref();
        let mut progress = Progress::new(generator, robots.images(), sensors)?;
        let outcome = self.move_by(TypeName::of::<G>(), indices, &mut progress, ending);
        self.robots.each_image(indices, &mut |i, words| robots.refresh(i, words))?;
        progress.sensors.store();
        outcome.map(|()| progress.generator)
    }

    fn move_by(
        &mut self,
        by: TypeName,
        indices: &[usize],
        progress: &mut dyn AnyProgress,
        ending: u32,
    ) -> Result<(), Fault> {
        self.instruction(InstructionKind::Move, by, |mp| {
            mp.generate(indices, progress)?;
            mp.end(indices, OrderKind::End, ending)
        })
    }

    /// Eq. 6: START, the first step, then a step of the generator and an exchange, until it is done.
    fn generate(&mut self, indices: &[usize], progress: &mut dyn AnyProgress) -> Result<(), Fault> {
        let Facts { first_uses, next_uses, ends, moves } = progress.facts();
        let wants_state = next_uses.robots || !progress.sensors().places().is_empty();
        let together = is_together(indices.len(), &|i| progress.payload(i));
        let state_flag = if wants_state { flag::WANT_STATE } else { 0 };
        let flags = state_flag | if together { flag::TOGETHER } else { 0 };
        if moves {
            self.jogging.begin_move(indices);
        }
        self.begin_step()?;
        self.take_over(indices)?;
        let handed_over = self.robots.any_handed_over();
        self.start(indices, &|i| progress.payload(i))?;
        if self.learn_states(progress.sensors())? {
            // Nothing moved: a motion that was handed over must not lose a step by it.
            self.keep_unless_late();
        }
        if first_uses.sensors {
            self.read_sensors(progress.sensors())?;
            self.keep_unless_late();
        }
        loop {
            self.begin_step()?;
            let from_rest = progress.is_first() && !handed_over;
            if from_rest && self.background.is_empty() {
                self.clock.count_from_here();
            }
            if self.is_at_rest_on_path()? {
                return self.abort(indices);
            }
            // Other robots' path time counts every period.
            let t = if from_rest { self.clock.first_tick() } else { self.clock.tick(progress.step()) };
            let standing = self.clock.is_standing();
            let said = progress.next(&mut self.robots, indices, t, standing);
            if said.as_ref().is_ok_and(|said| *said != Said::Nothing) {
                self.jogging.see_who_asks();
            }
            match said? {
                // An abort that the motion's own end forestalled is an abort: the program must not go on.
                Said::Done if self.is_ending() => return self.abort(indices),
                Said::Done => return Ok(()),
                Said::Nothing if progress.is_first() => {
                    // Suspended before the first step: there is no order to give yet.
                    self.exchange(indices, OrderKind::Query, flag::WANT_STATE)?;
                    if first_uses.sensors {
                        self.read_sensors(progress.sensors())?;
                    }
                    continue;
                }
                Said::Demands | Said::Nothing => {}
            }
            self.order_readings(progress.sensors());
            self.exchange(indices, OrderKind::Step, flags)?;
            self.collect_on_path(progress.sensors())?;
            if self.finished(indices, ends, &|i| progress.payload(i))? {
                return Ok(());
            }
        }
    }

    /// Orders the readings of a step, and collects them.
    pub(super) fn read_sensors(&mut self, sensors: &mut dyn SensorsRead) -> Result<(), Fault> {
        self.order_readings(sensors);
        self.sensing.collect(sensors, self.host.waiter, self.clock.step())
    }

    /// Collects the readings of a step. Where a sensor gives none, the demands are as sound as they were: robots stop on their
    /// paths.
    fn collect_on_path(&mut self, sensors: &mut dyn SensorsRead) -> Result<(), Fault> {
        match self.sensing.collect(sensors, self.host.waiter, self.clock.step()) {
            Err(fault) if fault.leaves_demands_sound() => {
                self.stops.protect(fault, self.clock.step());
                Ok(())
            }
            collected => collected,
        }
    }

    /// Whether every ECP has finished; in a motion with an end of its own or with tight orders none may first.
    fn finished(
        &mut self,
        indices: &[usize],
        ends: bool,
        payload: &dyn Fn(usize) -> PayloadType,
    ) -> Result<bool, Fault> {
        let all = indices.iter().all(|&index| self.robots[index].reply.is(flag::FINISHED));
        if all && !ends {
            return if self.is_ending() { self.abort(indices).map(|()| true) } else { Ok(true) };
        }
        self.robots.refuse_early(indices, payload, self.clock.step())?;
        Ok(false)
    }

    /// The triggering MP: one instruction of a constant order to all robots, until every ECP has finished.
    pub(crate) fn trigger(&mut self) -> Result<(), Fault> {
        let indices = self.robots.all();
        // What is done is the ECPs' programs' own, and shown by them.
        self.instruction(InstructionKind::Move, TypeName::NONE, |mp| {
            mp.trigger_all(&indices)?;
            mp.end(&indices, OrderKind::End, 0)
        })
    }

    fn trigger_all(&mut self, indices: &[usize]) -> Result<(), Fault> {
        let payload = PayloadType::of::<Trigger>();
        self.begin_step()?;
        self.start(indices, &|_| payload)?;
        loop {
            self.begin_step()?;
            if self.is_at_rest_on_path()? {
                return self.abort(indices);
            }
            for &index in indices {
                self.robots[index].order.header.len = 0;
            }
            self.exchange(indices, OrderKind::Step, 0)?;
            if self.finished(indices, false, &|_| payload)? {
                return Ok(());
            }
        }
    }
}
