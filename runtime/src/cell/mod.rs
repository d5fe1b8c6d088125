//! A cell: robots, virtual sensors and programs, put together and run.
//!
//! In: set-ups. Out: a run, or everything that is wrong with them before anything moves.

mod error;
mod limits;

use core::any::TypeId;
use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use crate::driver::Driver;
use crate::ecp::{Ecp, Pace};
use crate::edp::{Edp, EdpConfig, Observer, ServoRecord};
use crate::fault::{Fault, FaultKind, ProcessId, Role};
use crate::image::Sensor;
use crate::link::memory::{Scheduler, Stuck};
use crate::link::{Client, Nanos, Server};
use crate::mp::{Mp, RobotPort, StepHook};
use crate::name::Name;
use crate::operator::Operator;
use crate::payload::Nudge;
use crate::pose::Pose;
use crate::robot::Robot;
use crate::sensing::{Sensing, SensorPort, Source};
use crate::stopping::{STOP_TIME, missed_step_budget, stop_steps};
use crate::vsp::{Boards, CONFIGURATION_WORDS, Orders, VirtualSensor, Vsp, VspMode};
use crate::wire::{WORDS, Wire};

pub use error::CellError;

/// What a run took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunReport {
    /// Steps.
    pub steps: u64,
    /// Time on the cell's clock.
    pub time: Duration,
}

type EcpProgram<R> = Box<dyn FnOnce(&mut Ecp<R>) -> Result<(), Fault>>;
type MpProgram = Box<dyn FnOnce(&mut Mp) -> Result<(), Fault>>;
type Outcomes = Rc<RefCell<Vec<(ProcessId, Result<(), Fault>)>>>;

/// A robot of a cell: its model, its drives and its program.
pub struct RobotSetup<R: Robot> {
    name: String,
    robot: R,
    driver: Box<dyn Driver<R>>,
    tool: Pose,
    following_error: R::Joints,
    program: Option<EcpProgram<R>>,
    observers: Vec<Observer<R>>,
}

impl<R: Robot> RobotSetup<R> {
    /// A robot `name` with its drives. Its following error may be what its velocity limit covers in 50 ms.
    pub fn new(name: &str, robot: R, driver: impl Driver<R> + 'static) -> Self {
        let following_error = robot.limits().velocity * 0.05;
        RobotSetup {
            name: name.to_owned(),
            driver: Box::new(driver),
            tool: Pose::identity(),
            following_error,
            program: None,
            observers: Vec::new(),
            robot,
        }
    }

    /// The tool at the start: `X_FE`, the tool frame in the flange frame.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn tool(mut self, X_FE: Pose) -> Self {
        self.tool = X_FE;
        self
    }

    /// The largest difference between demanded and measured joint positions [rad or m], each > 0.
    #[must_use]
    pub fn following_error(mut self, limit: R::Joints) -> Self {
        self.following_error = limit;
        self
    }

    /// The program of the robot's ECP. Without one the ECP is transparent: it passes the MP's demands on.
    #[must_use]
    pub fn program(mut self, program: impl FnOnce(&mut Ecp<R>) -> Result<(), Fault> + 'static) -> Self {
        self.program = Some(Box::new(program));
        self
    }

    /// Calls `observer` after every servo period.
    #[must_use]
    pub fn observe(mut self, observer: impl FnMut(&ServoRecord<R>) + 'static) -> Self {
        self.observers.push(Box::new(observer));
        self
    }
}

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

/// A set-up cell.
pub struct Cell {
    step: Duration,
    stop_time: Duration,
    rate_change: f64,
    robots: Vec<Box<dyn AnyRobot>>,
    sensors: Vec<Box<dyn AnySensor>>,
    program: Option<MpProgram>,
    operator: Operator,
    hook: Option<StepHook>,
}

impl Cell {
    /// A cell of this step, 1 ms, 2 ms ..
    #[must_use]
    pub fn new(step: Duration) -> Cell {
        Cell {
            step,
            stop_time: STOP_TIME,
            rate_change: crate::feed::DEFAULT_CHANGE,
            robots: Vec::new(),
            sensors: Vec::new(),
            program: None,
            operator: Operator::new(),
            hook: None,
        }
    }

