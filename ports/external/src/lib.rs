//! Programs of others in a cell: virtual sensors whose readings a program of another sends, one in Python, say, with a camera and a
//! network in it; robots that move in a simulator of others ([`plant`](fn@plant)); and programs that subscribe ([`Subscribers`]).
//!
//! In: messages over shared memory, and what `cell.toml` says may be believed of them. Out: a
//! [`VirtualSensor`]. The program is a process of its own that nobody waits for: one that hangs is a reading that gets
//! older, until the Move or Wait that reads it ends with `SensorStale` and the robots stop on their paths; one that lies
//! is a `SensorFailed`.
//!
//! ```
//! use mrroc::payload::Payload;
//! use mrroc::sensor::{ReadingOrder, Sensor, VirtualSensor};
//! use mrroc_external::External;
//! # use mrroc::fault::Fault;
//! # use mrroc_launch::cell_file::CellFile;
//!
//! /// Where a part lies on the table.
//! #[derive(Clone, Copy, Payload)]
//! pub struct Part { pub x: f64, pub y: f64 }
//!
//! pub struct Camera;
//!
//! impl Sensor for Camera {
//!     const KIND: &'static str = "camera";
//!     type Reading = Part;
//!     type Configuration = ();
//! }
//!
//! /// What is read where no program is: under the virtual clock.
//! struct Table;
//!
//! impl VirtualSensor for Table {
//!     type Kind = Camera;
//!     fn aggregate(&mut self, _: &ReadingOrder<()>) -> Result<Part, Fault> {
//!         Ok(Part { x: 0.4, y: 0.1 })
//!     }
//! }
//!
//! let file = CellFile::parse("cell.toml", r#"
//! step_ms = 2
//! robots.arm = { kind = "irp6", start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0] }
//!
//! [sensors.camera]
//! mode = "free running"
//! period_ms = 5
//! stale_after_ms = 200
//!
//! [sensors.camera.external]
//! rate_hz = 30.0
//! least = [0.0, -0.5]
//! largest = [1.0, 0.5]
//! "#)?;
//! let camera = External::<Camera>::in_cell(&file, "camera")?.stand_in(Table);
//! # let _ = camera;
//! # Ok::<(), mrroc::cell::CellError>(())
//! ```
//!
//! `cargo run -- external camera > camera_port.py` prints the module by which a Python program sends what it measures; the
//! book's page on programs of others has one of fifteen lines. Programs in other languages speak the same messages:
//!
//! # The port
//!
//! Two services of [iceoryx2](https://docs.rs/iceoryx2) 0.10, publish-subscribe, `mrroc/PORT/orders` and
//! `mrroc/PORT/readings`, with one publisher each, 8 subscribers, a buffer of one message, no history and safe overflow. Their root
//! path is `/tmp/mrroc-ports-UID`, or what `MRROC_PORTS` names, a folder of mode 0700; names of shared memory begin with
//! `mrroc_ports_HASH_`, the FNV-1a hash of that path as 16 hexadecimal digits. Both carry the type `mrroc_external_1`, 544
//! bytes, little-endian, at multiples of 8:
//!
//! | offset | type | of a reading | of an order |
//! |---|---|---|---|
//! | 0 | `u32` | version of this interface: 1 | the same |
//! | 4 | `u32` | how many words a reading has | how many words follow: 16 without the state of a robot, more with it |
//! | 8 | `u64` | layout of a reading: a hash of its type, in the Python module | layout of the configuration |
//! | 16 | `u64` | step of the order that it was measured for, 0 for none | the step of the order |
//! | 24 | `u64` | when it was measured, `CLOCK_MONOTONIC` \[ns\] | when it was sent |
//! | 32 | `[u64; 64]` | the words of the reading, one for each number: the bits of an `f64`, a `bool` as 0 or 1 | 16 words of the configuration; then the state of the sensor's robot: joint positions, joint velocities, position and quaternion x, y, z, w of the tool in the world, and, of robots that tell it, force and torque |
//!
//! A reading counts from the time at which it was measured, not from that at which it came. One of the future, of another
//! version or layout, or with a number beyond what `cell.toml` allows, is a fault of the sensor, `SensorFailed`, until one
//! comes that is none.
//!
//! # From another machine
//!
//! With `address` in `[sensors.NAME.external]` the port is reached over [zenoh](https://zenoh.io) 1, by QUIC with certificates of
//! both sides, peer to peer at that address, with low-latency transport and without scouting. A program declares the liveliness token
//! `mrroc/@sensor/NAME/@program/NUMBER` with a number of its own (1 to 2^63), subscribes to `mrroc/@sensor/NAME/orders` and puts to
//! `mrroc/@sensor/NAME/readings`. The messages are those above, with some words before them:
//!
//! | offset | type | of a reading, 568 bytes | of an order, 560 bytes; 16 bytes while there is none |
//! |---|---|---|---|
//! | 0 | `u64` | the program's number | the number of the program whose readings count, 0 for none; a program that reads another number than its own or 0 must end |
//! | 8 | `u64` | the word at 8 of the newest order that has come; 0 before the first | when it was sent, by the clock of the cell's machine \[ns\] |
//! | 16 | `u64` | when that order came, `CLOCK_MONOTONIC` of the program's machine \[ns\] | here the message begins |
//!
//! The message of a reading has its time by the clock of the program's machine. The difference of the two clocks is taken from those
//! words, so that a reading counts as older by the time that an order needs to the program, and never as newer than it is.
//!
//! # The port of a simulator
//!
//! For each robot in it two services as above, `mrroc/PORT/ROBOT/orders`, of which 64 messages are kept, and
//! `mrroc/PORT/ROBOT/states`, of which one is. They carry the types `mrroc_plant_order_1`, 152 bytes, and `mrroc_plant_state_1`,
//! 248 bytes, little-endian:
//!
//! | offset | type | of an order |
//! |---|---|---|
//! | 0 | `u32` | version of this interface: 1 |
//! | 4 | `u32` | 1: stand at these positions, and say where you are; 2: be there at the end of the period; 3: no power, brakes applied; 4: the end |
//! | 8 | `u64` | a hash of the fields of both messages, in the Python module |
//! | 16 | `u64` | which opening of the port this is; every state repeats it |
//! | 24 | `u64` | the servo period, counted from the cell's start; of 1 the first that will be ordered |
//! | 32 | `u64` | when it was sent, `CLOCK_MONOTONIC` \[ns\] |
//! | 40 | `u64` | how long a period is \[ns\] |
//! | 48 | `u64` | answers that were late so far, in real time |
//! | 56 | `u32` | 0: under the virtual clock, 1: in real time |
//! | 60 | `u32` | how many joints the robot has |
//! | 64 | `[u8; 24]` | the robot's name, and zeros |
//! | 88 | `[f64; 8]` | positions of its joints \[rad or m\] |
//!
//! | offset | type | of a state |
//! |---|---|---|
//! | 0 | `u32` | version of this interface: 1 |
//! | 4 | `u32` | 1: it stands where it begins; 2: at the end of the period; 3: the simulation cannot go on |
//! | 8 | `u64` | the hash |
//! | 16, 24 | `u64` | of the order that it answers: which opening, which period |
//! | 32 | `u64` | when it was sent, `CLOCK_MONOTONIC` \[ns\] |
//! | 40 | `u32` | how many joints the robot has |
//! | 44 | `u32` | 1: the wrench says something |
//! | 48 | `[u8; 24]` | the robot's name, and zeros |
//! | 72, 136 | `[f64; 8]` | positions \[rad or m\] and velocities \[rad/s or m/s\] of its joints |
//! | 200 | `[f64; 6]` | force \[N\] and torque \[N m\] of the surroundings on the flange, in its axes |
//!
//! The simulator answers a period when it has simulated it, which it does when it has the orders of all robots that have begun. Under the
//! virtual clock the cell waits for that; the answer is what its robots measure in the next period.

