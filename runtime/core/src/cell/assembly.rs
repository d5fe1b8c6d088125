//! Puts the processes of a cell on a link: the same calls in the same order, whichever link it is.

use core::any::TypeId;
use core::time::Duration;
use std::rc::Rc;

use super::lower::{Above, LowerSetup, scoped};
use super::robot::{Outcomes, RobotPlacement};
use super::sensor::Requesters;
use super::{Cell, CellError};
use crate::control::ecp::Pace;
use crate::control::mp::{Mp, MpTiming, RobotFacts, RobotPort};
use crate::control::overruns::Timed;
use crate::control::plant::{Bodies, Rests, Site};
use crate::control::sensing::Sensing;
use crate::link::timeout::AnswerTimeout;
use crate::link::{Link, Simulation};
use crate::model::fault::{ProcessId, Role};
use crate::model::list::Owner;
use crate::model::lower_cell::LowerCell;
use crate::model::name::Name;
use crate::model::robot::Robot;
use crate::model::time::Nanos;
use crate::observe::shown::AnyShown;
use crate::observe::step_observer::{StepEvent, StepObservers};

/// What the processes of a cell leave behind.
pub struct Assembly {
    /// How their programs ended.
    pub outcomes: Outcomes,
    /// Steps that the MP began.
    pub steps: Rc<core::cell::Cell<u64>>,
    /// How robots in the plant came to a standstill whose commands had stopped.
    pub rests: Rests,
}

impl Cell {
    /// Puts every process of the cell on `link`.
    ///
    /// # Errors
    /// [`CellError`]: what is wrong with the set-up.
    pub fn put_on(mut self, link: &mut dyn Link) -> Result<Assembly, CellError> {
        let names = self.check()?;
        self.assemble(&names, link)
    }

    /// Puts every process of a cell, in which nothing is wrong, on `link`.
    pub(super) fn assemble(self, names: &[Name], link: &mut dyn Link) -> Result<Assembly, CellError> {
        let mp = link.place(ProcessId::MP);
        self.assemble_at(mp, None, names, link)
    }

