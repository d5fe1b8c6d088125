//! A virtual sensor of a cell, and how its VSP comes to life.

use core::any::TypeId;
use core::time::Duration;
use std::rc::Rc;

use super::CellError;
use super::lower::scoped;
use super::robot::StateWanted;
use crate::control::opening::SensorOpening;
use crate::control::plant::Site;
use crate::control::replay::RecordedRun;
use crate::control::sensing::{Asking, Reads, Sensing, SensorPort, Source};
use crate::control::vsp::{Aggregator, AnyVirtualSensor, Boards, Orders, Vsp};
use crate::link::{Client, Link, Preparation, Server, Simulation};
use crate::model::fault::{ProcessId, Role};
use crate::model::image::Sensor;
use crate::model::name::Name;
use crate::model::sensor::{CONFIGURATION_WORDS, MAX_AGE, VirtualSensor, VspMode};
use crate::model::time::Nanos;
use crate::model::wire::{WORDS, Wire};
use crate::observe::layout::{HardwareLayout, SensorLayout};
use crate::observe::recording::{FramesTo, NotRecorded, Recorder};

/// A virtual sensor of a cell.
pub struct SensorSetup<V: VirtualSensor> {
    options: Options,
    sensor: V,
    configuration: <V::Kind as Sensor>::Configuration,
    stand_in: Option<Box<dyn AnyVirtualSensor>>,
}

/// What is said of a sensor whatever its kind.
struct Options {
    name: String,
    robot: Option<String>,
    /// The robots whose ECPs may read it; by default the one that it belongs to.
    readers: Option<Vec<String>>,
    mode: VspMode,
    latency: Duration,
    every: u32,
    stale_after: Option<Duration>,
}

impl<V: VirtualSensor> SensorSetup<V>
where
    <V::Kind as Sensor>::Configuration: Default,
{
    /// A sensor `name`, interactive, of no robot. The MP can read it.
    pub fn new(name: &str, sensor: V) -> Self {
        let options = Options {
            name: name.to_owned(),
            robot: None,
            readers: None,
            mode: VspMode::Interactive,
            latency: Duration::ZERO,
            every: 1,
            stale_after: None,
        };
        SensorSetup { options, sensor, configuration: Default::default(), stand_in: None }
    }
}

impl<V: VirtualSensor> SensorSetup<V> {
    /// The sensor belongs to a robot, whose state goes with every order. The robot's ECP can read it too, unless
    /// [`readers`](Self::readers) says otherwise.
    #[must_use]
    pub fn of(mut self, robot: &str) -> Self {
        self.options.robot = Some(robot.to_owned());
        self
    }

    /// The robots whose ECPs may read the sensor, whichever robot it belongs to; the MP always may. A camera over a conveyor
    /// belongs to the conveyor, whose encoder says where the parts are now, and is read by the arm that picks them:
    /// `.of("belt").readers(["arm"])`.
    ///
    /// An order that comes from elsewhere than the robot of the sensor goes with the state that the robot's EDP measured at
    /// the beginning of its last step.
    #[must_use]
    pub fn readers<'n>(mut self, robots: impl IntoIterator<Item = &'n str>) -> Self {
        self.options.readers = Some(robots.into_iter().map(str::to_owned).collect());
        self
    }

    /// A reading is ordered in every `steps`-th step only, by each process that reads the sensor; the steps between use the
    /// last one. By default one is ordered in every step. Not for free-running sensors, which have a period of their own.
    #[must_use]
    pub fn every(mut self, steps: u32) -> Self {
        self.options.every = steps;
        self
    }

    /// The age at which a reading is too old to move by, rounded up to whole steps: the Move or Wait that reads it then ends
    /// with the fault `SensorStale`. By default 20 steps.
    #[must_use]
    pub fn stale_after(mut self, age: Duration) -> Self {
        self.options.stale_after = Some(age);
        self
    }

    /// The sensor that takes the place of one with [hardware](VirtualSensor::hardware) where nothing real is to be read: in a dry
    /// run, with `--simulated`, under the virtual clock. It must have none itself.
    #[must_use]
    pub fn stand_in(mut self, sensor: impl VirtualSensor<Kind = V::Kind>) -> Self {
        self.stand_in = Some(Box::new(sensor));
        self
    }

    /// How the sensor and its requesters keep step.
    #[must_use]
    pub fn mode(mut self, mode: VspMode) -> Self {
        self.options.mode = mode;
        self
    }

    /// Time that one aggregation takes, under the virtual clock.
    #[must_use]
    pub fn latency(mut self, latency: Duration) -> Self {
        self.options.latency = latency;
        self
    }
}

