//! The robots of a cell as the MP sees them: the ports of their ECPs.
//!
//! In: handles that programs ask for, orders. Out: the last order and the last reply of each robot, and what follows from them
//! for all robots.

use core::any::TypeId;
use core::ops::{Index, IndexMut};
use std::rc::Rc;

use crate::control::guard::RobotView;
use crate::link::Client;
use crate::link::message::{Header, Message, OrderKind, flag};
use crate::model::fault::{Fault, FaultKind, ProcessId};
use crate::model::image::RobotImage;
use crate::model::image::STATE_WORDS;
use crate::model::joints::JointVector;
use crate::model::list::State;
use crate::model::list::{Owner, PayloadType, RobotHandle, RobotList, Robots};
use crate::model::name::Name;
use crate::model::named::SignalNames;
use crate::model::robot::Robot;
use crate::model::sensor::EffectorState;
use crate::model::time::Nanos;
use crate::model::wire::{BadWords, Wire};
use crate::observe::step_observer::{StepEvent, StepObservers};
use crate::operator::jog::JogNow;
use crate::safety::braking::BrakingLaw;
use crate::suggestion::suggestion;

use super::AnyModel;

/// The message of the fault of an ECP that does not answer.
pub(super) const SILENT: &str = "no answer from the ECP: its program computes or waits elsewhere";
/// The message of the fault of a cell that does not answer.
pub(super) const CELL_SILENT: &str = "no answer from the cell's MP: its program computes or waits elsewhere";

/// What a robot is that the MP has orders for.
pub struct RobotFacts {
    /// Its name in this cell, and who it is among all processes: the ECP, or the MP of a lower cell.
    pub name: Name,
    pub process: ProcessId,
    pub kind: TypeId,
    /// The kind's name, for messages.
    pub kind_name: &'static str,
    /// Its model, and how many joints it has; nothing and none of a lower cell.
    pub model: AnyModel,
    pub joints: usize,
    /// The names of its inputs and outputs.
    pub signals: Rc<SignalNames>,
    /// Whether its drives know where it is.
    pub homed: bool,
    /// Steps after which the robot must stand when it was told to stop.
    pub stop_steps: u64,
}

/// One robot as the MP sees it.
pub(crate) struct RobotPort {
    pub(super) facts: RobotFacts,
    pub(super) client: Box<dyn Client>,
    /// Whether its handle is.
    taken: bool,
    /// What is kept of it if it is a cell.
    pub(super) lower: Option<Lower>,
    /// Whether the last order was sent: a cell that is left out gets none.
    pub(super) asked: bool,
    /// Whether its ECP owed the last answer.
    pub(super) is_silent: bool,
    /// Whether the last instruction handed it over moving.
    pub(super) handed_over: bool,
    /// The type of its orders, and the ordinal of the instruction that they belong to.
    pub(super) payload: PayloadType,
    pub(super) instruction: u32,
    pub(super) order: Message,
    pub(super) reply: Message,
}

impl RobotPort {
    pub fn new(facts: RobotFacts, client: Box<dyn Client>) -> RobotPort {
        RobotPort {
            facts,
            client,
            taken: false,
            lower: None,
            asked: false,
            is_silent: false,
            handed_over: false,
            payload: PayloadType::of::<()>(),
            instruction: 0,
            order: Message::empty(),
            reply: Message::empty(),
        }
    }

    /// The same of a lower cell.
    pub fn of_cell(mut self) -> RobotPort {
        self.lower = Some(Lower::default());
        self
    }

