//! How the ECP and the EDP of a robot come to life on a link.

use core::any::Any;
use core::cell::OnceCell;
use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use nalgebra::SVector;

use super::RobotSetup;
use super::signals::SignalSetups;
use crate::control::drive::Drive;
use crate::control::ecp::{Ecp, Pace};
use crate::control::edp::signals::Declared;
use crate::control::edp::{Edp, EdpConfig};
use crate::control::homing::{Drives, home};
use crate::control::opening::Opening;
use crate::control::overruns::Timed;
use crate::control::plant::Site;
use crate::control::replay::RecordedRobot;
use crate::control::sensing::Sensing;
use crate::control::simulated_signals::{SimulatedSignals, SimulatedWire};
use crate::control::transparent;
use crate::link::memory::Stuck;
use crate::link::{Board, Client, Host, Link, Preparation, Server};
use crate::model::any_kind::AnyKind;
use crate::model::demand::Demand;
use crate::model::driver::{Channels, Driver};
use crate::model::fault::{Fault, ProcessId, Role};
use crate::model::joints::{JointVector, MAX_JOINTS};
use crate::model::list::PayloadType;
use crate::model::name::Name;
use crate::model::named::{CellNames, SignalNames};
use crate::model::payload::Trigger;
use crate::model::pose::Pose;
use crate::model::robot::{InterpolationSpace, Robot};
use crate::observe::activity::Activity;
use crate::observe::servo::Observer;
use crate::observe::shown::{AnyShown, Shown};
use crate::observe::step_observer::{StepEvent, StepObservers};
use crate::safety::latch::Gate;

/// How the programs of a cell's processes ended.
pub type Outcomes = Rc<RefCell<Vec<(ProcessId, Result<(), Fault>)>>>;

/// Where a robot's processes are.
pub struct RobotPlacement {
    pub name: Name,
    pub ecp: usize,
    /// The port of its orders, and of its sensors.
    pub mp: Box<dyn Server>,
    pub sensing: Sensing,
    /// Length of a step.
    pub period: Duration,
    /// How far drives are behind their demands in this cell; `None`: each takes every demand as it is.
    pub delay: Option<Duration>,
    pub pace: Pace,
    pub triggered: bool,
    pub step_observers: StepObservers,
    /// The names of its inputs and outputs, and of the cell's frames and tools.
    pub signals: Rc<SignalNames>,
    pub named: Rc<CellNames>,
    pub outcomes: Outcomes,
    /// The virtual sensors that want its state from its EDP.
    pub wanted: Vec<StateWanted>,
}

/// A virtual sensor wants the state of a robot from the robot's EDP, which has no place on the link yet.
#[derive(Clone)]
pub struct StateWanted {
    /// Place of the robot in the cell.
    pub robot: usize,
    /// Place of the VSP on the link.
    pub vsp: usize,
    /// Where the state will be shown.
    pub board: Rc<OnceCell<Rc<dyn Board>>>,
}

impl<R: Robot> RobotSetup<R> {
    /// Puts its EDP and its ECP on the link, as [`AnyRobot::spawn`](super::AnyRobot::spawn).
    pub(super) fn put_on(
        self,
        link: &mut dyn Link,
        plant: &mut Site,
        place: RobotPlacement,
    ) -> Result<(), Stuck> {
        let robot = Box::new((AnyKind::new(self.robot), self.processes));
        spawn(robot, (R::Joints::LEN, PayloadType::of::<Demand<R>>()), link, plant, place)
    }
}

/// Puts the processes of a robot on the link: of its model and its [`ProcessSetup`], its number of joints, and the demands of its kind, as the
/// MP sends them to an ECP without a program. They are compiled here, once for each number of joints, and not for each kind of robots in every crate
/// that has some.
fn spawn(
    robot: Box<dyn Any>,
    kind: (usize, PayloadType),
    link: &mut dyn Link,
    plant: &mut Site,
    place: RobotPlacement,
) -> Result<(), Stuck> {
    match kind.0 {
        0 => spawn_with::<0>(robot, kind.1, link, plant, place),
        1 => spawn_with::<1>(robot, kind.1, link, plant, place),
        2 => spawn_with::<2>(robot, kind.1, link, plant, place),
        3 => spawn_with::<3>(robot, kind.1, link, plant, place),
        4 => spawn_with::<4>(robot, kind.1, link, plant, place),
        5 => spawn_with::<5>(robot, kind.1, link, plant, place),
        6 => spawn_with::<6>(robot, kind.1, link, plant, place),
        7 => spawn_with::<7>(robot, kind.1, link, plant, place),
        _ => spawn_with::<MAX_JOINTS>(robot, kind.1, link, plant, place),
    }
}