//! # The port of subscribers
//!
//! For each robot of the cell `mrroc/PORT/ROBOT/images`, and `mrroc/PORT/steps` of the coordinator; `mrroc/PORT/sensors` for the readings that the
//! coordinator collects, and `mrroc/PORT/ROBOT/sensors` for those of a robot's ECP. Of each 256 messages are kept; nobody sends anything back. They carry the
//! types `mrroc_image_1`, 464 bytes, `mrroc_step_1`, 296 bytes, and `mrroc_reading_1`, 584 bytes, little-endian. A message of a robot and of the coordinator is sent
//! for each step; one that is missing was lost. A reading is sent for each step in which it is collected, new or not.
//!
//! | offset | type | of a robot |
//! |---|---|---|
//! | 0, 4 | `u32` | version of this interface: 1; how many joints the robot has |
//! | 8 | `u64` | the step |
//! | 16 | `u64` | its time on the cell's clock \[ns\] |
//! | 24 | `u64` | when it was sent, `CLOCK_MONOTONIC` \[ns\] |
//! | 32 | `u64` | 0: it holds; 1: moves; 2: goes on without a demand that is missing; 3: brakes; 4: has no power |
//! | 40, 104 | `[f64; 8]` | demanded positions \[rad or m\] and velocities \[rad/s or m/s\] of its joints |
//! | 168 | `[f64; 7]` | demanded position \[m\] and quaternion x, y, z, w of the tool in the world |
//! | 224, 288, 352 | as before | the same as measured |
//! | 408 | `[f64; 7]` | the tool on the flange: position \[m\] and quaternion |
//!
//! | offset | type | of the coordinator |
//! |---|---|---|
//! | 0 | `u32` | version of this interface: 1 |
//! | 4 | `u32` | bits: 0 suspended, 1 reduced speed, 2 aborting, 3 stopping, 4 its program is over |
//! | 8, 16, 24 | `u64` | as above |
//! | 32, 40 | `f64` | path time and time of the step \[s\] |
//! | 48 | `f64` | the speed that the operator wants, 0 to 1 |
//! | 56 | `[u8; 240]` | the first fault since the last reset, as text, and zeros |
//!
//! | offset | type | of a reading |
//! |---|---|---|
//! | 0, 4 | `u32` | version of this interface: 1; how many words the reading has: further ones of its type count as 0 |
//! | 8 | `u64` | layout of the reading: a hash of its type, in the Python module |
//! | 16, 24, 32 | `u64` | the step in which it was collected, its time, and when this was sent, as above |
//! | 40 | `u64` | the step in which it was taken: by so much it is older |
//! | 48 | `[u8; 24]` | the sensor's name, and zeros |
//! | 72 | `[u64; 64]` | the words of the reading, as at the port of the sensor |

