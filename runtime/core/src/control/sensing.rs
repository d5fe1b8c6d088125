//! The asking side of virtual sensors, the same in an MP and in an ECP.

use core::any::TypeId;
use core::time::Duration;
use std::rc::Rc;

use crate::control::replay::RecordedReadings;
use crate::control::replay::readings::RecordedReading;
use crate::control::state_words::StateWords;
use crate::control::vsp::Boards;
use crate::link::message::{Kind, Message};
use crate::link::timeout::{AnswerTimeout, Waiting};
use crate::link::{Client, Waiter};
use crate::model::fault::{Fault, FaultKind, ProcessId, Role};
use crate::model::image::{Sensor, SensorImage};
use crate::model::list::Reading;
use crate::model::list::{Owner, PayloadType, SensorHandle, SensorList, SensorsOf};
use crate::model::name::Name;
use crate::model::sensor::{CONFIGURATION_WORDS, VspMode};
use crate::model::shape::Shape;
use crate::model::time::Nanos;
use crate::model::wire::BadWords;
use crate::observe::step_observer::{ReadingState, StepEvent, StepObservers};
use crate::suggestion::suggestion;

/// How a virtual sensor is asked.
pub(crate) enum Source {
    /// Ordered and collected within one step.
    Interactive(Box<dyn Client>),
    /// Ordered in one step, collected when it is there.
    WithDelay(Box<dyn Client>),
    /// Free-running: the latest reading, and where it looks for orders.
    NonInteractive(Boards),
    /// In a replay: what the recording says was collected, of a sensor in this mode.
    Recorded(Rc<RecordedReadings>, VspMode),
}

/// How often a sensor is asked, and how old its readings may be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asking {
    /// A reading is ordered in every step, in every second step, ..
    pub every: u64,
    /// Steps after which a reading is too old to move by.
    pub max_age: u32,
    /// Length of a step of the cell.
    pub step: Duration,
}

/// One virtual sensor as a process sees it.
pub(crate) struct SensorPort {
    pub name: Name,
    pub kind: TypeId,
    /// Place of the robot whose state goes with an order of this process.
    pub robot: Option<usize>,
    pub source: Source,
    asking: Asking,
    /// What its readings' words say.
    shape: &'static Shape,
    pub taken: bool,
    order: Message,
    reply: Message,
    delayed: Delayed,
    read: bool,
    /// The step in which a reading was asked for last, and that of the last question after a pause.
    asked: Option<u64>,
    since: u64,
    /// The step of the last order: where not every step orders a reading, it is before the last question.
    ordered: Option<u64>,
}

/// An order of a sensor with delay.
#[derive(Default)]
struct Delayed {
    /// Whether it is not answered yet.
    awaiting: bool,
    /// Whether it is one of a program that a stop has ended: nobody reads the answer.
    discards: bool,
}

impl Delayed {
    /// Takes the answer; whether it has come and counts.
    fn receive(&mut self, client: &dyn Client, reply: &mut Message) -> bool {
        if !(self.awaiting && client.receive(reply)) {
            return false;
        }
        self.awaiting = false;
        !core::mem::take(&mut self.discards)
    }
}

/// What the readings of a sensor are.
#[derive(Clone, Copy)]
pub(crate) struct Reads {
    pub kind: TypeId,
    /// What their words say.
    pub shape: &'static Shape,
}

impl SensorPort {
    pub fn new(name: Name, reads: Reads, robot: Option<usize>, source: Source, asking: Asking) -> SensorPort {
        SensorPort {
            name,
            kind: reads.kind,
            robot,
            source,
            asking,
            shape: reads.shape,
            taken: false,
            order: Message::new(Kind::Read),
            reply: Message::empty(),
            delayed: Delayed::default(),
            read: false,
            asked: None,
            since: 0,
            ordered: None,
        }
    }

    /// The program starts again: nothing that the one before has read or ordered counts.
    fn release(&mut self) {
        self.taken = false;
        self.read = false;
        self.delayed.discards = self.delayed.awaiting;
        (self.asked, self.ordered) = (None, None);
    }

    /// Orders a reading in `step` if one is due, with the state of the robot that the sensor belongs to.
    fn order(&mut self, step: u64, robot: Option<StateWords<'_>>) {
        let resumes = self.asked.is_none_or(|asked| step > asked + 1);
        let begins = match self.source {
            Source::WithDelay(_) | Source::Recorded(_, VspMode::WithDelay) => resumes,
            Source::NonInteractive(_) | Source::Recorded(_, VspMode::NonInteractive(_)) => {
                self.asked.is_none()
            }
            Source::Interactive(_) | Source::Recorded(_, VspMode::Interactive) => false,
        };
        if begins {
            self.since = step;
        }
        // A step may ask more than once, before and after a motion begins: each gets the answer of that step.
        let is_due =
            self.ordered.is_none_or(|ordered| step == ordered || step >= ordered + self.asking.every);
        if !is_due && !self.delayed.awaiting {
            self.asked = Some(step);
            return;
        }
        self.order.header.step = step;
        self.order.header.len = CONFIGURATION_WORDS as u32;
        if let Some(state) = robot {
            self.order.header.len += state.put(&mut self.order.body[CONFIGURATION_WORDS..]) as u32;
        }
        match &self.source {
            Source::Interactive(client) => client.send(&self.order),
            Source::WithDelay(client) => {
                // A sensor with delay that is still at work is not disturbed: it has taken the order.
                self.read |= self.delayed.receive(&**client, &mut self.reply);
                if self.delayed.awaiting {
                    client.send_again();
                } else if is_due {
                    client.send(&self.order);
                    self.delayed.awaiting = true;
                }
            }
            Source::NonInteractive(boards) => boards.orders.write(&self.order),
            Source::Recorded(..) => {}
        }
        self.asked = Some(step);
        if is_due {
            self.ordered = Some(step);
        }
    }

