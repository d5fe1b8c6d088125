//! A robot of a cell: how it is set up.
//!
//! In: a model, its drives, a program. Out: a [`RobotSetup`]. [`any`] is what a cell asks of robots of all kinds, [`spawning`]
//! how the ECP and the EDP of one come to life, [`stand_in`] what takes the place of real drives.

mod any;
pub mod signals;
mod spawning;
mod stand_in;

use core::time::Duration;
use std::rc::Rc;

use super::CellError;
use crate::control::ecp::Ecp;
use crate::control::homing::{Drives, HomingOf};
use crate::model::any_kind::{AnyKind, DrivesOf};
use crate::model::driver::{Driver, Homing};
use crate::model::fault::Fault;
#[cfg(doc)]
use crate::model::list::RobotHandle;
use crate::model::load::Load;
use crate::model::pose::Pose;
use crate::model::robot::{InterpolationSpace, Robot};
use crate::model::stepped::{Simulator, SteppedDrives};
use crate::model::wire::Wire;
use crate::observe::servo::ServoRecord;
use crate::observe::shown::Shown;

pub use any::AnyRobot;
pub(super) use any::SharedObserver;
use signals::{InputSetup, OutputSetup};
use spawning::ProcessSetup;
pub use spawning::{Outcomes, RobotPlacement, StateWanted};
use stand_in::StandIn;

/// Why a robot cannot move in a simulator of others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoSimulator {
    /// Its drives are this hardware.
    Real(String),
    /// Its drives do not know where it is.
    Unhomed,
}

/// A robot of a cell: its model, its drives and its program.
pub struct RobotSetup<R: Robot> {
    name: String,
    robot: R,
    stand_in: StandIn<R>,
    /// Its drives are in a simulator of others.
    is_in_simulator: bool,
    /// The robot on whose flange it is mounted.
    mounted_on: Option<String>,
    /// The longest stop that it may take; the cell's where it says nothing.
    stop_time: Option<Duration>,
    processes: ProcessSetup<R::Joints>,
}

impl<R: Robot> RobotSetup<R> {
    /// A robot `name` with its drives. Its following error may be what its velocity limit covers in 50 ms.
    pub fn new(name: &str, robot: R, driver: impl Driver<R> + 'static) -> Self {
        Self::with_drives(name, robot, Drives::Homed(Box::new(DrivesOf::new(driver))))
    }

    /// A robot `name` whose drives do not know where it is: they look for their reference marks when the cell starts. The
    /// MP's program begins when all robots of the cell have found theirs, and so does what an ECP serves.
    pub fn unhomed<H>(name: &str, robot: R, homing: H) -> Self
    where
        H: Homing<R, Drives: 'static> + 'static,
    {
        Self::with_drives(name, robot, Drives::Unhomed(Box::new(HomingOf::new(homing))))
    }

    /// Whether its drives know where it is.
    pub fn is_homed(&self) -> bool {
        matches!(self.processes.drives, Drives::Homed(_))
    }

    /// Simulated drives that stand in for real ones where nothing real may move: in a dry run, and in
    /// [`Cell::simulated`](super::Cell::simulated). Drives that name no [hardware](Driver::hardware) need none.
    #[must_use]
    pub fn stand_in(mut self, driver: impl Driver<R> + 'static) -> Self {
        self.stand_in = StandIn::Drives(Box::new(DrivesOf::new(driver)));
        self
    }

    /// Lets the robot move in a simulator that others wrote, from where its simulated drives stand: these become its
    /// [stand-in](Self::stand_in), and say its servo period and whether brakes hold it without power.
    ///
    /// # Errors
    /// [`NoSimulator`]: its own drives are no simulated ones that know where it is.
    pub fn in_simulator(mut self, simulator: Box<dyn Simulator>) -> Result<Self, NoSimulator> {
        let Drives::Homed(own) = &self.processes.drives else { return Err(NoSimulator::Unhomed) };
        if let Some(hardware) = own.hardware() {
            return Err(NoSimulator::Real(hardware));
        }
        let Ok(measured) = own.measured() else { return Err(NoSimulator::Unhomed) };
        let drives = SteppedDrives::new(simulator, measured.position, own.period(), own.has_brakes());
        let own = core::mem::replace(&mut self.processes.drives, Drives::Homed(Box::new(drives)));
        self.is_in_simulator = true;
        if let (StandIn::None, Drives::Homed(own)) = (&self.stand_in, own) {
            self.stand_in = StandIn::Drives(own);
        }
        Ok(self)
    }

