//! The demands of a robot, step by step: those that were accepted, and what replaces those that are missing.
//!
//! In: demands of the ECP, or none; the braking law of the last order. Out: one accepted demand per step. A robot that moves
//! together with others stays with them, on the twist of the last step; where a limit or the kinematics forbids it, it goes on
//! in joint space.

use core::time::Duration;

use crate::control::guarded::guarded;
use crate::link::message::{Message, flag};
use crate::model::demand::{Coordinates, Demand};
use crate::model::fault::{Fault, FaultKind};
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::safety::braking::{Braking, BrakingLaw};
use crate::safety::common_twist::{Bridging, TwistBraking};
use crate::safety::limits::{AcceptedDemand, Acceptor, Before};
use crate::safety::stopping::{detection_time, missed_step_budget, together_budget};

/// What a robot does.
pub(super) enum Mode<J> {
    /// No demand is due.
    Holding,
    /// A demand is due in every step; those of so many steps are missing.
    Moving { missed: u32 },
    /// Braking to a standstill.
    Braking(Braking<J>),
    /// The same on the twist of robots that move together.
    OnTwist(TwistBraking),
    /// The drives are without power and have their brakes applied: one gave up, or a fault stop is over.
    Off,
}

/// What was known before a demand was accepted for the step that is about to begin.
struct Undone<J> {
    /// Whether that is known, and the demand may be taken back.
    is_kept: bool,
    /// The step of the demand, of a robot that moves together with others.
    step: Option<u64>,
    acceptor: Before<J>,
    /// Demands that were missing, of a robot that moved.
    missed: Option<u32>,
    together: Option<BrakingLaw>,
}

/// What became of a demand.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum DemandOutcome {
    /// It is that of the next step.
    InStep,
    /// It was for another one, and tells where the path is.
    OutOfStep,
}

/// The demands of a robot.
pub(super) struct DemandedPath<R: Robot> {
    pub acceptor: Acceptor<R>,
    pub mode: Mode<R::Joints>,
    /// Accepted for the step that is about to begin.
    pub next: Option<AcceptedDemand<R>>,
    /// How to take that back, of a robot that moves together with others.
    undone: Undone<R::Joints>,
    /// How the robot brakes with those that it moves together with.
    together: Option<BrakingLaw>,
    /// The twist on which it does; known once a demand is missing.
    bridging: Option<Bridging>,
    /// The tool of a robot that has just been set up, `X_FE`.
    first_tool: Pose,
    /// Length of a step.
    period: Duration,
    /// The same \[s\].
    pub seconds: f64,
    /// Missing demands that are bridged, of a robot that moves by itself.
    budget: u32,
    /// The same, of a robot that moves together with others.
    budget_together: u32,
    /// Whether a demand of another step has come that has not been followed yet.
    heard: bool,
    /// By how many steps the demands of this motion were early when it began.
    lead: i64,
    /// Whether it holds in a motion, which goes on with the next demand.
    is_paused: bool,
}

impl<R: Robot> DemandedPath<R> {
    /// A robot that holds `position`, in steps of `period`.
    pub fn new(robot: R, tool: Pose, position: R::Joints, period: Duration) -> Self {
        let acceptor = Acceptor::new(robot, tool, position, detection_time(period));
        DemandedPath {
            undone: Undone {
                is_kept: false,
                step: None,
                acceptor: acceptor.before(),
                missed: None,
                together: None,
            },
            acceptor,
            mode: Mode::Holding,
            next: None,
            together: None,
            bridging: None,
            first_tool: tool,
            period,
            seconds: period.as_secs_f64(),
            budget: missed_step_budget(period),
            budget_together: together_budget(period),
            heard: false,
            lead: 0,
            is_paused: false,
        }
    }

    /// Holds a position, as a robot does that has just been set up there.
    pub fn begin_at(&mut self, position: R::Joints) {
        let robot = self.acceptor.robot().clone();
        *self = DemandedPath::new(robot, self.first_tool, position, self.period);
    }

    pub const fn is_moving(&self) -> bool {
        matches!(self.mode, Mode::Moving { .. })
    }

    pub const fn is_off(&self) -> bool {
        matches!(self.mode, Mode::Off)
    }

    /// Whether it holds where its path ends.
    pub fn is_at_its_end(&self) -> bool {
        matches!(self.mode, Mode::Holding) && self.acceptor.is_at_its_end()
    }