    /// The step from which the age of the last reading counts. A reading from before a pause is too old only when
    /// the next one takes too long.
    fn age_counts_from(&self) -> Option<u64> {
        let read = self.read.then_some(self.reply.header.step);
        match &self.source {
            Source::WithDelay(_) | Source::Recorded(_, VspMode::WithDelay) => {
                Some(read.map_or(self.since, |read| read.max(self.since)))
            }
            // One that has never read is as old as the first order.
            Source::NonInteractive(_) | Source::Recorded(_, VspMode::NonInteractive(_)) => {
                read.or(Some(self.since))
            }
            Source::Interactive(_) | Source::Recorded(_, VspMode::Interactive) => read,
        }
    }

    /// Collects the reading ordered, or with delay the latest that is there.
    fn collect(&mut self, waiter: &dyn Waiter, mut waiting: Waiting) -> Result<(), Fault> {
        match &self.source {
            // None was ordered in this step: the last one counts.
            Source::Interactive(_) if self.asked != self.ordered => {}
            Source::Interactive(client) => {
                // An answer to an order that was given up does not answer this one.
                while !(client.receive(&mut self.reply) && self.reply.header.step == self.order.header.step) {
                    let goes_on = waiting.goes_on(&**client, waiter);
                    if !goes_on.map_err(|_| Fault::orderly(FaultKind::CellClosed))? {
                        return Err(self.fault(FaultKind::PeerLost).text("no reading in time"));
                    }
                }
                self.read = true;
            }
            Source::WithDelay(client) => {
                self.read |= self.delayed.receive(&**client, &mut self.reply);
            }
            Source::NonInteractive(boards) => {
                self.read = boards.readings.read(&mut self.reply) || self.read;
            }
            Source::Recorded(recorded, _) => match recorded.collect(self.order.header.step) {
                None | Some(RecordedReading { state: ReadingState::Lost, .. }) => {
                    return Err(self.fault(FaultKind::PeerLost).text("no reading in time"));
                }
                Some(RecordedReading { state: ReadingState::None, .. }) => {}
                Some(recorded) => self.read = recorded.put(&mut self.reply),
            },
        }
        if self.read && self.reply.header.kind == Kind::Fault {
            return Err(self.reply.fault().in_process(ProcessId::new(Role::Vsp, self.name)));
        }
        Ok(())
    }

    /// Shows what was collected in a step.
    fn show(&self, collected: &Result<(), Fault>, step: u64, step_observers: &StepObservers, now: Nanos) {
        let state = match collected {
            Ok(()) if self.read => ReadingState::There,
            Ok(()) => ReadingState::None,
            Err(_) if self.read && self.reply.header.kind == Kind::Fault => ReadingState::Fault,
            Err(_) => ReadingState::Lost,
        };
        let words = match state {
            ReadingState::There | ReadingState::Fault => self.reply.words(),
            ReadingState::None | ReadingState::Lost => &[],
        };
        let taken = self.reply.header.step;
        let what = StepEvent::Reading { sensor: self.name, step, state, taken, shape: self.shape };
        step_observers.show(now, &what, words);
    }

    fn fault(&self, kind: FaultKind) -> Fault {
        Fault::new(kind).in_process(ProcessId::new(Role::Vsp, self.name))
    }

    /// Its reading is so many steps old, which is said as time, too.
    fn stale(&self, age: u32) -> Fault {
        let Asking { max_age, step, .. } = self.asking;
        let ms = |steps: u32| step.as_nanos() as f64 * f64::from(steps) / 1e6;
        let text = format!("{} ms, at most {} ms", ms(age), ms(max_age));
        self.fault(FaultKind::SensorStale).text(&text).exceeds(age.into(), max_age.into(), "step")
    }
}

/// The sensors that an instruction reads, whatever their kinds are.
pub(crate) trait SensorsRead {
    /// Their places among those of the process.
    fn places(&self) -> &[usize];
    /// Writes the configuration of sensor `i`; returns its type.
    fn configuration(&self, i: usize, words: &mut [u64]) -> PayloadType;
    /// Takes a reading of sensor `i`, which is `age` steps old.
    fn read(&mut self, i: usize, words: &[u64], age: u32) -> Result<(), BadWords>;
}

/// The handles of an instruction, and what they read.
pub(crate) struct Readings<L: SensorList, H: SensorsOf<L>> {
    handles: H,
    places: H::Indices,
    pub v: Reading<L>,
}