impl Options {
    /// The place of the robot that it belongs to.
    fn robot_among(&self, robots: &[Name]) -> Result<Option<usize>, CellError> {
        let Some(robot) = &self.robot else { return Ok(None) };
        let found = robots.iter().position(|name| name.as_str() == robot);
        found.map(Some).ok_or(CellError::NoSuchRobot(Name::new(&self.name)?, robot.clone()))
    }

    /// The names of the robots whose ECPs may read it.
    fn reading_robots(&self) -> &[String] {
        match &self.readers {
            Some(readers) => readers,
            None => self.robot.as_slice(),
        }
    }

    /// Their places.
    fn readers_among(&self, robots: &[Name]) -> Result<Vec<usize>, CellError> {
        let place = |reader: &String| {
            let found = robots.iter().position(|name| name.as_str() == reader);
            found.ok_or(CellError::NoSuchReader(Name::new(&self.name)?, reader.clone()))
        };
        self.reading_robots().iter().map(place).collect()
    }

    /// How often it is asked, and how old its readings may be, in a cell of this step.
    fn asking(&self, step: Duration) -> Asking {
        let in_steps = |age: Duration| age.as_nanos().div_ceil(step.as_nanos().max(1));
        let max_age =
            self.stale_after.map_or(MAX_AGE, |age| u32::try_from(in_steps(age)).unwrap_or(u32::MAX));
        Asking { every: self.every.into(), max_age, step }
    }
}

/// What is known of a kind of sensors.
#[derive(Clone, Copy)]
struct KindFacts {
    name: &'static str,
    reads: Reads,
    reading_layout: u64,
    /// Lengths, in words.
    reading: usize,
    configuration: usize,
}

/// A virtual sensor of a cell, of any kind.
pub(super) struct CellSensor {
    options: Options,
    kind: KindFacts,
    sensor: Box<dyn AnyVirtualSensor>,
    /// The words of its default configuration.
    configuration: [u64; CONFIGURATION_WORDS],
    stand_in: Option<Box<dyn AnyVirtualSensor>>,
    /// The hardware in whose place it is.
    in_place_of: Option<String>,
}

impl<V: VirtualSensor> From<SensorSetup<V>> for CellSensor {
    fn from(setup: SensorSetup<V>) -> CellSensor {
        let kind = KindFacts {
            name: V::Kind::KIND,
            reads: Reads {
                kind: TypeId::of::<V::Kind>(),
                shape: <<V::Kind as Sensor>::Reading as Wire>::SHAPE,
            },
            reading_layout: <<V::Kind as Sensor>::Reading as Wire>::LAYOUT,
            reading: <<V::Kind as Sensor>::Reading as Wire>::LEN,
            configuration: <<V::Kind as Sensor>::Configuration as Wire>::LEN,
        };
        let mut configuration = [0; CONFIGURATION_WORDS];
        // Free-running sensors take it. One that is too long is refused by the check.
        let is_free = matches!(setup.options.mode, VspMode::NonInteractive(_));
        if is_free && kind.configuration <= CONFIGURATION_WORDS {
            setup.configuration.put(&mut configuration);
        }
        CellSensor {
            options: setup.options,
            kind,
            sensor: Box::new(setup.sensor),
            configuration,
            stand_in: setup.stand_in,
            in_place_of: None,
        }
    }
}

