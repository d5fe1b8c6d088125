//! A robot of a cell, and how its ECP and EDP come to life.

use crate::link::Host;
use core::any::{Any, TypeId};
use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use super::assembly::Outcomes;
use super::layout::joints;
use super::{CellError, limits};
use crate::control::drive::Drive;
use crate::control::ecp::{Ecp, Pace};
use crate::control::edp::{Edp, EdpConfig};
use crate::control::homing::{Drives, home};
use crate::control::overruns::Timed;
use crate::control::plant::Site;
use crate::control::replay::RecordedRobot;
use crate::control::replay::drives::recorded_drives;
use crate::control::sensing::Sensing;
use crate::link::memory::Stuck;
use crate::link::{Link, Server};
use crate::model::driver::{Driver, Homing};
use crate::model::fault::{Fault, ProcessId, Role};
use crate::model::joints::JointVector;
use crate::model::name::Name;
use crate::model::payload::Nudge;
use crate::model::pose::Pose;
use crate::model::robot::InterpolationSpace;
use crate::model::robot::{NoInverse, Robot};
use crate::observe::layout::RobotLayout;
use crate::observe::servo::Observation;
use crate::observe::servo::{Observer, ServoRecord};
use crate::observe::shown::{AnyShown, Shown};
use crate::safety::latch::Gate;
use crate::safety::limits::rates::least_headroom;
use crate::safety::rate::RateHeadroom;
use crate::safety::stopping::{longest_braking, stop_steps};

use crate::model::wire::Wire;
use crate::observe::witness::{What, Witnesses};

type EcpProgram<R> = Box<dyn FnMut(&mut Ecp<R>) -> Result<(), Fault>>;

/// A robot of a cell: its model, its drives and its program.
pub struct RobotSetup<R: Robot> {
    name: String,
    robot: R,
    drives: Drives<R>,
    tool: Pose,
    space: InterpolationSpace,
    following_error: R::Joints,
    program: Option<EcpProgram<R>>,
    observers: Vec<Observer<R>>,
    /// What its program shows to observers.
    shown: Vec<Box<dyn AnyShown>>,
    /// What it replays.
    replayed: Option<Rc<RecordedRobot>>,
}

impl<R: Robot> RobotSetup<R> {
    /// A robot `name` with its drives. Its following error may be what its velocity limit covers in 50 ms.
    pub fn new(name: &str, robot: R, driver: impl Driver<R> + 'static) -> Self {
        Self::with_drives(name, robot, Drives::Homed(Box::new(driver)))
    }

    /// A robot `name` whose drives do not know where it is: they look for their reference marks when the cell starts. The
    /// MP's program begins when all robots of the cell have found theirs, and so does what an ECP obeys.
    pub fn unhomed<H>(name: &str, robot: R, homing: H) -> Self
    where
        H: Homing<R, Drives: 'static> + 'static,
    {
        Self::with_drives(name, robot, Drives::Unhomed(Box::new(Some(homing))))
    }

    /// Whether its drives know where it is.
    pub fn is_homed(&self) -> bool {
        matches!(self.drives, Drives::Homed(_))
    }