mod gateway;
pub mod goals;
mod message;
mod numbers;
mod plant;
mod port;
mod python;
mod sender;
mod subscribers;
#[cfg(test)]
mod tests;

use core::fmt;
use core::marker::PhantomData;
use core::time::Duration;
use std::net::SocketAddr;
use std::path::PathBuf;

use mrroc::cell::{CellError, SensorSetup};
use mrroc::fault::{Fault, FaultKind};
use mrroc::payload::Wire;
use mrroc::sensor::{EffectorState, ReadingOrder, Sensor, Taken, VirtualSensor};
use mrroc_launch::cell_file::{CellFile, ExternalEntry};
use mrroc_launch::network::gateways_by;

pub use goals::{Goals, TrajectoryGoals};
pub use plant::plant;
pub use port::{monotonic, port_of_cell};
pub use sender::{Sender, WordSender};
pub use subscribers::{Image, ReadingShown, State, StepShown, Subscriber, Subscribers};

use gateway::GatewayProcess;
use message::{Foreign, Message, VERSION};
use numbers::Numbers;
use port::Port;

/// Words of an order that say the configuration.
const CONFIGURATION_WORDS: usize = 16;

/// How long a cell waits for the program before it begins \[ns\], and how often it looks.
const TIMEOUT: u64 = 10_000_000_000;
const LOOK: Duration = Duration::from_millis(5);