/// Who may read a sensor, and where: the MP and ECPs.
pub(super) struct Requesters<'a> {
    /// What a replay says was collected.
    pub recorded: Option<Rc<RecordedRun>>,
    pub link: &'a mut dyn Link,
    pub plant: &'a mut Site,
    pub step: Duration,
    pub mp: usize,
    pub robots: &'a [Name],
    /// The lower cell that it is in.
    pub within: Option<Name>,
    pub ecps: &'a [usize],
    pub mp_sensing: &'a mut Sensing,
    pub ecp_sensing: &'a mut [Sensing],
    /// Where frames go, and what writes them.
    pub frames: Option<(FramesTo, &'static dyn Recorder)>,
    /// Sensors that want the state of a robot from the robot's EDP.
    pub wanted: Vec<StateWanted>,
}

impl CellSensor {
    pub fn name(&self) -> &str {
        &self.options.name
    }

    pub fn layout(&self, step: Duration) -> SensorLayout {
        let options = &self.options;
        SensorLayout {
            name: options.name.clone(),
            kind: self.kind.name,
            of: options.robot.clone(),
            readers: options.reading_robots().to_vec(),
            every: options.every,
            stale_after: step.saturating_mul(options.asking(step).max_age),
            mode: options.mode,
            latency: options.latency,
            reading: self.kind.reads.shape,
            reading_layout: self.kind.reading_layout,
            hardware: HardwareLayout::of(self.sensor.hardware(), self.in_place_of.as_deref()),
        }
    }

    pub fn check(&self, name: Name, robots: &[Name], step: Duration) -> Vec<CellError> {
        let options = &self.options;
        let mut errors = Vec::new();
        if self.kind.configuration > CONFIGURATION_WORDS || self.kind.reading > WORDS {
            errors.push(CellError::TooLong(name));
        }
        if options.mode == VspMode::NonInteractive(Duration::ZERO) {
            errors.push(CellError::NoPeriod(name));
        }
        let is_there = |robot: &String| robots.iter().any(|name| name.as_str() == *robot);
        if let Some(robot) = options.robot.as_ref().filter(|robot| !is_there(robot)) {
            errors.push(CellError::NoSuchRobot(name, robot.clone()));
        }
        if let Some(readers) = &options.readers {
            let strangers = readers.iter().filter(|reader| !is_there(reader));
            errors.extend(strangers.map(|reader| CellError::NoSuchReader(name, reader.clone())));
        }
        let asking = options.asking(step);
        let is_free = matches!(options.mode, VspMode::NonInteractive(_));
        if asking.every == 0 || is_free && asking.every > 1 || asking.every > u64::from(asking.max_age) {
            errors.push(CellError::AskedEvery {
                sensor: name,
                every: options.every,
                max_age: asking.max_age,
            });
        }
        errors
    }

    /// What it opens in the world.
    pub fn hardware(&self) -> Option<String> {
        self.sensor.hardware()
    }

    /// The Python module by which a program of another sends what it reads.
    pub fn python(&self) -> Option<String> {
        self.sensor.python()
    }

    /// The same with what stands in for its hardware, if it has any.
    pub fn simulated(self) -> Result<Self, CellError> {
        let Some(hardware) = self.sensor.hardware() else { return Ok(self) };
        match self.stand_in.filter(|sensor| sensor.hardware().is_none()) {
            Some(sensor) => Ok(CellSensor { sensor, stand_in: None, in_place_of: Some(hardware), ..self }),
            None => Err(CellError::NoSensorStandIn { sensor: Name::new(&self.options.name)?, hardware }),
        }
    }

    /// In place of a process, what a recording says was collected.
    fn replay(&self, among: &mut Requesters<'_>, recorded: &RecordedRun) -> Result<(), CellError> {
        let name = Name::new(&self.options.name)?;
        // What was collected is there for every step, also for those without an order.
        let asking = Asking { every: 1, ..self.options.asking(among.step) };
        let port = |by| {
            let source = Source::Recorded(recorded.reading(name, by), self.options.mode);
            SensorPort::new(name, self.kind.reads, None, source, asking)
        };
        among.mp_sensing.ports.push(port(ProcessId::MP));
        for reader in self.options.readers_among(among.robots)? {
            let by = ProcessId::new(Role::Ecp, among.robots[reader]);
            among.ecp_sensing[reader].ports.push(port(by));
        }
        Ok(())
    }

