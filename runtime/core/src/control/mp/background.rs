//! Motions in the background: the program has started them, and they go on while its later instructions run.
//!
//! In: a generator, the path time of each step. Out: in every step in which the MP exchanges messages with any robot, the
//! orders of these robots as well. They are sent and collected together with those of the instruction.
//!
//! ```text
//!            start_robots          done, every ECP finished, end_robot
//!   (rest) ──────────────▶ Moving ─────────────────────────────────────▶ Ending ──▶ Over
//!                             │ the next Move, or start_robots, that names the robots
//!                             └────────────────────────────────────────────────────▶ theirs, moving (as after a blend)
//! ```
//!
//! There is one path time for all robots of a cell, so Suspend, the operator's speed, Abort and protective stops slow these
//! robots as they slow the others. Abort, any stop and the end of the program end their motions.

use crate::link::message::{OrderKind, flag};
use crate::model::each::Each;
use crate::model::fault::Fault;
use crate::model::generator::Generator;
use crate::model::image::RobotImage;
use crate::model::instruction::Instruction;
use crate::model::list::{Motion, Owner, PayloadType, RobotHandle};
use crate::model::moved::RobotsMovedBy;
use crate::model::robot::Robot;
use crate::model::type_name::TypeName;
use crate::model::wire::Wire;
use crate::operator::state::InstructionKind;
use crate::safety::braking::BrakingLaw;

use super::Mp;
use super::clock::StepClock;
use super::progress::{AnyProgress, Progress, Said};
use super::robots::{Gathered, RobotPorts};

/// All motions in the background, and those that are over.
#[derive(Default)]
pub(super) struct Background {
    motions: Vec<Started>,
}

/// Where in its life a motion is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    Moving,
    /// It has come to its end: its robots brake.
    Ending,
    Over,
}

/// One of them.
struct Started {
    progress: Box<dyn AnyProgress>,
    /// The instruction that has started it.
    instruction: Option<Instruction>,
    /// Its robots.
    indices: Vec<usize>,
    /// Whether it took its robots over moving.
    goes_on: bool,
    /// The step in which they had their last orders.
    served: u64,
    /// Whether they had orders when that was asked last.
    was_due: bool,
    flags: u32,
    /// How fast its robots may slow down together.
    law: BrakingLaw,
    stage: Stage,
}

impl Started {
    /// Whether its robots are to have orders in this step: then they will have had them.
    fn is_due(&mut self, step: u64) -> bool {
        self.was_due = self.stage != Stage::Over && self.served != step;
        self.served = step;
        self.was_due
    }

    /// The orders of this step, written into the robots' messages; what kind they are, and with which flags.
    fn order(&mut self, robots: &mut RobotPorts, clock: &StepClock) -> Result<(OrderKind, u32), Fault> {
        if self.stage != Stage::Moving {
            return Ok((OrderKind::End, flag::WANT_STATE));
        }
        let progress = &mut self.progress;
        let is_first = progress.is_first();
        // Robots that stood cannot have skipped a period of this motion.
        let t = if is_first && !self.goes_on { clock.first_tick() } else { clock.tick(progress.step()) };
        match progress.next(robots, &self.indices, t, clock.is_standing())? {
            Said::Done => {
                self.stage = Stage::Ending;
                Ok((OrderKind::End, flag::WANT_STATE))
            }
            // Suspended before the first step: there is no order to give yet.
            Said::Nothing if is_first => Ok((OrderKind::Query, flag::WANT_STATE)),
            Said::Nothing | Said::Demands => Ok((OrderKind::Step, self.flags)),
        }
    }

    /// What the replies of its robots say about it.
    fn hear(&mut self, robots: &RobotPorts, step: u64) -> Result<(), Fault> {
        let indices = &self.indices;
        match self.stage {
            Stage::Ending if robots.all_say(indices, flag::ENDED) => self.stage = Stage::Over,
            Stage::Moving if !self.progress.facts().ends && robots.all_say(indices, flag::FINISHED) => {
                self.stage = Stage::Ending;
            }
            Stage::Moving => return robots.refuse_early(indices, &|i| self.progress.payload(i), step),
            Stage::Ending | Stage::Over => {}
        }
        Ok(())
    }
}