    /// The longest time from the cause of a stop to a standstill that the cell allows any joint, 600 ms unless it says
    /// otherwise: time to notice a lost peer and to brake from the velocity limit, `v / a + 2.5 a / j`. A cell with
    /// a joint that would take longer does not run.
    #[must_use]
    pub fn stop_time(mut self, limit: Duration) -> Cell {
        self.stop_time = limit;
        self
    }

    /// Adds a robot.
    #[must_use]
    pub fn robot<R: Robot>(mut self, setup: RobotSetup<R>) -> Cell {
        self.robots.push(Box::new(setup));
        self
    }

    /// Adds a virtual sensor.
    #[must_use]
    pub fn sensor<V: VirtualSensor>(mut self, setup: SensorSetup<V>) -> Cell {
        self.sensors.push(Box::new(setup));
        self
    }

    /// The program of the MP. Without one the MP nudges: it starts every ECP's program and waits for all.
    #[must_use]
    pub fn program(mut self, program: impl FnOnce(&mut Mp) -> Result<(), Fault> + 'static) -> Cell {
        self.program = Some(Box::new(program));
        self
    }

    /// Calls `hook` at the start of every step with its index and the operator: for a progress bar, or an
    /// operator that acts in known steps.
    #[must_use]
    pub fn on_step(mut self, hook: impl FnMut(u64, &Operator) + 'static) -> Cell {
        self.hook = Some(Box::new(hook));
        self
    }

    /// The operator's handle of this cell.
    #[must_use]
    pub fn operator(&self) -> Operator {
        self.operator.clone()
    }

    /// Runs the cell on the memory link, under the virtual clock, until the MP's program is over.
    ///
    /// # Errors
    /// [`CellError`]: what is wrong with the set-up, before anything moves; or the first cause of a stop.
    pub fn run(self) -> Result<RunReport, CellError> {
        let names = self.check()?;
        let nudged = self.program.is_none();
        let patience = (self.step * (missed_step_budget(self.step) + 1)).as_nanos() as Nanos;
        let mut scheduler = Scheduler::new();
        let outcomes = Outcomes::default();
        let mp = scheduler.place("mp".to_owned());
        let ecps: Vec<_> = names.iter().map(|name| scheduler.place(format!("ecp {name}"))).collect();

        let mut mp_sensing = Sensing { ports: Vec::new(), patience };
        // An ECP loses patience first, so that it can say with whom.
        let shorter = patience - self.step.as_nanos() as Nanos;
        let mut ecp_sensing: Vec<_> =
            names.iter().map(|_| Sensing { ports: Vec::new(), patience: shorter }).collect();
        // EDPs tick first half a servo period after a step's beginning.
        let servo = self.robots.iter().map(|robot| robot.servo_period()).min();
        let grace = (servo.unwrap_or(self.step).min(self.step).as_nanos() / 2) as Nanos;
        for sensor in self.sensors {
            sensor.spawn(&mut scheduler, self.step, mp, &names, &ecps, &mut mp_sensing, &mut ecp_sensing)?;
        }
        let mut ports = Vec::new();
        for ((robot, name), (&ecp, sensing)) in
            self.robots.into_iter().zip(&names).zip(ecps.iter().zip(ecp_sensing))
        {
            let (client, server) = scheduler.port(mp, ecp);
            let steps = robot.stop_steps(self.step);
            ports.push(RobotPort::new(*name, robot.kind(), client, steps));
            let period = self.step.as_nanos() as Nanos;
            let pace = Pace { period, grace, stop_steps: steps };
            let place = Place { name: *name, ecp, step: self.step, pace, nudged };
            robot.spawn(&mut scheduler, place, server, sensing, Rc::clone(&outcomes))?;
        }

        let close = scheduler.closer();
        let (operator, step, rate_change, hook, program) =
            (self.operator, self.step, self.rate_change, self.hook, self.program);
        let steps = Rc::new(core::cell::Cell::new(0));
        let (counted, recorded) = (Rc::clone(&steps), Rc::clone(&outcomes));
        scheduler.body(
            mp,
            Box::new(move |waiter| {
                let mut mp = Mp::new(waiter, ports, mp_sensing, operator, hook, (step, grace), rate_change);
                let outcome = mp.run_program(|mp| match program {
                    Some(program) => program(mp),
                    None => mp.nudge(),
                });
                counted.set(mp.step());
                recorded.borrow_mut().push((ProcessId::MP, outcome));
                close();
            }),
        )?;
        let time = scheduler.run()?;
        first_cause(&outcomes.borrow())?;
        Ok(RunReport { steps: steps.get(), time: Duration::from_nanos(time) })
    }

