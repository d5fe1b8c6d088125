//! VSP: a virtual sensor process aggregates raw readings, `v_l = f_v(c0, c_j, e_j, r)` (eq. 14).

use std::rc::Rc;

use crate::control::guarded::guarded;
use crate::control::plant_sensor::PlantSensor;
use crate::link::message::{Kind, Message};
use crate::link::{Board, Closed, Host, Sample, Server};
use crate::model::fault::{Fault, FaultKind, ProcessId};
use crate::model::frames::Frames;
use crate::model::image::Sensor;
use crate::model::sensor::{CONFIGURATION_WORDS, EffectorState, ReadingOrder, Taken, VirtualSensor};
use crate::model::time::Nanos;
use crate::model::wire::Wire;
use crate::operator::state::VspState;

/// Where a VSP gets its orders.
pub(crate) enum Orders {
    /// From these ports.
    Ports(Vec<Box<dyn Server>>),
    /// From boards, at its own period: each requester has its own two.
    Free { boards: Vec<Boards>, period: Nanos },
}

/// Where a requester of a free-running sensor leaves its orders and finds its readings.
#[derive(Clone)]
pub(crate) struct Boards {
    pub orders: Rc<dyn Board>,
    pub readings: Rc<dyn Board>,
}

/// The process.
pub(crate) struct Vsp<'w> {
    pub sensors: RawSensors,
    /// The words of the default configuration.
    pub configuration: [u64; CONFIGURATION_WORDS],
    pub host: Host<'w>,
    pub orders: Orders,
    /// Shows the newest state of the sensor's robot, for orders that come without it.
    pub state: Option<Rc<dyn Board>>,
    /// Time that one aggregation takes \[ns\].
    pub latency: Nanos,
    pub step: Nanos,
}