impl Background {
    /// The motions that are not over.
    fn moving(&self) -> impl Iterator<Item = &Started> {
        self.motions.iter().filter(|motion| motion.stage != Stage::Over)
    }

    /// Whether no robot moves in the background.
    pub fn is_empty(&self) -> bool {
        self.moving().next().is_none()
    }

    /// Whether a robot moves in the background.
    pub fn has(&self, index: usize) -> bool {
        self.moving().any(|motion| motion.indices.contains(&index))
    }

    /// Whether robots have had their orders of a step.
    pub fn is_served(&self, step: u64) -> bool {
        self.moving().any(|motion| motion.served == step)
    }

    /// Forgets all motions; returns their robots.
    pub fn clear(&mut self) -> Vec<usize> {
        let indices = self.moving().flat_map(|motion| motion.indices.iter().copied()).collect();
        self.motions.clear();
        indices
    }

    /// Takes out the motions of which any robot fits; returns all their robots.
    fn take(&mut self, fits: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut taken = Vec::new();
        self.motions.retain(|motion| {
            let is_over = motion.stage == Stage::Over;
            let fits = motion.indices.iter().any(|&index| fits(index));
            if fits && !is_over {
                taken.extend_from_slice(&motion.indices);
            }
            !fits && !is_over
        });
        taken
    }

    /// Lends the motions to an exchange, in which their robots have their orders of the step as well; none where that does
    /// not go with the order of the instruction: after a stop no robot moves, and after the END of a blend the orders of
    /// the next instruction are to come.
    pub fn lend(&mut self, kind: OrderKind, flags: u32) -> Background {
        let goes_with = match kind {
            OrderKind::Stop | OrderKind::Reset => false,
            OrderKind::End => flags & flag::BLEND == 0,
            OrderKind::Query | OrderKind::Start | OrderKind::Step | OrderKind::Abort | OrderKind::Brake => {
                true
            }
        };
        if goes_with { core::mem::take(self) } else { Background::default() }
    }

    /// Takes back what was lent.
    pub fn take_back(&mut self, lent: Background) {
        if self.motions.is_empty() {
            *self = lent;
        }
    }

    /// Sends the robots that had none yet the orders of a step.
    pub fn send(&mut self, mp: &mut Mp<'_>) -> Result<(), Fault> {
        let step = mp.clock.step();
        for motion in self.motions.iter_mut().filter_map(|motion| motion.is_due(step).then_some(motion)) {
            let ordered = motion.order(&mut mp.robots, &mp.clock);
            let (kind, flags) = ordered.map_err(|fault| fault.in_instruction(motion.instruction))?;
            let law = motion.law;
            for &index in &motion.indices {
                mp.send(index, kind, flags, law);
            }
        }
        Ok(())
    }

    /// Collects their replies.
    pub fn collect(&mut self, mp: &mut Mp<'_>, gathered: &mut Gathered) -> Result<(), Fault> {
        for motion in self.motions.iter_mut().filter(|motion| motion.was_due) {
            mp.await_answers(&motion.indices)?;
            gathered.law = BrakingLaw::UNLIMITED;
            mp.gather(&motion.indices, gathered);
            motion.law = gathered.law;
            match gathered.first.take() {
                None => {
                    let heard = motion.hear(&mp.robots, mp.clock.step());
                    heard.map_err(|fault| fault.in_instruction(motion.instruction))?;
                }
                Some(fault) => {
                    let is_its = |&index: &usize| fault.robot() == Some(mp.robots[index].facts.name);
                    let is_its = motion.indices.iter().any(is_its);
                    let instruction = if is_its { motion.instruction } else { None };
                    gathered.first = Some(fault.in_instruction(instruction));
                }
            }
        }
        Ok(())
    }
}