    /// The robots' names, when nothing is wrong with the set-up.
    fn check(&self) -> Result<Vec<Name>, CellError> {
        if self.step.is_zero() {
            return Err(CellError::Step);
        }
        let (mut names, mut errors) = (Vec::new(), Vec::new());
        for robot in &self.robots {
            let name = match Name::new(robot.name()) {
                Ok(name) => name,
                Err(bad) => {
                    errors.push(bad.into());
                    continue;
                }
            };
            if names.contains(&name) {
                errors.push(CellError::Twice(name));
            }
            let (servo, step) = (robot.servo_period(), self.step);
            let divides = |a: Duration, b: Duration| b.as_nanos().is_multiple_of(a.as_nanos());
            if servo.is_zero() || !divides(servo, step) && !divides(step, servo) {
                errors.push(CellError::Period { robot: name, servo, step });
            }
            errors.extend(robot.check_limits(name, step, self.stop_time));
            names.push(name);
        }
        let mut sensors = Vec::new();
        for sensor in &self.sensors {
            match Name::new(sensor.name()) {
                Ok(name) => {
                    if sensors.contains(&name) {
                        errors.push(CellError::Twice(name));
                    }
                    errors.extend(sensor.check(name, &names));
                    sensors.push(name);
                }
                Err(bad) => errors.push(bad.into()),
            }
        }
        if self.program.is_none() && !self.robots.iter().any(|robot| robot.has_program()) {
            errors.push(CellError::NoProgram);
        }
        CellError::all(errors).map(|()| names)
    }
}

/// The MP's fault, or else the first of an ECP's.
fn first_cause(outcomes: &[(ProcessId, Result<(), Fault>)]) -> Result<(), Fault> {
    let mp = outcomes.iter().filter(|(process, _)| process.role == Role::Mp);
    let others = outcomes.iter().filter(|(process, _)| process.role != Role::Mp);
    for (process, outcome) in mp.chain(others) {
        if let Err(fault) = outcome {
            if fault.kind() == FaultKind::CellClosed {
                let text = "the ECP waits for an instruction, but the MP's program is over";
                return Err(Fault::thrown(text).in_process(*process));
            }
            return Err(fault.clone());
        }
    }
    Ok(())
}

/// Where a robot's processes are.
struct Place {
    name: Name,
    ecp: usize,
    step: Duration,
    pace: Pace,
    nudged: bool,
}

/// A robot of any kind.
trait AnyRobot {
    fn name(&self) -> &str;
    fn kind(&self) -> TypeId;
    fn has_program(&self) -> bool;
    fn servo_period(&self) -> Duration;
    fn check_limits(&self, name: Name, step: Duration, stop_time: Duration) -> Vec<CellError>;
    fn stop_steps(&self, step: Duration) -> u64;
    fn spawn(
        self: Box<Self>,
        scheduler: &mut Scheduler,
        place: Place,
        mp: Box<dyn Server>,
        sensing: Sensing,
        outcomes: Outcomes,
    ) -> Result<(), Stuck>;
}

impl<R: Robot> AnyRobot for RobotSetup<R> {
    fn name(&self) -> &str {
        &self.name
    }

    fn kind(&self) -> TypeId {
        TypeId::of::<R>()
    }

    fn has_program(&self) -> bool {
        self.program.is_some()
    }

    fn servo_period(&self) -> Duration {
        self.driver.period()
    }

    fn check_limits(&self, name: Name, step: Duration, stop_time: Duration) -> Vec<CellError> {
        limits::check(name, R::joint, self.robot.limits(), &self.following_error, (step, stop_time))
    }

    fn stop_steps(&self, step: Duration) -> u64 {
        stop_steps(self.robot.limits(), step, self.driver.period())
    }