fn spawn_with<const N: usize>(
    robot: Box<dyn Any>,
    demand: PayloadType,
    link: &mut dyn Link,
    plant: &mut Site,
    place: RobotPlacement,
) -> Result<(), Stuck> {
    match robot.downcast::<(AnyKind<SVector<f64, N>>, ProcessSetup<SVector<f64, N>>)>() {
        Ok(robot) => robot.1.put_on(robot.0, demand, link, plant, place),
        // `JointVector` is implemented for these vectors alone.
        Err(_) => unreachable!("a robot with {N} joints has another type of joint vectors"),
    }
}

/// What the processes of a robot are made of, whatever its kind.
pub(super) struct ProcessSetup<J: JointVector> {
    pub drives: Drives<AnyKind<J>>,
    /// The tool at the start, `X_FE`.
    pub tool: Pose,
    pub space: InterpolationSpace,
    pub following_error: J,
    pub signals: SignalSetups,
    pub program: Option<EcpProgram>,
    pub observers: Vec<Observer<AnyKind<J>>>,
    /// What its program does, for observers.
    pub activity: Shown<Activity>,
    /// What its program shows to observers.
    pub shown: Vec<Box<dyn AnyShown>>,
    /// What it replays.
    pub replayed: Option<Rc<RecordedRobot>>,
}

impl<J: JointVector> ProcessSetup<J> {
    pub fn new(drives: Drives<AnyKind<J>>, following_error: J) -> Self {
        ProcessSetup {
            drives,
            tool: Pose::identity(),
            space: InterpolationSpace::Joints,
            following_error,
            signals: SignalSetups::default(),
            program: None,
            observers: Vec::new(),
            activity: Shown::new(Activity::default()),
            shown: Vec::new(),
            replayed: None,
        }
    }

    fn put_on(
        self,
        robot: AnyKind<J>,
        demand: PayloadType,
        link: &mut dyn Link,
        plant: &mut Site,
        place: RobotPlacement,
    ) -> Result<(), Stuck> {
        let model = Rc::new(robot.clone());
        let name = place.name;
        let process = ProcessId::new(Role::Edp, name);
        let edp = link.place(process);
        let (client, server) = link.port(place.ecp, edp);
        let show_to = |wanted: &StateWanted| {
            let board = link.board(edp, wanted.vsp);
            Rc::clone(wanted.board.get_or_init(|| board))
        };
        let states: Vec<_> = place.wanted.iter().map(show_to).collect();
        let mut observers = self.observers;
        let replayed = self.replayed.clone();
        let (mp, sensing, outcomes) = (place.mp, place.sensing, place.outcomes);
        let ended = Rc::clone(&outcomes);
        // Drives that have to be homed stay with their EDP: what they search with is consumed step by step, and a search
        // that is called no more comes to rest by itself.
        let (declared, wires) = (self.signals.declared(), self.signals.wires());
        let prepared = move |driver| prepared(driver, &declared, &wires);
        let drives = match self.drives {
            Drives::Homed(driver) => {
                let driver = prepared(driver);
                let opening = Rc::new(Opening::new(plant.take(link, process, edp, driver, &mut observers)));
                link.prepare(edp, Rc::clone(&opening) as Rc<dyn Preparation>);
                Ok(opening)
            }
            Drives::Unhomed(homing) => Err(homing),
        };
        if self.program.is_some()
            && let Some(board) = plant.board(link, place.ecp)
        {
            self.activity.pass_on(board);
        }
        for shown in self.shown {
            plant.board(link, place.ecp).into_iter().for_each(|board| shown.pass_on(board));
        }
        let run = move |host: Host<'_>| {
            let waiter = host.waiter;
            let step_observers = place.step_observers.of(process);
            let homed = match drives {
                Ok(opening) => opening.take().map(|drive| (drive, Gate::default())),
                Err(homing) => home(process, waiter, &*server, homing).map(|(driver, gate)| {
                    let now = waiter.now();
                    step_observers.show(now, &StepEvent::Found { step: now / place.pace.period.max(1) }, &[]);
                    (Drive::Here(prepared(driver)), gate)
                }),
            };
            if let Some((drive, gate)) = homed {
                let config = EdpConfig {
                    process,
                    robot,
                    drive,
                    tool: self.tool,
                    period: place.period,
                    delay: place.delay,
                    space: self.space,
                    following_error: self.following_error,
                    stop_steps: place.pace.stop_steps,
                    declared,
                    observers,
                    step_observers,
                    states,
                    replayed,
                };
                if let Err(fault) = Edp::new(config, host, server).behind(gate).run() {
                    ended.borrow_mut().push((process, Err(fault)));
                }
            }
        };
        link.body(edp, Box::new(run))?;
        let process = ProcessId::new(Role::Ecp, name);
        let (pace, triggered, recorded) = (place.pace, place.triggered, self.replayed);
        let (signals, named) = (place.signals, place.named);
        let (program, activity) = (self.program, self.activity);
        link.body(
            place.ecp,
            Box::new(move |host| {
                let timed = Timed::new(host);
                let host = timed.host();
                let start = EcpStart {
                    process,
                    host,
                    mp,
                    edp: client,
                    sensing,
                    pace,
                    triggered,
                    recorded,
                    signals,
                    named,
                };
                match program {
                    Some(program) => {
                        let outcome = program(start, activity);
                        outcomes.borrow_mut().push((process, outcome));
                    }
                    None => start.pass_on(model, demand),
                }
            }),
        )
    }
}