    /// Accepts a demand, which `request` brings, for the step that is about to begin, with the law by which the robot brakes
    /// together with others.
    ///
    /// # Errors
    /// The first limit that it breaks; nothing is changed then.
    fn accept(
        &mut self,
        demand: &Demand<R>,
        request: &Message,
        together: Option<BrakingLaw>,
    ) -> Result<(), Fault> {
        let header = &request.header;
        let missed = match self.mode {
            Mode::Moving { missed } => Some(missed),
            Mode::Holding | Mode::Braking(_) | Mode::OnTwist(_) | Mode::Off => None,
        };
        // That of an earlier demand is over with the step that the demand was for.
        self.undone.is_kept = together.is_some();
        self.undone.step = together.map(|_| header.step);
        if self.undone.is_kept {
            self.acceptor.keep(&mut self.undone.acceptor);
            self.undone.missed = missed;
            self.undone.together = self.together;
        }
        // A late demand's own count of periods says how far its path has come; the steps before it were bridged.
        let period = self.seconds;
        let dt = header.dt / header.duration * period;
        // Periods that the MP left out all robots have missed.
        let all_missed = request.is(flag::TOGETHER) && header.duration > 1.5 * period;
        self.acceptor.slow_tool(request.is(flag::REDUCED));
        let accepted = match all_missed {
            true => self.acceptor.rejoin(demand, dt, period),
            false => self.acceptor.accept(demand, dt, period),
        };
        let first = request.is(flag::FIRST) && !self.is_moving();
        self.next = Some(accepted.map_err(|fault| if first { fault.of_first_demand() } else { fault })?);
        self.move_together(together);
        self.mode = Mode::Moving { missed: 0 };
        (self.heard, self.is_paused) = (false, false);
        Ok(())
    }

    /// Takes a demand, which `request` brings, where step `due` is the next one: for that step, or for what it says of the path.
    ///
    /// # Errors
    /// The first limit that it breaks; nothing is changed then.
    pub fn take(&mut self, demand: &Demand<R>, request: &Message, due: u64) -> Result<DemandOutcome, Fault> {
        let step = request.header.step;
        let together = law_together(demand, request);
        let alone = together.is_none() && self.goes_on_out_of_step();
        if alone && self.is_moving() {
            let behind = self.behind(step, due);
            if behind == -1 && self.next.is_none() {
                self.accept(demand, request, together)?;
                return Ok(DemandOutcome::InStep);
            }
            if behind.unsigned_abs() > u64::from(self.budget) {
                self.acceptor.note_late(demand)?;
            } else {
                self.hear(demand, request, behind)?;
            }
            return Ok(DemandOutcome::OutOfStep);
        }
        self.lead = 0;
        // A step that is over has been bridged, and its demand is never made up for.
        if step < due {
            self.note_late(demand, request, due, together)?;
            return Ok(DemandOutcome::OutOfStep);
        }
        self.accept(demand, request, together)?;
        if alone {
            self.lead = (step - due).cast_signed();
        }
        Ok(DemandOutcome::InStep)
    }

    /// Whether it goes by demands of other steps than the next one.
    fn goes_on_out_of_step(&self) -> bool {
        self.together.is_none() && self.acceptor.goes_on_out_of_step()
    }

    /// Whether there is nothing that another demand could say: a step has one demand, and one that came twice, or again in place
    /// of another, would be a step of its own.
    pub fn is_settled(&self) -> bool {
        self.next.is_some() && !(self.is_moving() && self.goes_on_out_of_step())
    }

    /// How many steps a demand of `step` is behind the state that was accepted last, where `due` is the next step.
    fn behind(&self, step: u64, due: u64) -> i64 {
        let accepted = due.cast_signed() - i64::from(self.next.is_none());
        accepted.saturating_sub(step.cast_signed().saturating_sub(self.lead))
    }

    /// Goes by a demand of another step.
    ///
    /// # Errors
    /// As of [`take`](Self::take).
    fn hear(&mut self, demand: &Demand<R>, request: &Message, behind: i64) -> Result<(), Fault> {
        let header = &request.header;
        let dt = header.dt / header.duration * self.seconds;
        self.acceptor.slow_tool(request.is(flag::REDUCED));
        self.heard |= self.acceptor.hear(demand, dt, self.seconds, behind as f64)?;
        Ok(())
    }

    /// A stop comes before the step that a demand was accepted for, of a robot that moves together with others: one of them
    /// may have no demand for that step, so it goes for none. All brake from the step before, on the twist that led to it.
    fn take_back(&mut self) {
        let undone = &mut self.undone;
        let is_kept = core::mem::take(&mut undone.is_kept);
        if !is_kept || self.next.is_none() {
            return;
        }
        self.next = None;
        self.acceptor.take_back(&undone.acceptor);
        self.together = undone.together;
        self.bridging = None;
        self.mode = undone.missed.map_or(Mode::Holding, |missed| Mode::Moving { missed });
    }