impl Vsp<'_> {
    /// Serves until the cell closes.
    pub fn run(mut self) {
        let mut request = Message::new(Kind::Read);
        let mut reply = Message::empty();
        // Only closing ends that.
        let Err(Closed) = self.serve(&mut request, &mut reply);
    }

    fn serve(
        &mut self,
        request: &mut Message,
        reply: &mut Message,
    ) -> Result<core::convert::Infallible, Closed> {
        match core::mem::replace(&mut self.orders, Orders::Ports(Vec::new())) {
            Orders::Ports(ports) => {
                let mut aggregated = None;
                loop {
                    for port in &ports {
                        if port.receive(request) {
                            self.add_state(request);
                            // Requesters of one step that ask for the same share one aggregation.
                            let mut configuration = [0; CONFIGURATION_WORDS];
                            configuration.copy_from_slice(&request.body[..CONFIGURATION_WORDS]);
                            let asked = Some((request.header.step, configuration));
                            if core::mem::replace(&mut aggregated, asked) != asked {
                                self.work()?;
                                self.aggregate(request, reply)?;
                                // It answers this order, however old it is.
                                reply.header.step = request.header.step;
                            }
                            port.reply(reply);
                        }
                    }
                    self.host.waiter.wait(None)?;
                }
            }
            Orders::Free { boards, period } => {
                let mut requests = vec![*request; boards.len()];
                loop {
                    let began = self.host.waiter.now();
                    self.read_orders(&boards, &mut requests, began / self.step.max(1));
                    for (i, request) in requests.iter().enumerate() {
                        let like = |other: &Message| {
                            other.body[..CONFIGURATION_WORDS] == request.body[..CONFIGURATION_WORDS]
                        };
                        // Requesters that ask for the same share one aggregation.
                        if requests[..i].iter().any(like) {
                            continue;
                        }
                        // A sensor that belongs to a robot is asked for nothing before that has told its state.
                        if self.state.is_some() && request.words().len() == CONFIGURATION_WORDS {
                            continue;
                        }
                        self.work()?;
                        if !self.aggregate(request, reply)? {
                            continue;
                        }
                        for (board, _) in boards.iter().zip(&requests).filter(|(_, other)| like(other)) {
                            board.readings.write(reply);
                        }
                    }
                    self.sleep(began + period)?;
                }
            }
        }
    }

    /// What each requester of a free-running sensor ordered last, or the default configuration, with the newest
    /// state of the sensor's robot.
    fn read_orders(&self, boards: &[Boards], requests: &mut [Message], step: u64) {
        let mut newest = None;
        for (i, (board, request)) in boards.iter().zip(requests.iter_mut()).enumerate() {
            if !board.orders.read(request) {
                *request = Message::new(Kind::Read);
                request.body[..CONFIGURATION_WORDS].copy_from_slice(&self.configuration);
                request.header.len = CONFIGURATION_WORDS as u32;
            } else if request.words().len() > CONFIGURATION_WORDS {
                let ordered = (request.header.step, i);
                newest = Some(newest.map_or(ordered, |newest| ordered.max(newest)));
            }
        }
        if let Some((_, from)) = newest {
            let len = requests[from].header.len;
            let state = requests[from].body;
            for request in requests.iter_mut() {
                request.body[CONFIGURATION_WORDS..].copy_from_slice(&state[CONFIGURATION_WORDS..]);
                request.header.len = len;
            }
        } else {
            requests.iter_mut().for_each(|request| self.add_state(request));
        }
        requests.iter_mut().for_each(|request| request.header.step = step);
    }

    /// Gives an order that came without the state of the sensor's robot the one that the robot's EDP showed last.
    fn add_state(&self, request: &mut Message) {
        let Some(board) = self.state.as_ref().filter(|_| request.words().len() == CONFIGURATION_WORDS) else {
            return;
        };
        let mut shown = Message::empty();
        if board.read(&mut shown) {
            let words = shown.words();
            request.body[CONFIGURATION_WORDS..CONFIGURATION_WORDS + words.len()].copy_from_slice(words);
            request.header.len += words.len() as u32;
        }
    }

    fn work(&self) -> Result<(), Closed> {
        if self.latency > 0 { self.sleep(self.host.waiter.now() + self.latency) } else { Ok(()) }
    }

    fn sleep(&self, until: Nanos) -> Result<(), Closed> {
        while self.host.waiter.now() < until {
            self.host.waiter.wait(Some(until))?;
        }
        Ok(())
    }

    /// Aggregates, and says whether there is anything to show.
    fn aggregate(&mut self, request: &Message, reply: &mut Message) -> Result<bool, Closed> {
        let began = self.host.waiter.now();
        let is_there = match &mut self.sensors {
            RawSensors::Here(aggregator) => aggregator.answer(request, reply, began),
            RawSensors::Plant(sensor) => sensor.answer(request, reply, self.host.waiter).map(|()| true)?,
        };
        self.host.meter.sample(Sample::Worked(self.host.waiter.now().saturating_sub(began)));
        if is_there {
            let words = (reply.header.kind == Kind::Reply).then(|| reply.words());
            self.host.console.show_vsp(&VspState { step: reply.header.step, words });
        }
        Ok(is_there)
    }
}

/// Where the raw sensors of a VSP are.
pub(crate) enum RawSensors {
    /// In its process.
    Here(Aggregator),
    /// In the plant.
    Plant(PlantSensor),
}

/// A virtual sensor of any kind: it takes orders and gives readings as words.
pub(crate) trait AnyVirtualSensor {
    /// As [`VirtualSensor::is_simulated`].
    fn is_simulated(&self) -> bool;
    /// As [`VirtualSensor::hardware`].
    fn hardware(&self) -> Option<String>;
    /// As [`VirtualSensor::python`].
    fn python(&self) -> Option<String>;
    /// As [`VirtualSensor::frames`].
    fn frames(&mut self) -> Option<&mut Frames>;
    /// As [`VirtualSensor::open`].
    fn open(&mut self) -> Result<(), Fault>;
    /// Writes the reading for an order, and the step in which it was taken, into `reply`. `false`: nothing has been taken yet.
    fn read(&mut self, request: &Message, reply: &mut Message) -> Result<bool, Fault>;
}