/// A sensor whose readings a program of another sends.
pub struct External<K: Sensor> {
    name: String,
    port_name: String,
    /// The folder of ports.
    folder: PathBuf,
    rate: f64,
    /// The step of the cell \[ns\].
    step: u64,
    numbers: Numbers,
    /// How long the program may take to send something before the cell begins without it \[ns\].
    timeout: u64,
    /// Of a program on another machine: where it calls, and the cell file.
    elsewhere: Option<(SocketAddr, PathBuf)>,
    // It ends before the port, which removes what a killed one leaves.
    gateway: Option<GatewayProcess>,
    port: Option<Port>,
    /// The last message that was believed.
    last: Option<Message>,
    /// Its reading, and the step in which it was measured; or why the newest message is not believed.
    newest: Option<Result<(K::Reading, u64), Fault>>,
    kind: PhantomData<K>,
}

impl<K: Sensor> fmt::Debug for External<K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "External({} at port {})", self.name, self.port_name)
    }
}

impl<K: Sensor> External<K> {
    /// The sensor `name` of the cell file, with what its tables `[sensors.NAME]` and `[sensors.NAME.external]` say.
    ///
    /// # Errors
    /// The file has no such sensor, says nothing of such a program, or has another number of bounds than a reading has numbers.
    pub fn in_cell(file: &CellFile, name: &str) -> Result<SensorSetup<Self>, CellError>
    where
        K::Configuration: Default,
    {
        gateways_by(gateway::run);
        file.sensor(name, Self::new(file.external(name)?)?)
    }

    fn new(entry: &ExternalEntry) -> Result<Self, CellError> {
        let shape = <K::Reading as Wire>::SHAPE;
        let believable = entry.believable(&numbers::names(shape).unwrap_or_default())?;
        let numbers = Numbers::new(shape, believable).ok_or_else(|| entry.refuse_reading(K::KIND))?;
        let sensor = Self::of(entry, numbers);
        Ok(if entry.topic().is_some() { sensor.at(port_of_cell(entry)) } else { sensor })
    }

    /// Of a reading with these numbers.
    fn of(entry: &ExternalEntry, numbers: Numbers) -> Self {
        External {
            name: entry.name().to_owned(),
            port_name: entry.port().to_owned(),
            folder: port::folder(),
            rate: entry.rate(),
            step: u64::try_from(entry.step().as_nanos()).unwrap_or(u64::MAX).max(1),
            numbers,
            timeout: TIMEOUT,
            elsewhere: entry.address().map(|address| (address, entry.cell_file().to_owned())),
            gateway: None,
            port: None,
            last: None,
            newest: None,
            kind: PhantomData,
        }
    }

    /// At another port than the file says.
    fn at(mut self, port: String) -> Self {
        self.port_name = port;
        self
    }

    /// The order as a message, sent now.
    fn order(order: &ReadingOrder<K::Configuration>, now: u64) -> Message {
        let layout = <K::Configuration as Wire>::LAYOUT;
        let mut message = Message { version: VERSION, layout, step: order.step, time: now, ..Message::EMPTY };
        order.configuration.put(&mut message.words);
        let mut len = CONFIGURATION_WORDS;
        if let Some(state) = &order.robot {
            state.put(&mut message.words[CONFIGURATION_WORDS..]);
            len += EffectorState::used(state);
        }
        message.len = len as u32;
        message
    }

    /// Looks at the newest message, which came in the step of an order.
    fn hear(&mut self, message: &Message, step: u64, now: u64) {
        let last = self.last.as_ref();
        if last.is_some_and(|last| message.version == VERSION && message.time <= last.time) {
            return; // the same measurement again, or one before it
        }
        match self.believe(message, now) {
            // One that was measured before the cell began is none of it.
            Ok(reading) => {
                let age = now.saturating_sub(message.time).div_ceil(self.step);
                self.newest = step.checked_sub(age).map(|taken| Ok((reading, taken))).or(self.newest.take());
                self.last = Some(*message);
            }
            Err(fault) => self.newest = Some(Err(fault)),
        }
    }