    /// The message of its fault when it does not answer.
    pub(super) const fn silent(&self) -> &'static str {
        if self.lower.is_some() { CELL_SILENT } else { SILENT }
    }

    /// Sends its order with what is asked of the robot that a person jogs, behind the order's own words.
    #[cold]
    pub(super) fn send_with(&mut self, jog: &JogNow) {
        let own = self.order.header.len as usize;
        let Some(words) = self.order.body.get_mut(own..own + JogNow::WORDS) else {
            return self.client.send(&self.order);
        };
        words.fill(0);
        jog.put(words);
        self.order.header.len += JogNow::WORDS as u32;
        self.order.header.flags |= flag::JOG;
        self.client.send(&self.order);
        self.order.header.len = own as u32;
        self.order.header.flags &= !flag::JOG;
    }

    /// Takes the answer to the last order, if it is there. An answer to an order that was given up is not one.
    pub(super) fn receives_answer(&mut self) -> bool {
        let to = |header: &Header| (header.epoch, header.step);
        self.client.receive(&mut self.reply) && to(&self.reply.header) == to(&self.order.header)
    }

    /// Whether its last order is one of a tight Move, and its EDP went on with the others by the order before.
    #[inline]
    pub(super) const fn is_together(&self) -> bool {
        self.order.is(flag::TOGETHER) && self.reply.is(flag::TOGETHER)
    }

    /// What its EDP reported in the last exchange, if it was asked.
    pub(super) fn view(&self) -> Option<RobotView> {
        let words = self.reply.is(flag::STATE).then(|| self.reply.words())?;
        let (measured, demanded) = words.split_at_checked(STATE_WORDS)?;
        let state = |words: &[u64]| EffectorState::get(words.get(..STATE_WORDS)?).ok();
        Some(RobotView { name: self.facts.name, measured: state(measured)?, demanded: state(demanded)? })
    }

    /// Shows the order that it was sent.
    pub(super) fn show_order(
        &self,
        kind: OrderKind,
        step_observers: &StepObservers,
        now: impl FnOnce() -> Nanos,
    ) {
        if !step_observers.is_watched() {
            return;
        }
        let PayloadType { name: payload, shape, .. } = self.payload;
        let header = &self.order.header;
        let what = StepEvent::Order {
            // Of a robot of a lower cell, its name among all.
            robot: self.facts.process.name.unwrap_or(self.facts.name),
            step: header.step,
            instruction: header.instruction,
            kind,
            payload,
            shape,
        };
        step_observers.show(now(), &what, self.order.words());
    }

    /// Whether the instruction that was opened last names it, by the ordinal of that.
    pub(super) const fn is_in(&self, ordinal: u32) -> bool {
        self.instruction == ordinal
    }

    pub(super) const fn process(&self) -> ProcessId {
        self.facts.process
    }
}

/// What an MP keeps of a robot that is a cell.
#[derive(Default)]
pub(super) struct Lower {
    /// Whether Moves go on without it when it has a fault.
    pub dispensable: bool,
    /// The fault for which the last Move went on without it.
    pub fault: Option<Fault>,
    /// Whether it is out of the instruction that is open.
    pub out: bool,
}

/// Takes the words of the image of a robot, by its place in a list.
type ReadImage<'r> = dyn FnMut(usize, &[u64]) -> Result<(), BadWords> + 'r;

/// All robots of a cell.
pub(super) struct RobotPorts {
    /// Whose handles are taken.
    pub owner: Owner,
    ports: Vec<RobotPort>,
    /// How fast all robots of the last exchange may slow down together.
    pub law: BrakingLaw,
    /// Ordinal of the instruction opened last.
    pub ordinal: u32,
    /// Resets that were tried.
    pub epoch: u32,
}

/// What the replies of an exchange say about all robots.
pub(super) struct Gathered {
    /// The first cause of what is wrong.
    pub first: Option<Fault>,
    /// What a robot is to be stopped for on its path.
    pub trouble: Option<Fault>,
    /// How fast the robots may slow down together.
    pub law: BrakingLaw,
}

impl Gathered {
    pub const NOTHING: Gathered = Gathered { first: None, trouble: None, law: BrakingLaw::UNLIMITED };
}

impl Index<usize> for RobotPorts {
    type Output = RobotPort;

    fn index(&self, index: usize) -> &RobotPort {
        &self.ports[index]
    }
}

impl IndexMut<usize> for RobotPorts {
    fn index_mut(&mut self, index: usize) -> &mut RobotPort {
        &mut self.ports[index]
    }
}

impl RobotPorts {
    pub fn new(ports: Vec<RobotPort>) -> Self {
        RobotPorts { owner: Owner::unique(), ports, law: BrakingLaw::UNLIMITED, ordinal: 0, epoch: 0 }
    }

    pub fn len(&self) -> usize {
        self.ports.len()
    }

