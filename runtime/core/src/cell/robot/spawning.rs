//! How the ECP and the EDP of a robot come to life on a link.

use core::cell::OnceCell;
use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use super::RobotSetup;
use crate::control::drive::Drive;
use crate::control::ecp::{Ecp, Pace};
use crate::control::edp::signals::Declared;
use crate::control::edp::{Edp, EdpConfig};
use crate::control::homing::{Drives, home};
use crate::control::opening::Opening;
use crate::control::overruns::Timed;
use crate::control::plant::Site;
use crate::control::sensing::Sensing;
use crate::control::simulated_signals::{SimulatedSignals, SimulatedWire};
use crate::link::memory::Stuck;
use crate::link::{Board, Host, Link, Preparation, Server};
use crate::model::driver::{Channels, Driver};
use crate::model::fault::{Fault, ProcessId, Role};
use crate::model::name::Name;
use crate::model::named::{CellNames, SignalNames};
use crate::model::payload::Trigger;
use crate::model::robot::Robot;
use crate::observe::shown::AnyShown;
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
        let setup = self;
        let model = Rc::new(setup.robot.clone());
        let name = place.name;
        let process = ProcessId::new(Role::Edp, name);
        let edp = link.place(process);
        let (client, server) = link.port(place.ecp, edp);
        let show_to = |wanted: &StateWanted| {
            let board = link.board(edp, wanted.vsp);
            Rc::clone(wanted.board.get_or_init(|| board))
        };
        let states: Vec<_> = place.wanted.iter().map(show_to).collect();
        let mut observers = setup.observers;
        let replayed = setup.replayed.clone();
        let (mp, sensing, outcomes) = (place.mp, place.sensing, place.outcomes);
        let ended = Rc::clone(&outcomes);
        // Drives that have to be homed stay with their EDP: what they search with is consumed step by step, and a search
        // that is called no more comes to rest by itself.
        let (declared, wires) = (setup.signals.declared(), setup.signals.wires());
        let prepared = move |driver| prepared(driver, &declared, &wires);
        let drives = match setup.drives {
            Drives::Homed(driver) => {
                let driver = prepared(driver);
                let opening = Rc::new(Opening::new(plant.take(link, process, edp, driver, &mut observers)));
                link.prepare(edp, Rc::clone(&opening) as Rc<dyn Preparation>);
                Ok(opening)
            }
            Drives::Unhomed(homing) => Err(homing),
        };
        if setup.program.is_some()
            && let Some(board) = plant.board(link, place.ecp)
        {
            setup.activity.pass_on(board);
        }
        for shown in setup.shown {
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
                    robot: setup.robot,
                    drive,
                    tool: setup.tool,
                    period: place.period,
                    delay: place.delay,
                    space: setup.space,
                    following_error: setup.following_error,
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
        let mut program = setup.program;
        let activity = setup.activity;
        let triggered = place.triggered;
        let process = ProcessId::new(Role::Ecp, name);
        let pace = place.pace;
        let recorded = setup.replayed;
        let (signals, named) = (place.signals, place.named);
        link.body(
            place.ecp,
            Box::new(move |host| {
                let timed = Timed::new(host);
                let ecp =
                    Ecp::<'_, R>::new((process, model), timed.host(), mp, client, sensing, pace, recorded);
                let ecp = ecp.with_names(signals, named);
                let mut ecp = ecp.showing_instructions(program.is_some().then_some(activity));
                loop {
                    let outcome = ecp.run_program(|ecp| match &mut program {
                        Some(program) if triggered => ecp.serve(|ecp, _: Trigger| program(ecp)),
                        Some(program) => program(ecp),
                        None if triggered => ecp.serve(|_, _: Trigger| Ok(())),
                        None => crate::control::transparent::program(ecp),
                    });
                    let starts_again = ecp.answer_after_program(&outcome);
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
