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
use crate::control::vsp::{Aggregator, Boards, Orders, Vsp};
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
    name: String,
    sensor: V,
    configuration: <V::Kind as Sensor>::Configuration,
    robot: Option<String>,
    /// The robots whose ECPs may read it; by default the one that it belongs to.
    readers: Option<Vec<String>>,
    mode: VspMode,
    latency: Duration,
    every: u32,
    stale_after: Option<Duration>,
    stand_in: Option<Box<dyn VirtualSensor<Kind = V::Kind>>>,
    /// The hardware in whose place it is.
    in_place_of: Option<String>,
}

impl<V: VirtualSensor> SensorSetup<V>
where
    <V::Kind as Sensor>::Configuration: Default,
{
    /// A sensor `name`, interactive, of no robot. The MP can read it.
    pub fn new(name: &str, sensor: V) -> Self {
        SensorSetup {
            name: name.to_owned(),
            sensor,
            configuration: Default::default(),
            robot: None,
            readers: None,
            mode: VspMode::Interactive,
            latency: Duration::ZERO,
            every: 1,
            stale_after: None,
            stand_in: None,
            in_place_of: None,
        }
    }
}

impl<V: VirtualSensor> SensorSetup<V> {
    /// The sensor belongs to a robot, whose state goes with every order. The robot's ECP can read it too, unless
    /// [`readers`](Self::readers) says otherwise.
    #[must_use]
    pub fn of(mut self, robot: &str) -> Self {
        self.robot = Some(robot.to_owned());
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
        self.readers = Some(robots.into_iter().map(str::to_owned).collect());
        self
    }

    /// A reading is ordered in every `steps`-th step only, by each process that reads the sensor; the steps between use the
    /// last one. By default one is ordered in every step. Not for free-running sensors, which have a period of their own.
    #[must_use]
    pub fn every(mut self, steps: u32) -> Self {
        self.every = steps;
        self
    }

    /// The age at which a reading is too old to move by, rounded up to whole steps: the Move or Wait that reads it then ends
    /// with the fault `SensorStale`. By default 20 steps.
    #[must_use]
    pub fn stale_after(mut self, age: Duration) -> Self {
        self.stale_after = Some(age);
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
        self.mode = mode;
        self
    }

    /// Time that one aggregation takes, under the virtual clock.
    #[must_use]
    pub fn latency(mut self, latency: Duration) -> Self {
        self.latency = latency;
        self
    }
}

impl<V: VirtualSensor> SensorSetup<V> {
    /// What its readings are.
    const fn reads() -> Reads {
        Reads { kind: TypeId::of::<V::Kind>(), shape: <<V::Kind as Sensor>::Reading as Wire>::SHAPE }
    }

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
        Asking { every: self.every.into(), max_age }
    }

    /// In place of a process, what a recording says was collected.
    fn replay(&self, among: &mut Requesters<'_>, recorded: &RecordedRun) -> Result<(), CellError> {
        let name = Name::new(&self.name)?;
        // What was collected is there for every step, also for those without an order.
        let asking = Asking { every: 1, ..self.asking(among.step) };
        let port = |by| {
            let source = Source::Recorded(recorded.reading(name, by), self.mode);
            SensorPort::new(name, Self::reads(), None, source, asking)
        };
        among.mp_sensing.ports.push(port(ProcessId::MP));
        for reader in self.readers_among(among.robots)? {
            let by = ProcessId::new(Role::Ecp, among.robots[reader]);
            among.ecp_sensing[reader].ports.push(port(by));
        }
        Ok(())
    }
}