    /// The same with the MP at its place; of a lower cell what is above it, with the plant that all cells share.
    fn assemble_at(
        mut self,
        mp: usize,
        above: Option<(Above, &mut Site)>,
        names: &[Name],
        link: &mut dyn Link,
    ) -> Result<Assembly, CellError> {
        if link.simulation() != Simulation::Free {
            self.parts.refuse_hardware(names, self.watching.recorded.is_some())?;
        }
        let triggered = self.coordination.program.is_none();
        let timeout = AnswerTimeout::of_step(self.timing.step);
        let outcomes = Outcomes::default();
        let (above, shared) = above.unzip();
        let within = above.as_ref().map(|above| above.name);
        let me = ProcessId { name: within, ..ProcessId::MP };
        let processes: Vec<_> = names
            .iter()
            .map(|&name| scoped(name, within).map(|name| ProcessId::new(Role::Ecp, name)))
            .collect::<Result<_, _>>()?;
        let ecps: Vec<_> = processes.iter().map(|&process| link.place(process)).collect();

        let mut own = None;
        let plant = match shared {
            Some(shared) => shared,
            None => {
                let anything = self.parts.is_simulated();
                own.insert(Site::new(link, self.timing.step, anything, self.watching.watched_in_plant))
            }
        };
        let step_before = plant.goes_by(self.timing.step);

        let stop_steps = self.stop_steps();
        let path_stop = self.path_stop_steps();
        let delay = self.delay();
        let frames = self.watching.frames_to(self.timing.step);
        let of_all = self.watching.of_all;
        let step_observers =
            StepObservers::to(self.watching.observers.iter().chain(&of_all).cloned().collect());
        let bodies = self.watching.bodies.into_iter().map(|(_, body)| body).collect();
        let bodies = Bodies::of(bodies, step_observers.of(ProcessId::PLANT), self.timing.step);
        let here = if bodies.is_idle() { None } else { plant.take_bodies(bodies) };
        if let (Some(mut bodies), Some(robot)) = (here, self.parts.robots.first_mut()) {
            // One robot's servo periods are the occasions to look.
            robot.on_servo_period(Box::new(move |time| bodies.look(time)));
        }
        let mut mp_sensing = Sensing {
            owner: Owner::unique(),
            ports: Vec::new(),
            timeout,
            step_observers: step_observers.of(me),
        };
        // An ECP gives up first, so that it can say with whom, but not before the last demand that is bridged.
        let shorter = AnswerTimeout { most: timeout.most - timeout.again / 2, ..timeout };
        let of_ecp = |process: &ProcessId| {
            let step_observers = step_observers.of(*process);
            Sensing { owner: Owner::unique(), ports: Vec::new(), timeout: shorter, step_observers }
        };
        let mut ecp_sensing: Vec<_> = processes.iter().map(of_ecp).collect();
        // EDPs tick first half a servo period after a step's beginning.
        let servo = self.parts.robots.iter().map(|robot| robot.servo_period().length).min();
        let grace = (servo.unwrap_or(self.timing.step).min(self.timing.step).as_nanos() / 2) as Nanos;
        let mut requesters = Requesters {
            recorded: self.watching.recorded.clone(),
            link,
            plant: &mut *plant,
            step: self.timing.step,
            mp,
            robots: names,
            within,
            ecps: &ecps,
            mp_sensing: &mut mp_sensing,
            ecp_sensing: &mut ecp_sensing,
            frames,
            wanted: Vec::new(),
        };
        for sensor in self.parts.sensors {
            sensor.spawn(&mut requesters)?;
        }
        let wanted = requesters.wanted;
        let mut ports = Vec::new();
        let named = Rc::new(self.parts.named);
        let ecps = ecps.iter().zip(&processes).zip(ecp_sensing);
        let robots = self.parts.robots.into_iter().zip(names).zip(ecps);
        for (i, ((robot, name), ((&ecp, &process), sensing))) in robots.enumerate() {
            let (client, server) = link.port(mp, ecp);
            let facts = robot.facts(*name, process, stop_steps);
            let signals = Rc::clone(&facts.signals);
            ports.push(RobotPort::new(facts, client));
            let period = self.timing.step.as_nanos() as Nanos;
            let pace = Pace { period, grace, stop_steps };
            let place = RobotPlacement {
                name: process.name.unwrap_or(*name),
                ecp,
                mp: server,
                sensing,
                period: self.timing.step,
                delay,
                pace,
                triggered,
                step_observers: step_observers.clone(),
                signals,
                named: Rc::clone(&named),
                outcomes: Rc::clone(&outcomes),
                wanted: wanted.iter().filter(|wanted| wanted.robot == i).cloned().collect(),
            };
            robot.spawn(link, plant, place)?;
        }
        if let Some(board) = plant.board(link, mp) {
            self.coordination.activity.pass_on(board);
        }
        let step = self.timing.step;
        for mut lower in self.parts.cells {
            lower.cell.watching.of_all.clone_from(&of_all);
            ports.push(lower.put_under(link, plant, (mp, within, step))?);
        }
        plant.goes_by(step_before);
        let rests = Rests::default();
        if let Some(plant) = own {
            plant.spawn(link, Rc::clone(&rests))?;
        }

        let close = link.closer();
        let upper = above.map(Above::upper);
        let rate_change = self.timing.rate_change;
        let timing = MpTiming { period: self.timing.step, grace, rate_change, path_stop };
        let mut program = self.coordination.program;
        let after_fault = self.coordination.after_fault;
        let script = self.watching.recorded.map(|recorded| Rc::clone(&recorded.script));
        let steps = Rc::new(core::cell::Cell::new(0));
        let counted = Rc::clone(&steps);
        let ended = Rc::clone(&outcomes);
        link.body(
            mp,
            Box::new(move |host| {
                let timed = Timed::new(host);
                let mp = Mp::new(
                    timed.host(),
                    ports,
                    mp_sensing,
                    (self.coordination.operator, self.coordination.hook, self.coordination.activity),
                    &timing,
                );
                let mp = mp.with_names(named);
                let is_lower = upper.is_some();
                let mut mp = match upper {
                    Some(upper) => mp.under(upper, me),
                    None => mp,
                };
                mp.watch_by(self.coordination.guard);
                mp.follow(script);
                let outcome = mp.run_program(after_fault, |mp| match &mut program {
                    Some(program) => program(mp),
                    None => mp.trigger(),
                });
                counted.set(mp.step());
                let end = StepEvent::End { step: mp.step() };
                step_observers.of(me).show_fault(host.waiter.now(), &end, outcome.as_ref().err());
                ended.borrow_mut().push((me, outcome));
                if is_lower {
                    mp.serve_upper();
                } else {
                    close();
                }
            }),
        )?;
        Ok(Assembly { outcomes, steps, rests })
    }
}

impl LowerSetup {
    /// Puts its processes on the link, below the MP at the place `upper` of a cell with this step, which may itself be `within` another
    /// one; that MP's port of it. What becomes of its programs is the upper MP's to tell.
    fn put_under(
        mut self,
        link: &mut dyn Link,
        plant: &mut Site,
        (upper, within, step): (usize, Option<Name>, Duration),
    ) -> Result<RobotPort, CellError> {
        let own = Name::new(&self.name)?;
        let name = scoped(own, within)?;
        let robots = self.cell.check()?;
        let stop_steps = self.stop_steps(step);
        let process = ProcessId::new(Role::Mp, name);
        let mp = link.place(process);
        let (client, port) = link.port(upper, mp);
        let above = Above { name, port, step };
        self.cell.assemble_at(mp, Some((above, plant)), &robots, link)?;
        let facts = RobotFacts {
            name: own,
            process,
            kind: TypeId::of::<LowerCell>(),
            kind_name: LowerCell::KIND,
            model: Rc::new(()),
            joints: 0,
            signals: Rc::default(),
            // Its program comes to its orders when its robots are homed.
            homed: false,
            stop_steps,
        };
        Ok(RobotPort::new(facts, client).of_cell())
    }
}