    /// Notes a demand that is too late for its step; step `due` is the next one. A motion that it begins, or goes on with after
    /// path time stood still, has done so all the same: the robot has missed the steps in which it stood.
    ///
    /// # Errors
    /// What is wrong with the demand itself.
    fn note_late(
        &mut self,
        demand: &Demand<R>,
        request: &Message,
        due: u64,
        together: Option<BrakingLaw>,
    ) -> Result<(), Fault> {
        let first = request.is(flag::FIRST);
        let goes_on = self.is_paused && request.header.dt > 0.0;
        let begins = (first || goes_on) && matches!(self.mode, Mode::Holding);
        if !begins {
            return self.acceptor.note_late(demand);
        }
        let missed = due.saturating_sub(request.header.step);
        let alone = together.is_none() && self.acceptor.goes_on_out_of_step();
        self.move_together(together);
        let period = self.seconds;
        let begun = self.acceptor.begin_late(demand, period, missed as f64, self.together.is_some());
        begun.map_err(|fault| if first { fault.of_first_demand() } else { fault })?;
        self.mode = Mode::Moving { missed: u32::try_from(missed).unwrap_or(u32::MAX) };
        if alone && missed <= u64::from(self.budget) {
            self.hear(demand, request, self.behind(request.header.step, due))?;
        }
        Ok(())
    }

    /// Keeps how the robot brakes with those that it moves together with.
    fn move_together(&mut self, law: Option<BrakingLaw>) {
        self.bridging = None;
        self.together = law;
    }

    /// Counts the demand that is missing in the step that begins, if one is. One of another step that has come since the last
    /// one is followed as far as it tells the path.
    ///
    /// # Errors
    /// `PeerLost` when more are missing than are bridged.
    pub fn count_missing(&mut self) -> Result<(), Fault> {
        let budget = self.missed_step_budget();
        if self.next.is_none() && self.is_moving() && core::mem::take(&mut self.heard) {
            self.next = self.acceptor.go_on_along_path(self.seconds);
            if self.next.is_some() {
                self.mode = Mode::Moving { missed: 0 };
                return Ok(());
            }
        }
        match &mut self.mode {
            Mode::Moving { missed } if self.next.is_none() => {
                *missed = missed.saturating_add(1);
                if *missed > budget {
                    return Err(Fault::new(FaultKind::PeerLost).text("no demand from the ECP"));
                }
                Ok(())
            }
            Mode::Moving { .. } | Mode::Holding | Mode::Braking(_) | Mode::OnTwist(_) | Mode::Off => Ok(()),
        }
    }

    /// Missing demands that are bridged.
    fn missed_step_budget(&self) -> u32 {
        if self.together.is_some() { self.budget_together } else { self.budget }
    }

    /// The demand of the step that begins: the one that came, or what replaces it.
    pub fn next_demand(&mut self) -> AcceptedDemand<R> {
        // A demand accepted before a stop is still the state that the stop begins at, unless that took it back.
        if let Some(next) = self.next.take() {
            self.undone.is_kept = false;
            return next;
        }
        let period = self.seconds;
        match &mut self.mode {
            Mode::Holding | Mode::Off => self.hold(period),
            Mode::Moving { .. } => self.bridge(period),
            Mode::OnTwist(braking) => match braking.advance(period) {
                Some(displacement) => self.slow_down(&displacement, period),
                None => self.hold(period),
            },
            Mode::Braking(braking) if braking.is_over() => self.hold(period),
            Mode::Braking(braking) => self.acceptor.brake(braking, period),
        }
    }

    /// What replaces a demand that is missing: along the twist, or at the joints' velocity.
    fn bridge(&mut self, period: f64) -> AcceptedDemand<R> {
        if self.together.is_some() && self.acceptor.stands() {
            return self.acceptor.stand_by(period);
        }
        if let Some(bridging) = self.learn_bridging(period) {
            // Where a limit forbids that the path goes on as it changed last, its velocity is held.
            for next in [bridging, bridging.steady()].map(Bridging::advanced) {
                if let Ok(Ok(accepted)) = guarded(|| self.acceptor.go_on(&next.twist.part(1.0), period)) {
                    self.bridging = Some(next);
                    return accepted;
                }
            }
        }
        self.together = None;
        self.acceptor.go_on_along_path(period).unwrap_or_else(|| self.acceptor.extrapolate(period))
    }