    pub fn iter(&self) -> core::slice::Iter<'_, RobotPort> {
        self.ports.iter()
    }

    /// The places of all robots.
    pub fn all(&self) -> Vec<usize> {
        (0..self.ports.len()).collect()
    }

    /// The handle of a robot, once.
    ///
    /// # Errors
    /// `Config` when there is no robot of that name and kind, or when its handle is taken.
    pub fn handle<R: Robot>(&mut self, name: &str) -> Result<RobotHandle<R>, Fault> {
        let index = self.take(name, (TypeId::of::<R>(), R::KIND), R::Joints::LEN)?;
        let RobotFacts { name, signals, .. } = &self.ports[index].facts;
        let (name, signals) = (*name, Rc::clone(signals));
        Ok(RobotHandle { owner: self.owner, index, name, image: RobotImage::unknown(), signals })
    }

    /// The place of a robot of a kind, with so many joints, whose handle is taken now.
    fn take(&mut self, name: &str, (kind, kind_name): (TypeId, &str), joints: usize) -> Result<usize, Fault> {
        let config = |text: &str| Fault::new(FaultKind::Config).text(text);
        let Some(index) = self.ports.iter().position(|robot| robot.facts.name.as_str() == name) else {
            let names: Vec<_> = self.ports.iter().map(|robot| robot.facts.name.as_str()).collect();
            let there = suggestion(name, &names, "the cell has");
            return Err(config(&format!("there is no robot `{name}`: {there}")));
        };
        let port = &mut self.ports[index];
        if port.facts.kind != kind && port.facts.kind_name == kind_name {
            let text = format!(
                "robot `{name}` is of the kind {kind_name} and has not {joints} joints: name its own number of them in `robot::<..>`"
            );
            return Err(config(&text));
        }
        if port.facts.kind != kind {
            let text = format!(
                "robot `{name}` is of another kind than {kind_name}: name its own, {}, in `robot::<..>`",
                port.facts.kind_name
            );
            return Err(config(&text));
        }
        if core::mem::replace(&mut port.taken, true) {
            return Err(config(&format!("robot `{name}` has a handle already: pass that one on")));
        }
        if let Some(lower) = &mut port.lower {
            // Whether it can be dispensed with is for each run of the program to say.
            *lower = Lower::default();
        }
        Ok(index)
    }

    /// The robots' programs start again: each robot has its handle to give, and has told nothing.
    pub fn release(&mut self) {
        for robot in &mut self.ports {
            robot.taken = false;
            robot.handed_over = false;
            robot.reply = Message::empty();
        }
    }

    /// Whether all robots of a list have a flag in their last reply.
    pub fn all_say(&self, indices: &[usize], flag: u32) -> bool {
        indices.iter().all(|&index| self.ports[index].reply.is(flag))
    }

    /// Whether a robot has not answered the last order of a tight Move.
    pub fn leave_unanswered(&self) -> bool {
        self.ports.iter().any(|robot| robot.is_silent && robot.order.is(flag::TOGETHER))
    }

    /// Whether any robot has been handed over moving.
    pub fn any_handed_over(&self) -> bool {
        self.ports.iter().any(|robot| robot.handed_over)
    }

    /// The same; from now on they are the instruction's again.
    pub fn take_handed_over(&mut self) -> bool {
        let taken = |any, robot: &mut RobotPort| core::mem::take(&mut robot.handed_over) | any;
        self.ports.iter_mut().fold(false, taken)
    }

    /// Steps after which every robot must stand that was told to stop.
    pub fn stop_steps(&self) -> u64 {
        self.ports.iter().map(|robot| robot.facts.stop_steps).max().unwrap_or(0)
    }

    /// Writes the demands of the robots of a list into their orders.
    pub fn write<L: Robots<O>, O>(&mut self, indices: &[usize], demands: &L::Demands) {
        for (i, &index) in indices.iter().enumerate() {
            let order = &mut self.ports[index].order;
            order.header.len = L::write(demands, i, &mut order.body) as u32;
        }
    }

    /// With tight orders no ECP may finish before the MP's motion is done.
    ///
    /// # Errors
    /// `FinishedEarly` for the first one that has.
    pub fn refuse_early(
        &self,
        indices: &[usize],
        payload: &dyn Fn(usize) -> PayloadType,
        step: u64,
    ) -> Result<(), Fault> {
        for (i, robot) in indices.iter().map(|&index| &self.ports[index]).enumerate() {
            if robot.reply.is(flag::FINISHED) && payload(i).tight {
                return Err(Fault::new(FaultKind::FinishedEarly).in_process(robot.process()).at_step(step));
            }
        }
        Ok(())
    }

    /// The images in the last replies of the robots of a list.
    pub fn read_images<L: RobotList>(&self, indices: &[usize], e: &mut State<L>) -> Result<(), Fault> {
        self.each_image(indices, &mut |i, words| L::read(e, i, words))
    }

    /// The image in the last reply of each robot of a list, where there is one.
    pub fn each_image(&self, indices: &[usize], read: &mut ReadImage<'_>) -> Result<(), Fault> {
        for (i, robot) in indices.iter().map(|&index| &self.ports[index]).enumerate() {
            if robot.reply.is(flag::STATE) {
                let bad = |_| Fault::new(FaultKind::Message).in_process(robot.process());
                read(i, robot.reply.words()).map_err(bad)?;
            }
        }
        Ok(())
    }
}