    /// Waits for a first message, so that programs and cell can be started in either order. What is wrong with it is told when the program
    /// sends the next one, and if none comes, that is told by whoever reads the sensor.
    fn await_program(&self) {
        let until = monotonic().saturating_add(self.timeout);
        let has_come = || self.port.as_ref().is_none_or(|port| port.newest().is_some());
        while !has_come() && monotonic() < until {
            std::thread::sleep(LOOK);
        }
    }

    fn believe(&self, message: &Message, now: u64) -> Result<K::Reading, Fault> {
        let fault = |text: &str| Fault::new(FaultKind::SensorFailed).text(text);
        let (layout, len) = (<K::Reading as Wire>::LAYOUT, <K::Reading as Wire>::LEN);
        let words = message.reading(layout, len).map_err(|foreign| match foreign {
            Foreign::Version(version) => fault("its program has another version of the port").exceeds(
                version.into(),
                VERSION.into(),
                "",
            ),
            Foreign::Layout => fault("its program sends other fields: make its module anew"),
            Foreign::Len(words) => {
                fault("its program sends another number of words").exceeds(words.into(), len as f64, "")
            }
        })?;
        if message.time > now {
            let ahead = (message.time - now) as f64 / 1e6;
            return Err(fault("a reading of the future: its time is that of CLOCK_MONOTONIC")
                .exceeds(ahead, 0.0, "ms"));
        }
        let last = self.last.as_ref().and_then(|last| {
            let time = (message.time - last.time) as f64 / 1e9;
            Some((last.words.get(..len)?, time))
        });
        self.numbers.check(words, last)?;
        K::Reading::get(words).map_err(|_| fault("its program sends a value that its type does not have"))
    }
}

impl<K: Sensor> VirtualSensor for External<K> {
    type Kind = K;

    fn hardware(&self) -> Option<String> {
        Some(match &self.elsewhere {
            None => format!("external port {}", self.port_name),
            Some((address, _)) => {
                format!("external port {}, from another machine at {address}", self.port_name)
            }
        })
    }

    fn open(&mut self) -> Result<(), Fault> {
        // What an attempt before has left is in the way of this one.
        (self.gateway, self.port) = (None, None);
        let port = Port::open(&self.folder, &self.port_name);
        let failed = |why: String| Fault::new(FaultKind::SensorFailed).text(&why);
        self.port = Some(port.map_err(failed)?);
        if let Some((_, cell)) = &self.elsewhere {
            self.gateway = Some(GatewayProcess::start(cell, &self.name).map_err(failed)?);
        }
        self.await_program();
        Ok(())
    }

    fn taken(&mut self, order: &ReadingOrder<K::Configuration>) -> Taken {
        let now = monotonic();
        let Some(port) = &self.port else { return Taken::NotYet };
        port.order(Self::order(order, now));
        if let Some(message) = port.newest() {
            // The message may have been written after `now`.
            self.hear(&message, order.step, monotonic());
        }
        match &self.newest {
            None => Taken::NotYet,
            Some(Ok((_, taken))) => Taken::In(*taken),
            Some(Err(_)) => Taken::In(order.step),
        }
    }

    fn aggregate(&mut self, _: &ReadingOrder<K::Configuration>) -> Result<K::Reading, Fault> {
        match &self.newest {
            Some(Ok((reading, _))) => Ok(*reading),
            Some(Err(fault)) => Err(fault.clone()),
            None => Err(Fault::new(FaultKind::SensorFailed).text("its program has sent nothing yet")),
        }
    }

    fn python(&self) -> Option<String> {
        Some(python::module::<K>(
            &self.name,
            &self.port_name,
            self.rate,
            self.elsewhere.as_ref().map(|(address, _)| *address),
        ))
    }
}
