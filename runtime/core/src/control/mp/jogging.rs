//! The robot that a person jogs, as the MP sees it.
//!
//! In: what consoles ask for, the hold that lasts, and which robots are moved by whom. Out: in each step, what is asked of one
//! robot: in its order for the program of an ECP, in the seat of a panel for the MP's own program; and whether the hold counts.
//!
//! There is one path time for all robots of a cell. So the hold of a jog lets it pass only while no robot moves but by a jog
//! panel: a robot that its program would move on stands, and so does the one that is jogged.

use core::any::Any;
use std::rc::Rc;

use crate::link::message::flag;
use crate::model::fault::{Fault, FaultKind};
use crate::model::list::{Owner, RobotHandle};
use crate::model::name::Name;
use crate::model::robot::Robot;
use crate::model::wire::WORDS;
use crate::observe::step_observer::StepEvent;
use crate::operator::button::Button;
use crate::operator::jog::panel::{named, switchable};
use crate::operator::jog::{JogFrame, JogMotion, JogNow, JogOrder, JogPanel, JogRefusal, JogSeat, JogStop};
use crate::operator::state::InstructionKind;

use super::Mp;

/// The robots of a cell that have something in common, by their places: of more than these nobody jogs one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Some128(pub [u64; 2]);

impl Some128 {
    fn insert(&mut self, index: usize) {
        if let Some(word) = self.0.get_mut(index / 64) {
            *word |= 1 << (index % 64);
        }
    }

    const fn has(self, index: usize) -> bool {
        index < 128 && self.0[index / 64] & 1 << (index % 64) != 0
    }
}

/// A panel's seat of the MP's own program.
struct OwnSeat {
    index: usize,
    seat: JogSeat,
    /// Whether the Move at work asks its panel.
    asks: bool,
}

/// What is asked of robots that are jogged.
#[derive(Default)]
pub(super) struct Jogging {
    /// How much the MP had seen of what was asked.
    seen: u64,
    newest: Option<(u64, Name, JogOrder)>,
    /// The robot whose jogging is done, and the number of the press that said so.
    done: Option<(usize, u64)>,
    /// What is asked of which robot in this step.
    now: Option<(usize, JogNow)>,
    seats: Vec<OwnSeat>,
    /// The robots that the Move at work moves by its own demands.
    moved: Some128,
}

impl Jogging {
    /// What the order of a robot says of jogging.
    #[inline]
    pub fn of(&self, index: usize) -> Option<&JogNow> {
        let (_, now) = self.now.as_ref().filter(|(jogged, _)| *jogged == index)?;
        self.seat(index).is_none().then_some(now)
    }

    /// Whether nobody has asked for anything since the cell began, or a program was done with.
    const fn is_idle(&self) -> bool {
        self.newest.is_none() && self.done.is_none() && self.now.is_none()
    }

    #[inline]
    fn seat(&self, index: usize) -> Option<&OwnSeat> {
        self.seats.iter().find(|own| own.index == index && own.seat.is_taken(1))
    }

    /// A Move begins that moves these robots by its own demands.
    pub fn begin_move(&mut self, indices: &[usize]) {
        self.moved = Some128::default();
        indices.iter().for_each(|&index| self.moved.insert(index));
        for own in &mut self.seats {
            // Its generator has not been asked yet: a panel that a program has is taken for one that it asks.
            own.asks = self.moved.has(own.index) && own.seat.is_taken(1);
        }
    }

    /// The Move's generator was asked for its demands.
    pub fn see_who_asks(&mut self) {
        self.seats.iter_mut().for_each(|own| own.asks = own.seat.take_read());
    }

    /// No Move is at work.
    pub fn end_move(&mut self) {
        self.moved = Some128::default();
        for own in &mut self.seats {
            own.asks = false;
            own.seat.forget();
        }
    }

    /// Says what is asked now to the panels of the MP's own program.
    fn say(&self) {
        for own in &self.seats {
            let (_, now) = self.now.filter(|(index, _)| *index == own.index).unwrap_or_default();
            own.seat.say(now);
        }
    }
}

