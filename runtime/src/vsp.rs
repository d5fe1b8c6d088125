//! VSP: a virtual sensor process aggregates raw readings, `v_l = f_v(c0, c_j, e_j, r)` (eq. 14).

use core::time::Duration;
use std::rc::Rc;

use crate::fault::{Fault, FaultKind, ProcessId};
use crate::image::Sensor;
use crate::joints::MAX_JOINTS;
use crate::link::{Board, Closed, Nanos, Sample, Server, Waiter};
use crate::message::{Kind, Message};
use crate::plant::sensors::PlantSensor;
use crate::pose::Pose;
use crate::shape::Shape;
use crate::wire::{BadWords, WORDS, Wire};

/// Words of a reading order that the configuration may take.
pub(crate) const CONFIGURATION_WORDS: usize = 16;

/// Steps after which a reading is too old to move by.
pub(crate) const MAX_AGE: u32 = 20;

/// A virtual sensor: holds the raw sensors and computes one reading from them.
pub trait VirtualSensor: 'static {
    /// What it reads.
    type Kind: Sensor;

    /// One aggregated reading for an order.
    ///
    /// # Errors
    /// A [`Fault`] when the raw sensors give nothing to aggregate: the Move or Wait that reads it ends with it.
    fn aggregate(
        &mut self,
        order: &ReadingOrder<<Self::Kind as Sensor>::Configuration>,
    ) -> Result<<Self::Kind as Sensor>::Reading, Fault>;

    /// Whether it senses a simulated world. Where a cell runs as processes of the operating system, that is in one of its
    /// own, `plant`, with all simulated drives, and so is this sensor: its VSP passes orders on.
    fn is_simulated(&self) -> bool {
        false
    }
}

/// What a virtual sensor is told with each order.
#[derive(Clone, Copy, Debug)]
pub struct ReadingOrder<C> {
    /// The requester's configuration, `c0` or `c_j`.
    pub configuration: C,
    /// `e_j`: the measured state of the robot that the requester has for this sensor.
    pub robot: Option<EffectorState>,
    /// Index of the step.
    pub step: u64,
}

/// The measured state of a robot of any kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectorState {
    /// Joint positions [rad or m]; entries beyond the robot's joints are 0.
    pub joints: [f64; MAX_JOINTS],
    /// Joint velocities [rad/s or m/s].
    pub velocity: [f64; MAX_JOINTS],
    /// `X_WE`, the pose of the tool in the world.
    pub pose: Pose,
}

impl Wire for EffectorState {
    const LEN: usize = 2 * MAX_JOINTS + 7;
    const LAYOUT: u64 = crate::wire::layout_hash(0, "mrroc::EffectorState");
    const SHAPE: &'static Shape = &Shape::Fields(&[
        ("joints", <[f64; MAX_JOINTS]>::SHAPE),
        ("velocity", <[f64; MAX_JOINTS]>::SHAPE),
        ("pose", Shape::POSE),
    ]);

    fn put(&self, words: &mut [u64]) {
        self.joints.put(words);
        self.velocity.put(&mut words[MAX_JOINTS..]);
        self.pose.put(&mut words[2 * MAX_JOINTS..]);
    }

    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let words = words.get(..Self::LEN).ok_or(BadWords)?;
        Ok(EffectorState {
            joints: Wire::get(words)?,
            velocity: Wire::get(&words[MAX_JOINTS..])?,
            pose: Wire::get(&words[2 * MAX_JOINTS..])?,
        })
    }
}

const _: () = assert!(CONFIGURATION_WORDS + EffectorState::LEN <= WORDS);

/// How a virtual sensor and its requesters keep step, as in MRROC++.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VspMode {
    /// The requester waits for the reading that it ordered.
    Interactive,
    /// The order is taken at once and its reading collected in a later step; unanswered means the older reading.
    WithDelay,
    /// The sensor runs freely with this period; each requester takes the latest reading of its own configuration,
    /// and until it has ordered one, of the default configuration.
    NonInteractive(Duration),
}

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
pub(crate) struct Vsp<'w, V: VirtualSensor> {
    pub sensors: RawSensors<V>,
    pub configuration: <V::Kind as Sensor>::Configuration,
    pub waiter: &'w dyn Waiter,
    pub orders: Orders,
    /// Time that one aggregation takes \[ns\].
    pub latency: Nanos,
    pub step: Nanos,
}