impl<V: VirtualSensor> AnyVirtualSensor for V {
    fn is_simulated(&self) -> bool {
        VirtualSensor::is_simulated(self)
    }

    fn hardware(&self) -> Option<String> {
        VirtualSensor::hardware(self)
    }

    fn python(&self) -> Option<String> {
        VirtualSensor::python(self)
    }

    fn frames(&mut self) -> Option<&mut Frames> {
        VirtualSensor::frames(self)
    }

    fn open(&mut self) -> Result<(), Fault> {
        VirtualSensor::open(self)
    }

    fn read(&mut self, request: &Message, reply: &mut Message) -> Result<bool, Fault> {
        let (words, robot) = parts(request)?;
        // A configuration that cannot be read is a fault, never the default one.
        let configuration = Wire::get(words).map_err(|_| unreadable("the sensor's configuration"))?;
        let order = ReadingOrder { configuration, robot, step: request.header.step };
        let taken = match self.taken(&order) {
            Taken::NotYet => return Ok(false),
            Taken::In(step) => step.min(order.step),
            Taken::NothingNew => order.step,
        };
        let reading = self.aggregate(&order).map_err(Fault::thrown_by_program)?;
        // It may panic: then the fault is of the order's step.
        reading.put(&mut reply.body);
        reply.header.step = taken;
        reply.header.kind = Kind::Reply;
        reply.header.len = <V::Kind as Sensor>::Reading::LEN as u32;
        Ok(true)
    }
}

/// What an order says: the words of a configuration, and the state of the sensor's robot.
fn parts(request: &Message) -> Result<(&[u64], Option<EffectorState>), Fault> {
    let words = request.words();
    let robot = match words.get(CONFIGURATION_WORDS..) {
        Some(state) if !state.is_empty() => {
            let state = EffectorState::get(state);
            Some(state.map_err(|_| unreadable("the state of the sensor's robot"))?)
        }
        Some(_) | None => None,
    };
    Ok((words, robot))
}

fn unreadable(what: &str) -> Fault {
    Fault::new(FaultKind::Message).text(what)
}

/// A virtual sensor that answers orders.
pub(crate) struct Aggregator {
    pub process: ProcessId,
    pub sensor: Box<dyn AnyVirtualSensor>,
    /// Why its hardware could not be opened, and when that was tried last.
    pub unopened: Option<(Fault, Nanos)>,
}

/// How long after an attempt to open a sensor's hardware that failed the next one follows, at an order \[ns\].
const AGAIN: Nanos = 1_000_000_000;

impl Aggregator {
    /// Opens its hardware, if it has any.
    pub fn open(&mut self, now: Nanos) {
        let opened = guarded(|| self.sensor.open()).and_then(|opened| opened);
        self.unopened = opened.err().map(|fault| (fault, now));
    }

    /// Answers an order with a reading, or with the fault for which there is no reading. `false`: nothing has been taken yet.
    pub fn answer(&mut self, request: &Message, reply: &mut Message, now: Nanos) -> bool {
        if self.unopened.as_ref().is_some_and(|(_, tried)| now >= tried + AGAIN) {
            self.open(now);
        }
        reply.header.step = request.header.step;
        let read = match &self.unopened {
            Some((fault, _)) => Err(fault.clone()),
            None => guarded(|| self.sensor.read(request, reply))
                .unwrap_or_else(|panic| Err(panic.thrown_by_program())),
        };
        let nothing = || Fault::new(FaultKind::SensorFailed).text("nothing has been taken yet");
        let is_there = read != Ok(false);
        if let Err(fault) = read.and_then(|is_there| is_there.then_some(()).ok_or_else(nothing)) {
            let fault = fault.in_process(self.process).at_step(request.header.step);
            reply.set_fault(&fault);
        }
        is_there
    }
}