/// Runs the program of an ECP until the cell closes, and shows its instructions to observers: how it ended.
pub(super) type EcpProgram = Box<dyn FnOnce(EcpStart<'_>, Shown<Activity>) -> Result<(), Fault>>;

/// What an ECP begins with.
pub(super) struct EcpStart<'w> {
    process: ProcessId,
    host: Host<'w>,
    mp: Box<dyn Server>,
    edp: Box<dyn Client>,
    sensing: Sensing,
    pace: Pace,
    triggered: bool,
    recorded: Option<Rc<RecordedRobot>>,
    signals: Rc<SignalNames>,
    named: Rc<CellNames>,
}

impl EcpStart<'_> {
    /// Runs `program`, again after every reset.
    pub fn run<R: Robot>(
        self,
        model: Rc<R>,
        activity: Shown<Activity>,
        program: &mut dyn FnMut(&mut Ecp<R>) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let triggered = self.triggered;
        self.repeat(model, Some(activity), &mut |ecp| match triggered {
            true => ecp.serve(|ecp, _: Trigger| program(ecp)),
            false => program(ecp),
        })
    }

    /// Passes on the demands of the MP; whatever stopped it, the MP knows.
    fn pass_on<R: Robot>(self, model: Rc<R>, demand: PayloadType) {
        let triggered = self.triggered;
        let outcome = self.repeat(model, None, &mut |ecp| match triggered {
            true => ecp.serve(|_, _: Trigger| Ok(())),
            false => transparent::program(ecp, demand),
        });
        drop(outcome);
    }

    fn repeat<R: Robot>(
        self,
        model: Rc<R>,
        activity: Option<Shown<Activity>>,
        program: &mut dyn FnMut(&mut Ecp<R>) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let process = (self.process, model);
        let ecp = Ecp::new(process, self.host, self.mp, self.edp, self.sensing, self.pace, self.recorded);
        let mut ecp = ecp.with_names(self.signals, self.named).showing_instructions(activity);
        loop {
            let outcome = ecp.run_program(&mut *program);
            if !ecp.answer_after_program(&outcome) {
                return outcome;
            }
        }
    }
}

/// Drives that know what their outputs do when they are told nothing any more; simulated ones without any signals get some, if
/// the robot has names for them.
fn prepared<R: Robot>(
    driver: Box<dyn Driver<R>>,
    declared: &Declared,
    wires: &[SimulatedWire],
) -> Box<dyn Driver<R>> {
    if !declared.any {
        return driver;
    }
    let has_none = driver.channels() == Channels::NONE && driver.hardware().is_none();
    let mut driver = if has_none { Box::new(SimulatedSignals::new(driver, wires)) } else { driver };
    driver.declare_outputs(&declared.outputs, &declared.on_stop);
    driver
}