    /// The same, with the drives of another set-up of this kind of robot, which `make` makes when they are needed: of the
    /// model, and for drives of this servo period. A stand-in that it has stays.
    #[must_use]
    pub fn stand_in_of(
        mut self,
        make: impl FnOnce(&R, Duration) -> Result<RobotSetup<R>, CellError> + 'static,
    ) -> Self {
        if matches!(self.stand_in, StandIn::None) {
            self.stand_in = StandIn::Made(Box::new(make));
        }
        self
    }

    fn with_drives(name: &str, robot: R, drives: Drives<AnyKind<R::Joints>>) -> Self {
        let following_error = robot.limits().velocity * 0.05;
        RobotSetup {
            name: name.to_owned(),
            stand_in: StandIn::None,
            is_in_simulator: false,
            mounted_on: None,
            stop_time: None,
            processes: ProcessSetup::new(drives, following_error),
            robot,
        }
    }

    /// The tool at the start: `X_FE`, the tool frame in the flange frame.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn tool(mut self, X_FE: Pose) -> Self {
        self.processes.tool = X_FE;
        self
    }

    /// Where the EDP interpolates between the demands of two steps, in joints unless told otherwise.
    #[must_use]
    pub fn interpolation(mut self, space: InterpolationSpace) -> Self {
        self.processes.space = space;
        self
    }

    /// The largest difference between demanded and measured joint positions [rad or m], each > 0.
    #[must_use]
    pub fn following_error(mut self, limit: R::Joints) -> Self {
        self.processes.following_error = limit;
        self
    }

    /// Mounts it, a gripper say, on the flange of another robot of the cell. The world of its model is then that flange: its
    /// base stands in it, and its poses are in it. Pictures draw it there.
    #[must_use]
    pub fn mounted_on(mut self, robot: &str) -> Self {
        self.mounted_on = Some(robot.to_owned());
        self
    }

    /// What the robot carries at the start, its tool included: its drives are told.
    #[must_use]
    pub fn load(mut self, load: Load) -> Self {
        self.processes.signals.load = Some(load);
        self
    }

    /// Names an input of the robot's controller. A program asks for it by [`RobotHandle::input`], an ECP by [`Ecp::input`].
    #[must_use]
    pub fn input(mut self, input: InputSetup) -> Self {
        self.processes.signals.inputs.push(input);
        self
    }

    /// Names an output of the robot's controller, and says what it does at a stop. A program asks for it by
    /// [`RobotHandle::output`], an ECP by [`Ecp::output`].
    #[must_use]
    pub fn output(mut self, output: OutputSetup) -> Self {
        self.processes.signals.outputs.push(output);
        self
    }

    /// The longest time from the cause of a stop to a standstill that this robot may take, in the place of that of
    /// [the cell](super::Cell::stop_time): longer for a slow belt, shorter for an arm. A robot that would take longer is
    /// refused, and a protective stop leaves the path in time for every robot. Robots that move together along one twist
    /// brake as the slowest of them does.
    #[must_use]
    pub fn stop_time(mut self, limit: Duration) -> Self {
        self.stop_time = Some(limit);
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

    // What runs a program is compiled where there is one: a robot without one needs no ECP of its kind.
    pub(super) fn give_program(
        &mut self,
        mut program: impl FnMut(&mut Ecp<R>) -> Result<(), Fault> + 'static,
    ) {
        let model = Rc::new(self.robot.clone());
        self.processes.program =
            Some(Box::new(move |start, activity| start.run(model, activity, &mut program)));
    }

    /// Calls `observer` after every servo period.
    #[must_use]
    pub fn observe(mut self, mut observer: impl FnMut(&ServoRecord<R>) + 'static) -> Self {
        self.processes.observers.push(Box::new(move |&ServoRecord { time, demanded, measured, tool }| {
            observer(&ServoRecord { time, demanded, measured, tool });
        }));
        self
    }

    /// Lets observers see what the robot's program shows, in whichever process they look on.
    #[must_use]
    pub fn shows<T: Wire>(mut self, shown: &Shown<T>) -> Self {
        self.processes.shown.push(Box::new(shown.clone()));
        self
    }
}