impl<L: SensorList, H: SensorsOf<L>> Readings<L, H> {
    pub fn of(handles: H) -> Self {
        Readings { places: handles.indices(), v: Reading::new(handles.images()), handles }
    }

    /// Keeps what was read for the time between instructions.
    pub fn store(&mut self) {
        self.handles.store(&self.v);
    }
}

impl<L: SensorList, H: SensorsOf<L>> SensorsRead for Readings<L, H> {
    fn places(&self) -> &[usize] {
        self.places.as_ref()
    }

    fn configuration(&self, i: usize, words: &mut [u64]) -> PayloadType {
        self.handles.configuration(i, words)
    }

    fn read(&mut self, i: usize, words: &[u64], age: u32) -> Result<(), BadWords> {
        L::read(&mut self.v, i, words, age)
    }
}

/// All virtual sensors of a process.
pub struct Sensing {
    /// Whose handles are taken.
    pub(crate) owner: Owner,
    pub(crate) ports: Vec<SensorPort>,
    /// Of readings, and of other answers.
    pub timeout: AnswerTimeout,
    /// Where what was collected is shown.
    pub step_observers: StepObservers,
}

impl Sensing {
    /// The handle of a sensor, once.
    pub fn handle<S: Sensor>(
        &mut self,
        name: &str,
        configuration: S::Configuration,
        process: ProcessId,
    ) -> Result<SensorHandle<S>, Fault> {
        let index = self.take(name, (TypeId::of::<S>(), S::KIND), process)?;
        Ok(SensorHandle {
            owner: self.owner,
            index,
            name: self.ports[index].name,
            configuration,
            image: SensorImage::unknown(),
        })
    }

    /// The place of a sensor of a kind whose handle is taken now.
    fn take(
        &mut self,
        name: &str,
        (kind, kind_name): (TypeId, &str),
        process: ProcessId,
    ) -> Result<usize, Fault> {
        let config = |text: &str| Fault::new(FaultKind::Config).in_process(process).text(text);
        let Some(index) = self.ports.iter().position(|port| port.name.as_str() == name) else {
            let names: Vec<_> = self.ports.iter().map(|port| port.name.as_str()).collect();
            let there = match (names.as_slice(), process.name) {
                ([], Some(robot)) => {
                    format!("write of = \"{robot}\", or readers = [\"{robot}\"], in its table of cell.toml")
                }
                ([], None) => "write its table in cell.toml, and give the cell its VSP".to_owned(),
                (names, _) => suggestion(name, names, "there are"),
            };
            return Err(config(&format!("there is no sensor `{name}` here: {there}")));
        };
        let port = &mut self.ports[index];
        if port.kind != kind {
            return Err(config(&format!("sensor `{name}` is of another kind than {}", kind_name)));
        }
        if core::mem::replace(&mut port.taken, true) {
            return Err(config(&format!("sensor `{name}` has a handle already: pass that one on")));
        }
        Ok(index)
    }

    /// Refuses handles that another process gave.
    ///
    /// # Errors
    /// `Config` for the first one.
    pub fn check<V: SensorList>(&self, sensors: &impl SensorsOf<V>) -> Result<(), Fault> {
        Owner::refuse("sensor", sensors.stranger(self.owner))
    }

    /// Programs start again: each sensor has its handle to give, and the age of its readings counts anew.
    pub fn release(&mut self) {
        self.ports.iter_mut().for_each(SensorPort::release);
    }

    /// The robot that the sensor at a place of this process belongs to.
    pub fn robot_of(&self, place: usize) -> Option<usize> {
        self.ports[place].robot
    }

    /// Orders all readings of an instruction.
    pub(crate) fn order<'a>(
        &mut self,
        sensors: &dyn SensorsRead,
        step: u64,
        robot: &dyn Fn(Option<usize>) -> Option<StateWords<'a>>,
    ) {
        for (i, &index) in sensors.places().iter().enumerate() {
            let port = &mut self.ports[index];
            port.order.header.payload = sensors.configuration(i, &mut port.order.body).id;
            port.order(step, robot(port.robot));
        }
    }

    /// Collects them.
    pub(crate) fn collect(
        &mut self,
        sensors: &mut dyn SensorsRead,
        waiter: &dyn Waiter,
        step: u64,
    ) -> Result<(), Fault> {
        if sensors.places().is_empty() {
            return Ok(());
        }
        let waiting = self.timeout.begin(waiter);
        for i in 0..sensors.places().len() {
            let port = &mut self.ports[sensors.places()[i]];
            let collected = port.collect(waiter, waiting);
            port.show(&collected, step, &self.step_observers, waiter.now());
            collected?;
            let age = |from: u64| u32::try_from(step.saturating_sub(from)).unwrap_or(u32::MAX);
            if let Some(age) = port.age_counts_from().map(age).filter(|&age| age > port.asking.max_age) {
                return Err(port.stale(age));
            }
            if port.read {
                let age = age(port.reply.header.step);
                sensors.read(i, port.reply.words(), age).map_err(|_| port.fault(FaultKind::Message))?;
            }
        }
        Ok(())
    }
}