/// A virtual sensor of any kind.
pub(super) trait AnySensor {
    fn name(&self) -> &str;
    fn layout(&self, step: Duration) -> SensorLayout;
    fn check(&self, name: Name, robots: &[Name], step: Duration) -> Vec<CellError>;
    /// What it opens in the world.
    fn hardware(&self) -> Option<String>;
    /// The Python module by which a program of another sends what it reads.
    fn python(&self) -> Option<String>;
    /// The same with what stands in for its hardware, if it has any.
    fn simulated(self: Box<Self>) -> Result<Box<dyn AnySensor>, CellError>;
    fn spawn(self: Box<Self>, among: &mut Requesters<'_>) -> Result<(), CellError>;
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

impl<V: VirtualSensor> AnySensor for SensorSetup<V> {
    fn name(&self) -> &str {
        &self.name
    }

    fn layout(&self, step: Duration) -> SensorLayout {
        SensorLayout {
            name: self.name.clone(),
            kind: V::Kind::KIND,
            of: self.robot.clone(),
            readers: self.reading_robots().to_vec(),
            every: self.every,
            stale_after: step.saturating_mul(self.asking(step).max_age),
            mode: self.mode,
            latency: self.latency,
            reading: Self::reads().shape,
            reading_layout: <<V::Kind as Sensor>::Reading as Wire>::LAYOUT,
            hardware: HardwareLayout::of(self.sensor.hardware(), self.in_place_of.as_deref()),
        }
    }

    fn check(&self, name: Name, robots: &[Name], step: Duration) -> Vec<CellError> {
        let mut errors = Vec::new();
        if <<V::Kind as Sensor>::Configuration as Wire>::LEN > CONFIGURATION_WORDS
            || <<V::Kind as Sensor>::Reading as Wire>::LEN > WORDS
        {
            errors.push(CellError::TooLong(name));
        }
        if self.mode == VspMode::NonInteractive(Duration::ZERO) {
            errors.push(CellError::NoPeriod(name));
        }
        if let Some(robot) =
            self.robot.as_ref().filter(|robot| robots.iter().all(|name| name.as_str() != *robot))
        {
            errors.push(CellError::NoSuchRobot(name, robot.clone()));
        }
        if let Some(readers) = &self.readers {
            let strangers =
                readers.iter().filter(|reader| robots.iter().all(|name| name.as_str() != **reader));
            errors.extend(strangers.map(|reader| CellError::NoSuchReader(name, reader.clone())));
        }
        let asking = self.asking(step);
        let is_free = matches!(self.mode, VspMode::NonInteractive(_));
        if asking.every == 0 || is_free && asking.every > 1 || asking.every > u64::from(asking.max_age) {
            errors.push(CellError::AskedEvery { sensor: name, every: self.every, max_age: asking.max_age });
        }
        errors
    }

    fn hardware(&self) -> Option<String> {
        self.sensor.hardware()
    }

    fn python(&self) -> Option<String> {
        self.sensor.python()
    }

    fn simulated(self: Box<Self>) -> Result<Box<dyn AnySensor>, CellError> {
        let Some(hardware) = self.sensor.hardware() else { return Ok(self) };
        let SensorSetup { name, configuration, robot, readers, mode, latency, every, stale_after, .. } =
            *self;
        match self.stand_in.filter(|sensor| sensor.hardware().is_none()) {
            Some(sensor) => Ok(Box::new(SensorSetup {
                name,
                sensor,
                configuration,
                robot,
                readers,
                mode,
                latency,
                every,
                stale_after,
                stand_in: None,
                in_place_of: Some(hardware),
            })),
            None => Err(CellError::NoSensorStandIn { sensor: Name::new(&name)?, hardware }),
        }
    }

    fn spawn(self: Box<Self>, among: &mut Requesters<'_>) -> Result<(), CellError> {
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
        let name = Name::new(&self.name)?;
        let robot = self.robot_among(robots)?;
        let process = ProcessId::new(Role::Vsp, scoped(name, *within)?);
        let place = link.place(process);
        let reads = Self::reads();
        let readers = self.readers_among(robots)?;
        let asking = self.asking(*step);
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
            sources.push(match self.mode {
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
        let state = robot.filter(|_| self.readers.is_some()).map(|robot| {
            let board = Rc::default();
            wanted.push(StateWanted { robot, vsp: place, board: Rc::clone(&board) });
            board
        });
        let mut sensor = self.sensor;
        let raw = plant.place_of(&sensor).unwrap_or(place);
        if let Some((to, recorder)) = frames.as_ref().filter(|_| link.is_here(raw))
            && let Some(queue) = sensor.frames()
        {
            // Nobody waits for a thread in real time.
            let waits = link.simulation() != Simulation::Free;
            let begun = queue.write_to(&self.name, waits, recorder.frames(to, &self.name));
            begun.map_err(|error| NotRecorded::Frames(self.name.clone(), error.to_string()))?;
        }
        let configuration = self.configuration;
        let latency = self.latency.as_nanos() as Nanos;
        let orders = match self.mode {
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