    fn spawn(
        self: Box<Self>,
        scheduler: &mut Scheduler,
        place: Place,
        mp: Box<dyn Server>,
        sensing: Sensing,
        outcomes: Outcomes,
    ) -> Result<(), Stuck> {
        let name = place.name;
        let edp = scheduler.place(format!("edp {name}"));
        let (client, server) = scheduler.port(place.ecp, edp);
        let config = EdpConfig {
            process: ProcessId::new(Role::Edp, name),
            robot: self.robot,
            driver: self.driver,
            tool: self.tool,
            step: place.step,
            following_error: self.following_error,
            observers: self.observers,
        };
        scheduler.body(edp, Box::new(move |waiter| Edp::new(config, waiter, server).run()))?;
        let (program, nudged) = (self.program, place.nudged);
        let process = ProcessId::new(Role::Ecp, name);
        let pace = place.pace;
        scheduler.body(
            place.ecp,
            Box::new(move |waiter| {
                let mut ecp = Ecp::<'_, R>::new(process, waiter, mp, client, sensing, pace);
                let has_own = program.is_some();
                let outcome = ecp.run_program(|ecp| match program {
                    Some(program) if nudged => ecp.obey(|ecp, _: Nudge| program(ecp)),
                    Some(program) => program(ecp),
                    None if nudged => ecp.obey(|_, _: Nudge| Ok(())),
                    None => crate::transparent::program(ecp),
                });
                ecp.serve(&outcome);
                if has_own {
                    outcomes.borrow_mut().push((process, outcome));
                }
            }),
        )
    }
}

/// A virtual sensor of any kind.
trait AnySensor {
    fn name(&self) -> &str;
    fn check(&self, name: Name, robots: &[Name]) -> Vec<CellError>;
    #[allow(clippy::too_many_arguments)]
    fn spawn(
        self: Box<Self>,
        scheduler: &mut Scheduler,
        step: Duration,
        mp: usize,
        robots: &[Name],
        ecps: &[usize],
        mp_sensing: &mut Sensing,
        ecp_sensing: &mut [Sensing],
    ) -> Result<(), CellError>;
}

impl<V: VirtualSensor> AnySensor for SensorSetup<V> {
    fn name(&self) -> &str {
        &self.name
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

    fn spawn(
        self: Box<Self>,
        scheduler: &mut Scheduler,
        step: Duration,
        mp: usize,
        robots: &[Name],
        ecps: &[usize],
        mp_sensing: &mut Sensing,
        ecp_sensing: &mut [Sensing],
    ) -> Result<(), CellError> {
        let name = Name::new(&self.name)?;
        let belongs = |robot: &String| {
            let place = robots.iter().position(|name| name.as_str() == robot);
            place.ok_or_else(|| CellError::NoSuchRobot(name, robot.clone()))
        };
        let robot = self.robot.as_ref().map(belongs).transpose()?;
        let place = scheduler.place(format!("vsp {name}"));
        let kind = TypeId::of::<V::Kind>();
        let clients = [Some(mp), robot.map(|robot| ecps[robot])];
        let mut servers: Vec<Box<dyn Server>> = Vec::new();
        let mut sources = Vec::new();
        let mut boards = Vec::new();
        for client in clients.into_iter().flatten() {
            let mut ask = |wrap: fn(Box<dyn Client>) -> Source| {
                let (client, server) = scheduler.port(client, place);
                servers.push(server);
                wrap(client)
            };
            sources.push(match self.mode {
                VspMode::Interactive => ask(Source::Interactive),
                VspMode::WithDelay => ask(Source::WithDelay),
                VspMode::NonInteractive(_) => {
                    let board = Boards { orders: Scheduler::board(), readings: Scheduler::board() };
                    boards.push(board.clone());
                    Source::NonInteractive(board)
                }
            });
        }
        let mut sources = sources.into_iter();
        if let Some(source) = sources.next() {
            mp_sensing.ports.push(SensorPort::new(name, kind, robot, source));
        }
        if let (Some(robot), Some(source)) = (robot, sources.next()) {
            ecp_sensing[robot].ports.push(SensorPort::new(name, kind, Some(robot), source));
        }
        let (sensor, configuration, latency) =
            (self.sensor, self.configuration, self.latency.as_nanos() as Nanos);
        let orders = match self.mode {
            VspMode::Interactive | VspMode::WithDelay => Orders::Ports(servers),
            VspMode::NonInteractive(period) => Orders::Free { boards, period: period.as_nanos() as Nanos },
        };
        let process = ProcessId::new(Role::Vsp, name);
        let step = step.as_nanos() as Nanos;
        scheduler.body(
            place,
            Box::new(move |waiter| {
                Vsp { process, sensor, configuration, waiter, orders, latency, step }.run();
            }),
        )?;
        Ok(())
    }
}