    fn with_drives(name: &str, robot: R, drives: Drives<R>) -> Self {
        let following_error = robot.limits().velocity * 0.05;
        RobotSetup {
            name: name.to_owned(),
            drives,
            tool: Pose::identity(),
            space: InterpolationSpace::Joints,
            following_error,
            program: None,
            observers: Vec::new(),
            shown: Vec::new(),
            replayed: None,
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

    /// Where the EDP interpolates between the demands of two steps, in joints unless told otherwise.
    #[must_use]
    pub fn interpolation(mut self, space: InterpolationSpace) -> Self {
        self.space = space;
        self
    }

    /// The largest difference between demanded and measured joint positions [rad or m], each > 0.
    #[must_use]
    pub fn following_error(mut self, limit: R::Joints) -> Self {
        self.following_error = limit;
        self
    }

    /// The program of the robot's ECP. Without one the ECP is transparent: it passes the MP's demands on. It is called
    /// again, from its first line, after a reset: what it would give away it clones.
    #[must_use]
    pub fn program(mut self, program: impl FnMut(&mut Ecp<R>) -> Result<(), Fault> + 'static) -> Self {
        self.give_program(program);
        self
    }

    /// Gives it another name, before its cell is put together.
    pub fn rename(&mut self, name: &str) {
        name.clone_into(&mut self.name);
    }

    pub(super) fn give_program(&mut self, program: impl FnMut(&mut Ecp<R>) -> Result<(), Fault> + 'static) {
        self.program = Some(Box::new(program));
    }

    /// Calls `observer` after every servo period.
    #[must_use]
    pub fn observe(mut self, observer: impl FnMut(&ServoRecord<R>) + 'static) -> Self {
        self.observers.push(Box::new(observer));
        self
    }

    /// Lets observers see what the robot's program shows, in whichever process they look on.
    #[must_use]
    pub fn shows<T: Wire>(mut self, shown: &Shown<T>) -> Self {
        self.shown.push(Box::new(shown.clone()));
        self
    }
}

/// Where a robot's processes are.
pub struct Place {
    pub name: Name,
    pub ecp: usize,
    /// Length of a step.
    pub period: Duration,
    /// How far drives are behind their demands in this cell; `None`: each takes every demand as it is.
    pub delay: Option<Duration>,
    pub pace: Pace,
    pub nudged: bool,
    pub witnesses: Witnesses,
}

/// An observer of several robots.
pub(super) type SharedObserver = Rc<RefCell<dyn FnMut(&Observation<'_>)>>;

/// A robot of any kind.
pub trait AnyRobot {
    /// Its set-up, whose type its kind tells.
    fn as_any(&mut self) -> &mut dyn Any;
    /// Shows every servo period to an observer of several robots.
    fn watch(&mut self, observer: SharedObserver);
    /// Takes away all observers that it has.
    fn unwatch(&mut self);
    /// Its drives read from a recording.
    fn replay(&mut self, recorded: Rc<RecordedRobot>, step: Duration);
    /// Its name in the cell.
    fn name(&self) -> &str;
    /// Its kind, as a type.
    fn kind(&self) -> TypeId;
    /// Its kind's name, for messages.
    fn kind_name(&self) -> &'static str;
    /// What it is made of, in plain numbers.
    fn layout(&self) -> RobotLayout;
    /// Whether its ECP has a program of its own.
    fn has_program(&self) -> bool;
    /// How often its drives take a position.
    fn servo_period(&self) -> Duration;
    /// Whether its drives know where it is.
    fn is_homed(&self) -> bool;
    /// What its drives are, for the whole machine.
    fn hardware(&self) -> Option<String>;
    /// Whether its drives may be in the plant.
    fn is_simulated(&mut self) -> bool;
    /// What forbids that its EDP interpolates where it is told to.
    fn check_space(&self, name: Name) -> Option<CellError>;
    /// The longest time that it brakes for \[s\].
    fn braking_time(&self) -> f64;
    /// The least that it leaves at this rate for changes of the rate, in steps of this length.
    fn least_headroom(&self, rate: f64, step: Duration) -> RateHeadroom;
    /// What is wrong with its limits, in a cell of this step that allows a stop to take `stop_time`.
    fn check_limits(&self, name: Name, step: Duration, stop_time: Duration) -> Vec<CellError>;
    /// Steps within which it must stand after a stop began, in a cell whose drives are `delay` behind their demands.
    fn stop_steps(&self, step: Duration, delay: Duration) -> u64;
    /// Puts its EDP and its ECP on the link.
    ///
    /// # Errors
    /// [`Stuck`] when the link has no room for them.
    fn spawn(
        self: Box<Self>,
        link: &mut dyn Link,
        plant: &mut Site,
        place: Place,
        mp: Box<dyn Server>,
        sensing: Sensing,
        outcomes: Outcomes,
    ) -> Result<(), Stuck>;
}

impl<R: Robot> AnyRobot for RobotSetup<R> {
    fn as_any(&mut self) -> &mut dyn Any {
        self
    }

    fn watch(&mut self, observer: SharedObserver) {
        let name = self.name.clone();
        let robot = self.robot.clone();
        let joints: Vec<_> = (0..R::Joints::LEN).map(|i| robot.joint(i)).collect();
        self.observers.push(Box::new(move |record| {
            let measured = &record.measured.position;
            let observation = Observation {
                robot: &name,
                kind: R::KIND,
                time: record.time,
                demanded: record.demanded.as_slice(),
                measured: measured.as_slice(),
                joints: &joints,
                frames: &|visit| robot.frames(measured, visit),
                tool: robot.forward(measured) * record.tool,
            };
            (observer.borrow_mut())(&observation);
        }));
    }

    fn unwatch(&mut self) {
        self.observers.clear();
    }

    fn replay(&mut self, recorded: Rc<RecordedRobot>, step: Duration) {
        // Whether the joints followed, the run that was recorded has judged; what is between two steps is not recorded.
        self.following_error = R::Joints::from_joints(|_| f64::INFINITY);
        self.drives = recorded_drives(&self.drives, Rc::clone(&recorded), step);
        self.replayed = Some(recorded);
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn kind(&self) -> TypeId {
        TypeId::of::<R>()
    }

    fn kind_name(&self) -> &'static str {
        R::KIND
    }

    fn layout(&self) -> RobotLayout {
        RobotLayout {
            name: self.name.clone(),
            kind: R::KIND,
            servo: self.drives.period(),
            homed: self.is_homed(),
            ecp_program: self.program.is_some(),
            space: self.space,
            joints: joints(&self.robot, &self.following_error),
        }
    }

    fn has_program(&self) -> bool {
        self.program.is_some()
    }

    fn servo_period(&self) -> Duration {
        self.drives.period()
    }

    fn check_space(&self, name: Name) -> Option<CellError> {
        let limits = self.robot.limits();
        let middle = (limits.lower + limits.upper) * 0.5;
        let pose = self.robot.forward(&middle);
        let at_a_value = self.robot.inverse_at(&pose, 0.0, &middle);
        let is_redundant = R::Joints::LEN > 6 || at_a_value != Err(NoInverse::NotRedundant);
        (self.space == InterpolationSpace::Task && is_redundant).then_some(CellError::TaskSpace(name))
    }

    fn is_homed(&self) -> bool {
        matches!(self.drives, Drives::Homed(_))
    }

    fn hardware(&self) -> Option<String> {
        self.drives.hardware()
    }

    fn is_simulated(&mut self) -> bool {
        match &mut self.drives {
            Drives::Homed(driver) => driver.simulation().is_some(),
            Drives::Unhomed(_) => false,
        }
    }

    fn check_limits(&self, name: Name, step: Duration, stop_time: Duration) -> Vec<CellError> {
        limits::check(
            name,
            |i| self.robot.joint(i),
            self.robot.limits(),
            &self.following_error,
            step,
            stop_time,
        )
    }

    fn braking_time(&self) -> f64 {
        longest_braking(self.robot.limits())
    }

    fn least_headroom(&self, rate: f64, step: Duration) -> RateHeadroom {
        least_headroom(self.robot.limits(), rate, step.as_secs_f64())
    }

    fn stop_steps(&self, step: Duration, delay: Duration) -> u64 {
        stop_steps(self.robot.limits(), step, delay)
    }

    fn spawn(
        self: Box<Self>,
        link: &mut dyn Link,
        plant: &mut Site,
        place: Place,
        mp: Box<dyn Server>,
        sensing: Sensing,
        outcomes: Outcomes,
    ) -> Result<(), Stuck> {
        let setup = *self;
        let name = place.name;
        let process = ProcessId::new(Role::Edp, name);
        let edp = link.place(process);
        let (client, server) = link.port(place.ecp, edp);
        let mut observers = setup.observers;
        let replayed = setup.replayed.clone();
        let ended = Rc::clone(&outcomes);
        // Drives that have to be homed stay with their EDP: what they search with is consumed step by step, and a search
        // that is called no more comes to rest by itsetup.
        let drives = match setup.drives {
            Drives::Homed(driver) => Ok(plant.take(link, process, edp, driver, &mut observers)),
            Drives::Unhomed(homing) => Err(homing),
        };
        for shown in setup.shown {
            plant.board(link, place.ecp).into_iter().for_each(|board| shown.pass_on(board));
        }
        let run = move |host: Host<'_>| {
            let waiter = host.waiter;
            let witnesses = place.witnesses.of(process);
            let homed = match drives {
                Ok(drive) => Some((drive.opened(), Gate::default())),
                Err(homing) => home(process, waiter, &*server, homing).map(|(driver, gate)| {
                    let now = waiter.now();
                    witnesses.show(now, &What::Found { step: now / place.pace.period.max(1) }, &[]);
                    (Drive::Here(driver), gate)
                }),
            };
            if let Some((drive, gate)) = homed {
                let config = EdpConfig {
                    process,
                    robot: setup.robot,
                    drive,
                    tool: setup.tool,
                    period: place.period,
                    delay: place.delay,
                    space: setup.space,
                    following_error: setup.following_error,
                    stop_steps: place.pace.stop_steps,
                    observers,
                    witnesses,
                    replayed,
                };
                if let Err(fault) = Edp::new(config, host, server).behind(gate).run() {
                    ended.borrow_mut().push((process, Err(fault)));
                }
            }
        };
        link.body(edp, Box::new(run))?;
        let mut program = setup.program;
        let nudged = place.nudged;
        let process = ProcessId::new(Role::Ecp, name);
        let pace = place.pace;
        let recorded = setup.replayed;
        link.body(
            place.ecp,
            Box::new(move |host| {
                let timed = Timed::new(host);
                let mut ecp = Ecp::<'_, R>::new(process, timed.host(), mp, client, sensing, pace, recorded);
                loop {
                    let outcome = ecp.run_program(|ecp| match &mut program {
                        Some(program) if nudged => ecp.obey(|ecp, _: Nudge| program(ecp)),
                        Some(program) => program(ecp),
                        None if nudged => ecp.obey(|_, _: Nudge| Ok(())),
                        None => crate::control::transparent::program(ecp),
                    });
                    let starts_again = ecp.serve(&outcome);
                    if !starts_again {
                        if program.is_some() {
                            outcomes.borrow_mut().push((process, outcome));
                        }
                        break;
                    }
                }
            }),
        )
    }
}