impl<V: VirtualSensor> Vsp<'_, V> {
    /// Serves until the cell closes.
    pub fn run(mut self) {
        let mut request = Message::new(Kind::Read);
        let mut reply = Message::empty();
        // Closing is the only way out.
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
                            // Requesters of one step that ask for the same share one aggregation.
                            let mut configuration = [0; CONFIGURATION_WORDS];
                            configuration.copy_from_slice(&request.body[..CONFIGURATION_WORDS]);
                            let asked = Some((request.header.step, configuration));
                            if core::mem::replace(&mut aggregated, asked) != asked {
                                self.work()?;
                                self.aggregate(request, reply)?;
                            }
                            port.reply(reply);
                        }
                    }
                    self.waiter.wait(None)?;
                }
            }
            Orders::Free { boards, period } => {
                let mut requests = vec![*request; boards.len()];
                loop {
                    let began = self.waiter.now();
                    self.read_orders(&boards, &mut requests, began / self.step.max(1));
                    for (i, request) in requests.iter().enumerate() {
                        let like = |other: &Message| {
                            other.body[..CONFIGURATION_WORDS] == request.body[..CONFIGURATION_WORDS]
                        };
                        // Requesters that ask for the same share one aggregation.
                        if requests[..i].iter().any(like) {
                            continue;
                        }
                        self.work()?;
                        self.aggregate(request, reply)?;
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
                self.configuration.put(&mut request.body);
                request.header.len = CONFIGURATION_WORDS as u32;
            } else if request.words().len() > CONFIGURATION_WORDS {
                let ordered = (request.header.step, i);
                newest = Some(newest.map_or(ordered, |newest| ordered.max(newest)));
            }
        }
        if let Some((_, from)) = newest {
            let (len, state) = (requests[from].header.len, requests[from].body);
            for request in requests.iter_mut() {
                request.body[CONFIGURATION_WORDS..].copy_from_slice(&state[CONFIGURATION_WORDS..]);
                request.header.len = len;
            }
        }
        requests.iter_mut().for_each(|request| request.header.step = step);
    }

    fn work(&self) -> Result<(), Closed> {
        if self.latency > 0 { self.sleep(self.waiter.now() + self.latency) } else { Ok(()) }
    }

    fn sleep(&self, until: Nanos) -> Result<(), Closed> {
        while self.waiter.now() < until {
            self.waiter.wait(Some(until))?;
        }
        Ok(())
    }

    fn aggregate(&mut self, request: &Message, reply: &mut Message) -> Result<(), Closed> {
        let began = self.waiter.now();
        match &mut self.sensors {
            RawSensors::Here(aggregator) => aggregator.answer(request, reply),
            RawSensors::Plant(sensor) => sensor.answer(request, reply, self.waiter)?,
        }
        self.waiter.sample(Sample::Worked(self.waiter.now().saturating_sub(began)));
        Ok(())
    }
}

/// Where the raw sensors of a VSP are.
pub(crate) enum RawSensors<V: VirtualSensor> {
    /// In its process.
    Here(Aggregator<V>),
    /// In the plant.
    Plant(PlantSensor),
}

/// A virtual sensor that answers orders.
pub(crate) struct Aggregator<V: VirtualSensor> {
    pub process: ProcessId,
    pub sensor: V,
}

impl<V: VirtualSensor> Aggregator<V> {
    /// What an order says: a configuration that cannot be read is a fault, never the default one.
    fn read(request: &Message) -> Result<ReadingOrder<<V::Kind as Sensor>::Configuration>, Fault> {
        let words = request.words();
        let unreadable = |what| move |_| Fault::new(FaultKind::Message).text(what);
        let configuration = Wire::get(words).map_err(unreadable("the sensor's configuration"))?;
        let robot = match words.get(CONFIGURATION_WORDS..) {
            Some(state) if !state.is_empty() => {
                Some(EffectorState::get(state).map_err(unreadable("the state of the sensor's robot"))?)
            }
            Some(_) | None => None,
        };
        Ok(ReadingOrder { configuration, robot, step: request.header.step })
    }

    /// The reading for an order, or the fault that there is none.
    pub fn answer(&mut self, request: &Message, reply: &mut Message) {
        reply.header.step = request.header.step;
        let result = Self::read(request).and_then(|order| {
            let aggregate = std::panic::AssertUnwindSafe(|| self.sensor.aggregate(&order));
            let aggregated = std::panic::catch_unwind(aggregate);
            aggregated
                .unwrap_or_else(|panic| Err(crate::fault::panicked(&*panic)))
                .map_err(Fault::thrown_by_program)
        });
        match result {
            Ok(reading) => {
                reply.header.kind = Kind::Reply;
                reply.header.len = <V::Kind as Sensor>::Reading::LEN as u32;
                reading.put(&mut reply.body);
            }
            Err(fault) => {
                let fault = fault.in_process(self.process).at_step(request.header.step);
                reply.set_fault(&fault);
            }
        }
    }
}
