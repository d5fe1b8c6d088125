//! Opening, ending and stopping instructions: START, END, Abort, Brake and Stop of the MP.
//!
//! Each is an exchange that is repeated, step by step, until every robot is where it should be.

use crate::link::message::{OrderKind, flag};
use crate::model::fault::{Fault, FaultKind};
use crate::model::list::PayloadType;
use crate::safety::latch::Event;

use super::Mp;
use super::robots::RobotPort;

impl Mp<'_> {
    /// Opens an instruction: every robot acknowledges the type of its orders and reports a fresh state, or
    /// none moves.
    pub(super) fn start(
        &mut self,
        indices: &[usize],
        payload: &dyn Fn(usize) -> PayloadType,
    ) -> Result<(), Fault> {
        self.refuse_tight(indices, payload)?;
        self.robots.ordinal += 1;
        let ordinal = self.robots.ordinal;
        let left_out = |(index, robot): &(usize, &RobotPort)| robot.handed_over && !indices.contains(index);
        if let Some((_, robot)) = self.robots.iter().enumerate().find(left_out) {
            let text =
                format!("`{}` was handed over moving: the Move after a blend must name it", robot.facts.name);
            return Err(Fault::thrown(&text));
        }
        let goes_on = self.robots.take_handed_over();
        if !goes_on && self.background.is_empty() {
            self.clock.start(self.wanted_rate());
        }
        for (i, &index) in indices.iter().enumerate() {
            let robot = &mut self.robots[index];
            robot.name_again();
            robot.payload = payload(i);
            robot.instruction = ordinal;
            robot.order.header.payload = robot.payload.id;
            robot.order.header.len = 0;
        }
        let started = self.exchange(indices, OrderKind::Start, flag::WANT_STATE).map_err(|fault| {
            let ordered = indices
                .iter()
                .enumerate()
                .find(|(_, index)| fault.process() == Some(self.robots[**index].process()));
            if let Some((i, _)) = ordered.filter(|_| fault.kind() == FaultKind::PayloadMismatch) {
                let text = format!("{}, the MP orders `{}`", fault.message(), payload(i).name);
                return fault.text(&text);
            }
            fault
        });
        // The first orders go out in the same step, unless robots that stand could not be on their way in it.
        if goes_on {
            self.clock.keep();
        } else {
            self.keep_unless_late();
        }
        started
    }

    /// Ends an instruction: repeated until every ECP has left it, at standstill.
    pub(super) fn end(&mut self, indices: &[usize], kind: OrderKind, ending: u32) -> Result<(), Fault> {
        if ending == flag::BLEND {
            // One END in the step that the next motion starts in; its START comes in the same step.
            self.begin_step()?;
            self.exchange(indices, kind, flag::WANT_STATE | flag::BLEND)?;
            self.clock.keep();
            if self.robots.all_say(indices, flag::ENDED) {
                for &index in indices {
                    self.robots[index].handed_over = true;
                }
                return Ok(());
            }
            // One of them is in its braking tail: then all brake, from this step on.
        }
        loop {
            self.begin_step()?;
            let aborted = if kind == OrderKind::Abort { flag::ABORTED } else { 0 };
            self.exchange(indices, kind, flag::WANT_STATE | aborted)?;
            if self.robots.all_say(indices, flag::ENDED) {
                // Nothing moved in this step: the next instruction may begin in it.
                self.clock.keep();
                return Ok(());
            }
        }
    }

    /// The end that the operator or a guard wants, at standstill on the path: of the instruction and of all motions in the
    /// background.
    pub(super) fn abort(&mut self, indices: &[usize]) -> Result<(), Fault> {
        let fault = self.ending();
        if self.background.is_served(self.clock.step()) {
            // Its robots have had their orders of this step: what ends them comes in the next one.
            self.clock.spend();
        }
        let mut all = self.background.clear();
        all.extend_from_slice(indices);
        self.end(&all, OrderKind::Abort, 0)?;
        Err(fault)
    }

    /// Robots that a blend left moving come to a standstill.
    pub(super) fn settle(&mut self) -> Result<(), Fault> {
        if self.robots.take_handed_over() {
            let mut indices = self.robots.all();
            indices.retain(|&index| !self.background.has(index));
            loop {
                self.begin_step()?;
                self.exchange(&indices, OrderKind::Brake, flag::WANT_STATE)?;
                if self.robots.all_say(&indices, flag::STANDSTILL) {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Holds until the drives of every robot know where it is.
    pub(super) fn home(&mut self) -> Result<(), Fault> {
        // There is nothing to look at before.
        let guard = self.stops.guard.take();
        let outcome = self.home_all();
        self.stops.guard = guard;
        outcome
    }

    fn home_all(&mut self) -> Result<(), Fault> {
        let mut unhomed: Vec<_> =
            (0..self.robots.len()).filter(|&index| !self.robots[index].facts.homed).collect();
        while !unhomed.is_empty() {
            self.begin_step()?;
            if self.is_ending() {
                return Err(self.ending());
            }
            self.exchange(&unhomed, OrderKind::Query, flag::WANT_STATE)?;
            unhomed.retain(|&index| self.robots[index].reply.is(flag::HOMING));
        }
        Ok(())
    }

    /// Stops every robot of the cell and latches the first cause.
    pub(crate) fn stop(&mut self, fault: Fault) -> Fault {
        self.tell_stop(&fault);
        self.tell_upper(&fault);
        let fault = self.stops.latched.get_or_insert(fault).clone();
        self.operating.show_fault(&fault);
        let _ = self.operating.operator.meet(Event::Fault);
        self.robots.take_handed_over();
        self.background.clear();
        self.bring_to_rest();
        self.tell_standstill();
        self.operating.operator.show_cause(&fault);
        let _ = self.operating.operator.meet(Event::Standstill);
        fault
    }

    /// Tells all robots to stop until they stand, or until they should.
    fn bring_to_rest(&mut self) {
        let all = self.robots.all();
        // One step for the order to arrive, one for the answer.
        let limit = self.robots.stop_steps() + 2;
        let began = self.clock.step();
        let mut flags = if self.robots.leave_unanswered() { flag::UNANSWERED } else { 0 };
        // In the step of the fault itself, where that is not over: no robot has begun to move for it yet, and none goes on
        // alone.
        self.keep_unless_late();
        loop {
            if self.begin_step().is_err() {
                return;
            }
            // Every reply is a fault now; what counts is that the robots stand.
            let answered = self.exchange(&all, OrderKind::Stop, flags);
            flags = 0;
            if answered.is_err_and(|error| error.is_orderly()) {
                return;
            }
            // In its first step a robot may still be on its way to the demand before.
            let standing = self.clock.step() > began && self.robots.all_say(&all, flag::STANDSTILL);
            // A robot that does not stand when it must is left to its EDP: nobody waits for it for ever.
            if standing || self.clock.step() > began + limit {
                return;
            }
        }
    }
}