impl Mp<'_> {
    /// A panel of a robot that a person may jog, for a generator of this program that moves the robot as the panel says: while
    /// that is at work, the operator may jog the robot.
    ///
    /// # Errors
    /// `Config` when the handle is of another cell.
    pub fn jog_panel<R: Robot>(&mut self, robot: &RobotHandle<R>) -> Result<JogPanel<R>, Fault> {
        let strange = (robot.owner != self.robots.owner).then_some(robot.name);
        Owner::refuse("robot", strange).map_err(|fault| fault.in_process(self.process))?;
        let model = Rc::clone(&self.robots[robot.index].facts.model).downcast::<R>().map_err(|_| {
            Fault::new(FaultKind::Config)
                .text("a cell is not jogged: its robots are")
                .in_process(self.process)
        })?;
        let seats = &mut self.jogging.seats;
        let seat = match seats.iter().find(|own| own.index == robot.index) {
            Some(own) => own.seat.clone(),
            None => {
                let seat = JogSeat::default();
                seats.push(OwnSeat { index: robot.index, seat: seat.clone(), asks: false });
                seat
            }
        };
        let signals = Rc::clone(&self.robots[robot.index].facts.signals);
        Ok(seat.panel(model, Rc::clone(&self.named), signals))
    }

    /// Whether a program lets a robot be jogged now.
    fn jogs(&self, index: usize) -> bool {
        match self.jogging.seat(index) {
            Some(own) => own.asks && self.operating.is_doing(InstructionKind::Move),
            None => {
                let robot = &self.robots[index];
                robot.reply.is(flag::JOGS) && robot.order.header.len as usize + JogNow::WORDS <= WORDS
            }
        }
    }

    /// Whether a robot moves, or would move if path time passed, other than by a panel.
    fn moves_by_program(&self, index: usize) -> bool {
        let robot = &self.robots[index];
        // What the robots of a lower cell do is that cell's to say.
        let by_mp = self.jogging.moved.has(index) && !self.jogging.seat(index).is_some_and(|own| own.asks);
        by_mp
            || robot.reply.is(flag::OWN_MOTION)
            || robot.lower.is_some() && robot.is_in(self.robots.ordinal)
            || self.background.has(index)
    }

    /// Whether a robot may be jogged like this.
    ///
    /// # Errors
    /// Why not.
    fn may_jog(&self, robot: Name, order: &JogOrder) -> Result<usize, JogRefusal> {
        let index = self.robots.iter().position(|known| known.facts.name == robot && known.lower.is_none());
        let index = index.ok_or(JogRefusal::NoRobot)?;
        let joints = self.robots[index].facts.joints;
        let fits = match &order.motion {
            JogMotion::Tool { frame: JogFrame::Named(frame), .. } if named(&self.named, *frame).is_none() => {
                return Err(JogRefusal::NoFrame);
            }
            JogMotion::Tool { .. } => true,
            JogMotion::Joint { joint } => usize::from(*joint) < joints,
            JogMotion::To { joints: to } => to.positions().len() == joints,
            JogMotion::Output { output, to } => {
                switchable(&self.robots[index].facts.signals, *output, *to)?;
                true
            }
        };
        if !fits {
            return Err(JogRefusal::NoJoint);
        }
        if !self.jogs(index) {
            return Err(JogRefusal::NoProgram);
        }
        let mut others = (0..self.robots.len()).filter(|&other| other != index);
        if others.any(|other| self.moves_by_program(other)) { Err(JogRefusal::OthersMove) } else { Ok(index) }
    }

    /// Why a button that a console has pressed is refused, whatever the cell's state is.
    pub(super) fn refuses(&self, button: Button) -> Option<JogRefusal> {
        match button {
            Button::Jog(renewal, robot, order) if self.operating.operator.is_reduced() => {
                let began = self.jogging.newest.filter(|(hold, ..)| *hold == renewal.hold());
                match began {
                    Some((_, held, _)) if held != robot => Some(JogRefusal::AnotherRobot),
                    Some(_) | None => self.may_jog(robot, &order).err(),
                }
            }
            Button::JogDone(robot) => {
                let index = self.robots.iter().position(|known| known.facts.name == robot);
                let jogs = index.ok_or(JogRefusal::NoRobot).map(|index| self.jogs(index));
                jogs.map_or_else(Some, |jogs| (!jogs).then_some(JogRefusal::NoProgram))
            }
            _ => None,
        }
    }

    /// Sees what is held when a step begins, and what is asked of which robot in it.
    #[inline]
    pub(super) fn look_at_holds(&mut self) {
        let lasting = self.operating.lasting_hold(self.host.waiter.now(), self.clock.is_standing());
        if self.jogging.is_idle() && !self.operating.operator.has_asked_to_jog(self.jogging.seen) {
            self.operating.show_held(lasting.is_some());
        } else {
            self.look_at_jogs(lasting);
        }
    }

    #[cold]
    fn look_at_jogs(&mut self, lasting: Option<u64>) {
        let asked = self.operating.operator.asked_jogs(&mut self.jogging.seen);
        let is_known = asked.is_ok();
        if let Ok(Some(asked)) = asked {
            let hold = |newest: &Option<(u64, Name, JogOrder)>| newest.as_ref().map(|(hold, ..)| *hold);
            if asked.done.is_none() && hold(&asked.newest) != hold(&self.jogging.newest) {
                // Whoever jogs anew is not done any more.
                self.jogging.done = None;
            }
            self.jogging.newest = asked.newest;
            let done =
                asked.done.and_then(|done| self.robots.iter().position(|robot| robot.facts.name == done));
            // Whatever was done before is not done again.
            self.jogging.done = done.map(|index| (index, self.clock.step() + 1)).or(self.jogging.done);
        }
        self.jogging.done = self.jogging.done.filter(|(index, _)| self.jogs(*index));
        let jog = self.jogging.newest.filter(|(hold, ..)| Some(*hold) == lasting);
        let order = jog.filter(|_| self.operating.is_slow).and_then(|(press, robot, order)| {
            let index = self.may_jog(robot, &order).ok()?;
            Some((index, JogNow::Order { press, order }))
        });
        let done = self.jogging.done.map(|(index, press)| (index, JogNow::Done { press }));
        self.ask_to_jog(done.or(order));
        // A jog that moves nothing, or one that is newer than the hold that was seen, lets nothing else move either.
        let is_plain = |lasting| is_known && self.jogging.newest.is_none_or(|(hold, ..)| hold < lasting);
        self.operating.show_held(lasting.is_some_and(|lasting| order.is_some() || is_plain(lasting)));
    }

    /// The same in a replay, which knows from the recording what was asked for.
    pub(super) fn replay_holds(&mut self) {
        self.operating.replay_hold();
        let step = self.clock.step();
        let recorded = self.script.as_ref().and_then(|script| script.jog(step));
        let index = |robot: &Name| self.robots.iter().position(|known| known.facts.name == *robot);
        let now = recorded.and_then(|(robot, now)| Some((index(&robot)?, now)));
        self.ask_to_jog(now);
    }

    fn ask_to_jog(&mut self, now: Option<(usize, JogNow)>) {
        let before = core::mem::replace(&mut self.jogging.now, now);
        if before != now && self.step_observers.is_watched() {
            let mut words = [0; JogNow::WORDS];
            let index = now.or(before).map_or(0, |(index, _)| index);
            now.unwrap_or_default().1.put(&mut words);
            let what = StepEvent::Jog { step: self.clock.step(), robot: self.robots[index].facts.name };
            self.step_observers.show(self.host.waiter.now(), &what, &words);
        }
        self.jogging.say();
    }

    /// Which robots may be jogged now, and why one stands that the MP's own program lets be jogged.
    pub(super) fn jogged(&self) -> ([u64; 2], Option<(u8, JogStop)>) {
        let mut jogs = Some128::default();
        let all = (0..self.robots.len()).filter(|&index| self.jogs(index));
        all.for_each(|index| jogs.insert(index));
        let jogged = self.jogging.now.and_then(|(index, _)| {
            let own = self.jogging.seat(index)?;
            Some((u8::try_from(index).ok()?, own.seat.stop()))
        });
        (jogs.0, jogged)
    }
}

/// A model of any robot.
pub(crate) type AnyModel = Rc<dyn Any>;