impl Mp<'_> {
    /// **Move in the background**: starts a motion and returns at once. The robots go on with it while the program's later
    /// instructions move other robots, or wait.
    ///
    /// A later Move, or `start_robots`, that names these robots (all of one motion together) takes them over as they move,
    /// as after [`blend_robots`](Self::blend_robots); [`end_robot`](Self::end_robot) brings them to rest first. A generator
    /// that is done leaves them at rest. A Wait may name them: it reads their states and does not stop them.
    ///
    /// Suspend and the operator's speed act on all robots alike. An Abort, any stop and the end of the program end this motion
    /// too. Between two instructions the program must not compute for longer than an EDP bridges missing demands (20 ms),
    /// or these robots stop with `PeerLost`, and the cell with them.
    ///
    /// A generator that needs sensors runs in the ECP of its robot: start it by an order of loose cooperation.
    ///
    /// # Errors
    /// The [`Fault`] of the first step, at standstill.
    ///
    /// # Example
    /// ```
    /// # use mrroc_core as mrroc;
    /// use mrroc::generator::{Generator, Motion, RobotHandle};
    /// use mrroc::prelude::*;
    ///
    /// /// The belt runs while the arm goes there and back.
    /// fn beside_a_belt<A: Robot, B: Robot>(
    ///     mp: &mut Mp,
    ///     (arm, belt): (&mut RobotHandle<A>, &mut RobotHandle<B>),
    ///     run: impl Generator<Robots = B, Language = Motion, Sensors = (), Order = ()> + 'static,
    ///     there: impl Generator<Robots = A, Language = Motion, Sensors = (), Order = ()>,
    ///     back: impl Generator<Robots = A, Language = Motion, Sensors = (), Order = ()>,
    /// ) -> Result<(), Fault> {
    ///     mp.start_robot(belt, run)?;
    ///     mp.move_robot(arm, (), there)?;
    ///     mp.move_robot(arm, (), back)?;
    ///     mp.end_robot(belt)
    /// }
    /// ```
    pub fn start_robots<G>(
        &mut self,
        robots: impl RobotsMovedBy<G, G::Language, G::Robots>,
        generator: G,
    ) -> Result<(), Fault>
    where
        G: Generator<Sensors = ()> + 'static,
    {
        self.check_handles::<G::Robots, ()>(&robots, &())?;
        let progress = Box::new(Progress::new(generator, robots.images(), ())?);
        self.start_by(TypeName::of::<G>(), progress, robots.indices().as_ref().to_vec())
    }

    /// **Move in the background** of one robot, by any generator without sensors that an ECP could move it with: see
    /// [`start_robots`](Self::start_robots).
    ///
    /// # Errors
    /// The [`Fault`] of the first step, at standstill.
    pub fn start_robot<R, G>(&mut self, robot: &mut RobotHandle<R>, generator: G) -> Result<(), Fault>
    where
        R: Robot,
        G: Generator<Robots = R, Language = Motion, Sensors = (), Order = ()> + 'static,
    {
        self.start_robots((robot,), Each::of((generator,)))
    }

    /// Ends the motion in the background that moves a robot: all robots of that motion brake, and this returns when they
    /// stand. Without such a motion, or if it is over, there is nothing to do.
    ///
    /// # Errors
    /// The [`Fault`] that stopped the cell meanwhile.
    pub fn end_robot<R: Robot>(&mut self, robot: &mut RobotHandle<R>) -> Result<(), Fault> {
        let stranger = self.robots.owner.not_its_own(robot.owner, robot.name);
        Owner::refuse("robot", stranger)?;
        let index = robot.index;
        let outcome = self.instruction(InstructionKind::Move, TypeName::named("end_robot"), |mp| {
            mp.settle()?;
            let indices = mp.take_from_background(|other| other == index)?;
            if indices.is_empty() { Ok(()) } else { mp.end(&indices, OrderKind::End, 0) }
        });
        self.robots.each_image(&[index], &mut |_, words| {
            robot.image = RobotImage::get(words)?;
            Ok(())
        })?;
        outcome
    }

    /// Whether a motion in the background still moves a robot: it was started, and is neither over nor ended.
    ///
    /// It changes in steps only: a program that waits for the end looks again after each Wait or Move.
    #[must_use]
    pub fn is_in_background<R: Robot>(&self, robot: &RobotHandle<R>) -> bool {
        self.robots.owner.not_its_own(robot.owner, robot.name).is_none() && self.background.has(robot.index)
    }

    fn start_by(
        &mut self,
        by: TypeName,
        progress: Box<dyn AnyProgress>,
        indices: Vec<usize>,
    ) -> Result<(), Fault> {
        self.instruction(InstructionKind::Move, by, |mp| mp.start_in_background(progress, indices))
    }

    fn start_in_background(
        &mut self,
        progress: Box<dyn AnyProgress>,
        indices: Vec<usize>,
    ) -> Result<(), Fault> {
        let payload = |i| progress.payload(i);
        let together = is_together(indices.len(), &payload);
        let flags = flag::WANT_STATE | if together { flag::TOGETHER } else { 0 };
        self.begin_step()?;
        self.take_over(&indices)?;
        let goes_on = self.robots.any_handed_over();
        self.start(&indices, &payload)?;
        self.begin_step()?;
        let law = self.robots.law;
        let (served, was_due, stage) = (self.clock.step() - 1, false, Stage::Moving);
        let instruction = self.operating.instruction();
        let started = Started { progress, instruction, indices, goes_on, served, was_due, flags, law, stage };
        self.background.motions.push(started);
        self.exchange(&[], OrderKind::Query, 0)?;
        self.keep_unless_late();
        Ok(())
    }

    /// Robots that move in the background are the next instruction's from now on, as they move.
    ///
    /// # Errors
    /// `Program` when the instruction names only some of the robots of a motion.
    pub(super) fn take_over(&mut self, indices: &[usize]) -> Result<(), Fault> {
        let named = |index| indices.contains(&index);
        for motion in self.background.moving() {
            let (ours, left): (Vec<usize>, Vec<usize>) =
                motion.indices.iter().copied().partition(|&i| named(i));
            if let (Some(&ours), Some(&left)) = (ours.first(), left.first()) {
                let (ours, left) = (self.robots[ours].facts.name, self.robots[left].facts.name);
                let text = format!(
                    "`{ours}` and `{left}` move in the background by one generator: name both, or end that motion by `end_robot`"
                );
                return Err(Fault::thrown(&text));
            }
        }
        let taken = self.take_from_background(named)?;
        if taken.is_empty() { Ok(()) } else { self.end(&taken, OrderKind::End, flag::BLEND) }
    }

    /// Takes motions out of the background, in a step in which their robots have had no order.
    fn take_from_background(&mut self, fits: impl Fn(usize) -> bool) -> Result<Vec<usize>, Fault> {
        let step = self.clock.step();
        let fit = |motion: &Started| motion.indices.iter().any(|&index| fits(index));
        if self.background.moving().any(|motion| motion.served == step && fit(motion)) {
            self.clock.spend();
            self.begin_step()?;
        }
        Ok(self.background.take(fits))
    }

    /// All robots that move in the background come to rest on their paths, for an Abort or a protective stop that came when
    /// the instruction was over.
    ///
    /// # Errors
    /// Always: the Abort, or the cause of the stop.
    pub(super) fn rest_background(&mut self) -> Result<(), Fault> {
        loop {
            self.begin_step()?;
            if self.is_at_rest_on_path()? {
                return self.abort(&[]);
            }
            self.exchange(&[], OrderKind::Query, 0)?;
        }
    }

    /// The program is over: what it left moving in the background brakes.
    pub(super) fn end_background(&mut self) -> Result<(), Fault> {
        let indices = self.take_from_background(|_| true)?;
        if indices.is_empty() { Ok(()) } else { self.end(&indices, OrderKind::End, 0) }
    }
}

/// Whether robots are told together what none of them may leave.
pub(super) fn is_together(robots: usize, payload: &dyn Fn(usize) -> PayloadType) -> bool {
    robots > 1 && (0..robots).all(|i| payload(i).tight)
}
