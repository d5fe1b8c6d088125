//! A virtual sensor of a cell, and how its VSP comes to life.

use core::any::TypeId;
use core::time::Duration;
use std::rc::Rc;

use super::CellError;
use crate::control::plant::Site;
use crate::control::replay::RecordedRun;
use crate::control::sensing::{Reads, Sensing, SensorPort, Source};
use crate::control::vsp::{Aggregator, Boards, Orders, Vsp};
use crate::link::{Client, Link, Server};
use crate::model::fault::{ProcessId, Role};
use crate::model::image::Sensor;
use crate::model::name::Name;
use crate::model::sensor::{CONFIGURATION_WORDS, VirtualSensor, VspMode};
use crate::model::time::Nanos;
use crate::model::wire::{WORDS, Wire};
use crate::observe::layout::SensorLayout;

/// A virtual sensor of a cell.
pub struct SensorSetup<V: VirtualSensor> {
    name: String,
    sensor: V,
    configuration: <V::Kind as Sensor>::Configuration,
    robot: Option<String>,
    mode: VspMode,
    latency: Duration,
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
            mode: VspMode::Interactive,
            latency: Duration::ZERO,
        }
    }
}

impl<V: VirtualSensor> SensorSetup<V> {
    /// The sensor belongs to a robot: the robot's ECP can read it too, and its state goes with every order.
    #[must_use]
    pub fn of(mut self, robot: &str) -> Self {
        self.robot = Some(robot.to_owned());
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

    /// In place of a process, what a recording says was collected.
    fn replay(&self, among: &mut Requesters<'_>, recorded: &RecordedRun) -> Result<(), CellError> {
        let name = Name::new(&self.name)?;
        let robot = self.robot_among(among.robots)?;
        let port =
            |by| SensorPort::new(name, Self::reads(), robot, Source::Recorded(recorded.reading(name, by)));
        among.mp_sensing.ports.push(port(ProcessId::MP));
        if let Some(robot) = robot {
            let by = ProcessId::new(Role::Ecp, among.robots[robot]);
            among.ecp_sensing[robot].ports.push(port(by));
        }
        Ok(())
    }
}

/// A virtual sensor of any kind.
pub(super) trait AnySensor {
    fn name(&self) -> &str;
    fn layout(&self) -> SensorLayout;
    fn check(&self, name: Name, robots: &[Name]) -> Vec<CellError>;
    fn spawn(self: Box<Self>, among: &mut Requesters<'_>) -> Result<(), CellError>;
}

/// Who may read a sensor, and where: the MP, and the ECP of the robot that it belongs to.
pub(super) struct Requesters<'a> {
    /// What a replay says was collected.
    pub recorded: Option<Rc<RecordedRun>>,
    pub link: &'a mut dyn Link,
    pub plant: &'a mut Site,
    pub step: Duration,
    pub mp: usize,
    pub robots: &'a [Name],
    pub ecps: &'a [usize],
    pub mp_sensing: &'a mut Sensing,
    pub ecp_sensing: &'a mut [Sensing],
}

impl<V: VirtualSensor> AnySensor for SensorSetup<V> {
    fn name(&self) -> &str {
        &self.name
    }

    fn layout(&self) -> SensorLayout {
        SensorLayout {
            name: self.name.clone(),
            kind: V::Kind::KIND,
            of: self.robot.clone(),
            mode: self.mode,
            latency: self.latency,
            reading: Self::reads().shape,
        }
    }

    fn check(&self, name: Name, robots: &[Name]) -> Vec<CellError> {
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
        errors
    }

    fn spawn(self: Box<Self>, among: &mut Requesters<'_>) -> Result<(), CellError> {
        if let Some(recorded) = among.recorded.clone() {
            return self.replay(among, &recorded);
        }
        let Requesters { link, plant, step, mp, robots, ecps, mp_sensing, ecp_sensing, .. } = among;
        let name = Name::new(&self.name)?;
        let robot = self.robot_among(robots)?;
        let process = ProcessId::new(Role::Vsp, name);
        let place = link.place(process);
        let reads = Self::reads();
        let clients = [Some(*mp), robot.map(|robot| ecps[robot])];
        let mut servers: Vec<Box<dyn Server>> = Vec::new();
        let mut sources = Vec::new();
        let mut boards = Vec::new();
        for client in clients.into_iter().flatten() {
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
            mp_sensing.ports.push(SensorPort::new(name, reads, robot, source));
        }
        if let (Some(robot), Some(source)) = (robot, sources.next()) {
            ecp_sensing[robot].ports.push(SensorPort::new(name, reads, Some(robot), source));
        }
        let sensor = self.sensor;
        let configuration = self.configuration;
        let latency = self.latency.as_nanos() as Nanos;
        let orders = match self.mode {
            VspMode::Interactive | VspMode::WithDelay => Orders::Ports(servers),
            VspMode::NonInteractive(period) => Orders::Free { boards, period: period.as_nanos() as Nanos },
        };
        let step = step.as_nanos() as Nanos;
        let sensors = plant.take_sensor(*link, place, Aggregator { process, sensor });
        link.body(
            place,
            Box::new(move |host| {
                Vsp { sensors, configuration, host, orders, latency, step }.run();
            }),
        )?;
        Ok(())
    }
}
