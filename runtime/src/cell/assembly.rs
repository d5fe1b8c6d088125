//! Puts the processes of a cell on a link: the same calls in the same order, whichever link it is.

use std::rc::Rc;

use super::robot::Place;
use super::sensor::Requesters;
use super::{Cell, CellError, Outcomes};
use crate::ecp::Pace;
use crate::fault::{ProcessId, Role};
use crate::link::{Link, Nanos};
use crate::mp::{Mp, RobotPort};
use crate::name::Name;
use crate::sensing::Sensing;
use crate::stopping::missed_step_budget;

/// What the processes of a cell leave behind.
pub(crate) struct Assembly {
    /// How their programs ended.
    pub outcomes: Outcomes,
    /// Steps that the MP began.
    pub steps: Rc<core::cell::Cell<u64>>,
}

impl Cell {
    /// Puts every process of the cell on `link`.
    ///
    /// # Errors
    /// [`CellError`]: what is wrong with the set-up.
    pub(crate) fn put_on(mut self, link: &mut dyn Link) -> Result<Assembly, CellError> {
        let names = self.check()?;
        self.assemble(&names, link)
    }

    /// Puts every process of a cell, in which nothing is wrong, on `link`.
    pub(super) fn assemble(self, names: &[Name], link: &mut dyn Link) -> Result<Assembly, CellError> {
        let nudged = self.program.is_none();
        let patience = (self.step * (missed_step_budget(self.step) + 1)).as_nanos() as Nanos;
        let outcomes = Outcomes::default();
        let mp = link.place(ProcessId::MP);
        let ecps: Vec<_> = names.iter().map(|name| link.place(ProcessId::new(Role::Ecp, *name))).collect();

        let mut mp_sensing = Sensing { ports: Vec::new(), patience };
        // An ECP loses patience first, so that it can say with whom.
        let shorter = patience - self.step.as_nanos() as Nanos;
        let mut ecp_sensing: Vec<_> =
            names.iter().map(|_| Sensing { ports: Vec::new(), patience: shorter }).collect();
        // EDPs tick first half a servo period after a step's beginning.
        let servo = self.robots.iter().map(|robot| robot.servo_period()).min();
        let delay =
            crate::interpolation::delay(self.step, self.robots.iter().map(|robot| robot.servo_period()));
        let grace = (servo.unwrap_or(self.step).min(self.step).as_nanos() / 2) as Nanos;
        let mut requesters = Requesters {
            link,
            step: self.step,
            mp,
            robots: names,
            ecps: &ecps,
            mp_sensing: &mut mp_sensing,
            ecp_sensing: &mut ecp_sensing,
        };
        for sensor in self.sensors {
            sensor.spawn(&mut requesters)?;
        }
        let mut ports = Vec::new();
        for ((robot, name), (&ecp, sensing)) in
            self.robots.into_iter().zip(names).zip(ecps.iter().zip(ecp_sensing))
        {
            let (client, server) = link.port(mp, ecp);
            let steps = robot.stop_steps(self.step, delay.unwrap_or_default());
            ports.push(RobotPort::new(
                *name,
                (robot.kind(), robot.kind_name()),
                client,
                steps,
                robot.is_homed(),
            ));
            let period = self.step.as_nanos() as Nanos;
            let pace = Pace { period, grace, stop_steps: steps };
            let place = Place { name: *name, ecp, step: self.step, delay, pace, nudged };
            robot.spawn(link, place, server, sensing, Rc::clone(&outcomes))?;
        }

        let close = link.closer();
        let (operator, step, rate_change, program) =
            (self.operator, self.step, self.rate_change, self.program);
        let (hook, guard) = (self.hook, self.guard);
        let steps = Rc::new(core::cell::Cell::new(0));
        let (counted, recorded) = (Rc::clone(&steps), Rc::clone(&outcomes));
        link.body(
            mp,
            Box::new(move |waiter| {
                let mut mp = Mp::new(waiter, ports, mp_sensing, operator, hook, (step, grace), rate_change);
                mp.watch_by(guard);
                let outcome = mp.run_program(|mp| match program {
                    Some(program) => program(mp),
                    None => mp.nudge(),
                });
                counted.set(mp.step());
                recorded.borrow_mut().push((ProcessId::MP, outcome));
                close();
            }),
        )?;
        Ok(Assembly { outcomes, steps })
    }
}