    /// The next state of the braking to a standstill on the twist, displaced by `D` in the world.
    #[allow(non_snake_case)]
    fn slow_down(&mut self, D: &Pose, period: f64) -> AcceptedDemand<R> {
        if let Ok(Ok(accepted)) = guarded(|| self.acceptor.slow_down(D, period)) {
            return accepted;
        }
        let mut braking = self.acceptor.braking();
        let accepted = self.acceptor.brake(&mut braking, period);
        self.mode = Mode::Braking(braking);
        accepted
    }

    /// The robot stays where it was demanded last, and comes there first where it is not.
    fn hold(&mut self, period: f64) -> AcceptedDemand<R> {
        let held = self.acceptor.hold(period);
        self.mode = match held {
            Ok(_) => Mode::Holding,
            Err(_) => Mode::Braking(self.acceptor.braking()),
        };
        held.unwrap_or_else(|_| self.next_demand())
    }

    /// A motion ends, or its path time stands still: a robot that may hold does, so that it is where the path is.
    pub fn come_to_hold(&mut self) {
        self.is_paused |= self.is_moving();
        match self.mode {
            Mode::Moving { .. } if self.acceptor.can_hold(self.seconds) => {
                self.mode = Mode::Holding;
            }
            Mode::Moving { .. } => self.mode = self.braking_to_rest(),
            Mode::Holding | Mode::Braking(_) | Mode::OnTwist(_) | Mode::Off => {}
        }
    }

    /// A robot that moves, or is not where its path ends, comes to a standstill.
    pub fn brake(&mut self) {
        self.take_back();
        match self.mode {
            Mode::Moving { .. } => self.mode = self.braking_to_rest(),
            Mode::Holding if !self.acceptor.is_at_its_end() => self.mode = self.braking_to_rest(),
            Mode::Holding | Mode::Braking(_) | Mode::OnTwist(_) | Mode::Off => {}
        }
    }

    /// A stop comes because a robot that this one moves together with has not answered the order of `step`. Whether that order has
    /// come to it is not known, so all brake as they would without it: from the twist, and by the law, of the step before, after
    /// as many steps as a robot bridges that has not got it.
    pub fn brake_without(&mut self, step: u64) {
        let period = self.seconds;
        if let Mode::Moving { missed } = self.mode
            && self.next.is_none()
            && self.undone.step == Some(step)
            && self.undone.missed == Some(0)
            && let Some(law) = self.undone.together
            && let Ok(before) = guarded(|| self.acceptor.bridging_before(&self.undone.acceptor, period))
        {
            self.together = Some(law);
            let bridged = missed.saturating_add(1).min(self.budget_together);
            self.bridging = Some((0..bridged).fold(before, |bridging, _| bridging.advanced()));
        }
        self.brake();
    }

    /// The braking to a standstill from the state demanded last.
    fn braking_to_rest(&mut self) -> Mode<R::Joints> {
        let period = self.seconds;
        // Where the law lets all robots stand in the next step, none goes on for the others' sake.
        if let Some(law) = self.together
            && let Some(bridging) = self.learn_bridging(period)
            && let law = bridging.eased(law)
            && !law.stops_at_once(period)
        {
            return Mode::OnTwist(TwistBraking::new(bridging.twist, law));
        }
        if self.acceptor.stop_at_once(period) {
            return Mode::Holding;
        }
        Mode::Braking(self.acceptor.braking())
    }

    /// How a robot that moves together with others has gone on since the last demand.
    fn learn_bridging(&mut self, period: f64) -> Option<Bridging> {
        self.together?;
        if self.bridging.is_none() {
            self.bridging = guarded(|| self.acceptor.bridging(period)).ok();
        }
        self.bridging
    }

    /// Looks at how much of the limits the twist takes on which the robot moves together with others.
    pub fn look_along_twist(&mut self) {
        if self.is_together() {
            // A kinematics that panics on the path ahead does so again where the robot is to go there.
            let _ = guarded(|| self.acceptor.look_along_twist(self.seconds));
        } else {
            self.acceptor.leave_twist();
        }
    }

    /// Whether the robot goes on, and brakes, with those that it moves together with.
    pub const fn is_together(&self) -> bool {
        self.together.is_some()
    }
}

/// How a robot with this demand brakes with those that it moves together with.
fn law_together<R: Robot>(demand: &Demand<R>, request: &Message) -> Option<BrakingLaw> {
    match demand.coordinates {
        // Joints have no twist.
        Coordinates::Hold | Coordinates::Joints(_) => None,
        Coordinates::Pose(_) | Coordinates::Displacement(_) => {
            request.is(flag::TOGETHER).then_some(request.header.law)
        }
    }
}