    /// Puts its VSP on the link.
    pub fn spawn(self, among: &mut Requesters<'_>) -> Result<(), CellError> {
        if let Some(recorded) = among.recorded.clone() {
            return self.replay(among, &recorded);
        }
        let Requesters {
            link,
            plant,
            step,
            mp,
            robots,
            within,
            ecps,
            mp_sensing,
            ecp_sensing,
            wanted,
            frames,
            ..
        } = among;
        let options = self.options;
        let name = Name::new(&options.name)?;
        let robot = options.robot_among(robots)?;
        let process = ProcessId::new(Role::Vsp, scoped(name, *within)?);
        let place = link.place(process);
        let reads = self.kind.reads;
        let readers = options.readers_among(robots)?;
        let asking = options.asking(*step);
        let clients = core::iter::once(*mp).chain(readers.iter().map(|&reader| ecps[reader]));
        let mut servers: Vec<Box<dyn Server>> = Vec::new();
        let mut sources = Vec::new();
        let mut boards = Vec::new();
        for client in clients {
            let mut ask = |wrap: fn(Box<dyn Client>) -> Source| {
                let (client, server) = link.port(client, place);
                servers.push(server);
                wrap(client)
            };
            sources.push(match options.mode {
                VspMode::Interactive => ask(Source::Interactive),
                VspMode::WithDelay => ask(Source::WithDelay),
                VspMode::NonInteractive(_) => {
                    let board =
                        Boards { orders: link.board(client, place), readings: link.board(place, client) };
                    boards.push(board.clone());
                    Source::NonInteractive(board)
                }
            });
        }
        let mut sources = sources.into_iter();
        if let Some(source) = sources.next() {
            mp_sensing.ports.push(SensorPort::new(name, reads, robot, source, asking));
        }
        for (reader, source) in readers.into_iter().zip(sources) {
            // An ECP knows the state of its own robot only.
            let of = robot.filter(|robot| *robot == reader);
            ecp_sensing[reader].ports.push(SensorPort::new(name, reads, of, source, asking));
        }
        let state = robot.filter(|_| options.readers.is_some()).map(|robot| {
            let board = Rc::default();
            wanted.push(StateWanted { robot, vsp: place, board: Rc::clone(&board) });
            board
        });
        let mut sensor = self.sensor;
        let raw = plant.place_of(&*sensor).unwrap_or(place);
        if let Some((to, recorder)) = frames.as_ref().filter(|_| link.is_here(raw))
            && let Some(queue) = sensor.frames()
        {
            // Nobody waits for a thread in real time.
            let waits = link.simulation() != Simulation::Free;
            let begun = queue.write_to(&options.name, waits, recorder.frames(to, &options.name));
            begun.map_err(|error| NotRecorded::Frames(options.name.clone(), error.to_string()))?;
        }
        let configuration = self.configuration;
        let latency = options.latency.as_nanos() as Nanos;
        let orders = match options.mode {
            VspMode::Interactive | VspMode::WithDelay => Orders::Ports(servers),
            VspMode::NonInteractive(period) => Orders::Free { boards, period: period.as_nanos() as Nanos },
        };
        let step = step.as_nanos() as Nanos;
        let aggregator = Aggregator { process, sensor, unopened: None };
        let opening = Rc::new(SensorOpening::new(plant.take_sensor(*link, place, aggregator)));
        link.prepare(place, Rc::clone(&opening) as Rc<dyn Preparation>);
        link.body(
            place,
            Box::new(move |host| {
                let state = state.and_then(|board| board.get().map(Rc::clone));
                let Some(sensors) = opening.take() else { return };
                Vsp { sensors, configuration, host, orders, state, latency, step }.run();
            }),
        )?;
        Ok(())
    }
}
