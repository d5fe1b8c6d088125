//! What a cell asks of a robot of any kind.

use core::any::{Any, TypeId};
use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use super::stand_in::StandIn;
use super::{RobotPlacement, RobotSetup};
use crate::cell::layout::joints;
use crate::cell::{CellError, limits};
use crate::control::homing::Drives;
use crate::control::mp::RobotFacts;
use crate::control::plant::Site;
use crate::control::replay::RecordedRobot;
use crate::control::replay::drives::recorded_drives;
use crate::link::Link;
use crate::link::memory::Stuck;
use crate::model::drive_fault::DriveFault;
use crate::model::driver::Channels;
use crate::model::fault::ProcessId;
use crate::model::joints::JointVector;
use crate::model::load::{Load, Tool};
use crate::model::name::Name;
use crate::model::pace::ServoPeriod;
use crate::model::robot::{InterpolationSpace, NoInverse, Robot};
use crate::model::time::Nanos;
use crate::observe::activity::Activity;
use crate::observe::layout::{HardwareLayout, RobotLayout};
use crate::observe::servo::Observation;
use crate::observe::shown::Shown;
use crate::safety::limits::rates::least_margin;
use crate::safety::rate::RateMargin;
use crate::safety::stopping::{longest_braking, stop_steps};

/// An observer of several robots.
pub(in crate::cell) type SharedObserver = Rc<RefCell<dyn FnMut(&Observation<'_>)>>;

/// A robot of any kind: its set-up, whose type its kind tells.
pub trait AnyRobot: Any {
    /// Shows every servo period to an observer of several robots.
    fn watch(&mut self, observer: SharedObserver, mp: Shown<Activity>);
    /// Calls a function with the time at the end of every servo period \[ns\].
    fn on_servo_period(&mut self, call: Box<dyn FnMut(Nanos)>);
    /// Takes away all observers that it has.
    fn unwatch(&mut self);
    /// Its drives read from a recording.
    fn replay(&mut self, recorded: Rc<RecordedRobot>, step: Duration);
    /// Its name in the cell.
    fn name(&self) -> &str;
    /// Its kind's name, for messages.
    fn kind_name(&self) -> &'static str;
    /// What the MP is to know of it: its name in the cell, its ECP, and the steps after which it must stand when it was told to stop.
    fn facts(&self, name: Name, process: ProcessId, stop_steps: u64) -> RobotFacts;
    /// What it is made of, in plain numbers.
    fn layout(&self, stop_time: Duration) -> RobotLayout;
    /// Whether its ECP has a program of its own.
    fn has_program(&self) -> bool;
    /// When its drives take a position.
    fn servo_period(&self) -> ServoPeriod;
    /// Whether its drives know where it is.
    fn is_homed(&self) -> bool;
    /// What its drives are, for the whole machine.
    fn hardware(&self) -> Option<String>;
    /// Whether its drives are in a simulator of others, which follows the virtual clock.
    fn is_in_simulator(&self) -> bool;
    /// The Python module of that simulator.
    fn python(&self) -> Option<String>;
    /// Its calibration, as its controller tells it.
    ///
    /// # Errors
    /// [`DriveFault`] when that cannot be reached.
    fn calibration(&mut self) -> Result<Option<String>, DriveFault>;
    /// Itself as a URDF with its tool, as [`Robot::urdf`].
    fn urdf(&self) -> Option<String>;
    /// Lets simulated drives stand in for real ones, if it has such.
    ///
    /// # Errors
    /// Why there are none that could.
    fn simulate(&mut self, name: Name) -> Result<(), CellError>;
    /// Whether its drives may be in the plant.
    fn is_simulated(&mut self) -> bool;
    /// What forbids that its EDP interpolates where it is told to.
    fn check_space(&self, name: Name) -> Option<CellError>;
    /// The longest time that it brakes for \[s\].
    fn braking_time(&self) -> f64;
    /// The least that it leaves at this rate for changes of the rate, in steps of this length.
    fn least_margin(&self, rate: f64, step: Duration) -> RateMargin;
    /// The robot that it is mounted on.
    fn mounted_on(&self) -> Option<&str>;
    /// What is wrong with the names of its inputs and outputs.
    fn check_signals(&self, name: Name) -> Vec<CellError>;
    /// The longest stop that it may take, in a cell that allows others `cell`.
    fn stop_time(&self, cell: Duration) -> Duration;
    /// What is wrong with its limits, in a cell that notices a loss after `noticing` \[s\] and allows a stop of this robot to take
    /// `stop_time`.
    fn check_limits(&self, name: Name, noticing: f64, stop_time: Duration) -> Vec<CellError>;
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
        place: RobotPlacement,
    ) -> Result<(), Stuck>;
}

impl<R: Robot> AnyRobot for RobotSetup<R> {
    fn watch(&mut self, observer: SharedObserver, mp: Shown<Activity>) {
        let ecp = self.processes.activity.clone();
        let name = self.name.clone();
        let robot = self.robot.clone();
        let mounted_on = self.mounted_on.clone();
        let joints: Vec<_> = (0..R::Joints::LEN).map(|i| robot.joint(i)).collect();
        self.processes.observers.push(Box::new(move |record| {
            let measured = &record.measured.position;
            let observation = Observation {
                robot: &name,
                kind: R::KIND,
                time: record.time,
                demanded: record.demanded.as_slice(),
                measured: measured.as_slice(),
                joints: &joints,
                mounted_on: mounted_on.as_deref(),
                frames: &|visit| robot.frames(measured, visit),
                tool: robot.forward(measured) * record.tool,
                mp: &mp,
                ecp: &ecp,
            };
            (observer.borrow_mut())(&observation);
        }));
    }

    fn on_servo_period(&mut self, mut call: Box<dyn FnMut(Nanos)>) {
        self.processes.observers.push(Box::new(move |record| call((record.time * 1e9).round() as Nanos)));
    }

    fn unwatch(&mut self) {
        self.processes.observers.clear();
    }

    fn replay(&mut self, recorded: Rc<RecordedRobot>, step: Duration) {
        // Whether the joints followed, the run that was recorded has checked; what is between two steps is not recorded.
        self.processes.following_error = R::Joints::from_joints(|_| f64::INFINITY);
        self.processes.drives = recorded_drives(&self.processes.drives, Rc::clone(&recorded), step);
        self.processes.replayed = Some(recorded);
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn kind_name(&self) -> &'static str {
        R::KIND
    }

    fn facts(&self, name: Name, process: ProcessId, stop_steps: u64) -> RobotFacts {
        RobotFacts {
            name,
            process,
            kind: TypeId::of::<R>(),
            kind_name: R::KIND,
            model: Rc::new(self.robot.clone()),
            joints: R::Joints::LEN,
            signals: self.processes.signals.names(),
            homed: self.is_homed(),
            stop_steps,
        }
    }

    fn layout(&self, stop_time: Duration) -> RobotLayout {
        RobotLayout {
            name: self.name.clone(),
            kind: R::KIND,
            servo: self.processes.drives.period(),
            drives: match (self.processes.drives.hardware(), self.is_in_simulator) {
                (Some(simulator), true) => HardwareLayout::Simulator(simulator),
                (hardware, _) => HardwareLayout::of(hardware, self.stand_in.in_place_of()),
            },
            homed: self.is_homed(),
            ecp_program: self.processes.program.is_some(),
            space: self.processes.space,
            mounted_on: self.mounted_on.clone(),
            stop_time: self.stop_time.unwrap_or(stop_time),
            coupled_limits: self.robot.coupled_limits(),
            signals: self.processes.signals.layout(self.channels().unwrap_or(Channels::ALL).when_lost),
            joints: joints(&self.robot, &self.processes.following_error),
            figure: Arc::new(self.robot.clone()),
        }
    }

    fn has_program(&self) -> bool {
        self.processes.program.is_some()
    }

    fn servo_period(&self) -> ServoPeriod {
        self.processes.drives.servo_period()
    }

    fn check_space(&self, name: Name) -> Option<CellError> {
        let limits = self.robot.limits();
        let middle = (limits.lower + limits.upper) * 0.5;
        let pose = self.robot.forward(&middle);
        let at_a_value = self.robot.inverse_at(&pose, 0.0, &middle);
        let is_redundant = R::Joints::LEN > 6 || at_a_value != Err(NoInverse::NotRedundant);
        (self.processes.space == InterpolationSpace::Task && is_redundant)
            .then_some(CellError::TaskSpace(name))
    }

    fn is_homed(&self) -> bool {
        matches!(self.processes.drives, Drives::Homed(_))
    }

    fn hardware(&self) -> Option<String> {
        self.processes.drives.hardware()
    }

    fn is_in_simulator(&self) -> bool {
        self.is_in_simulator
    }

    fn python(&self) -> Option<String> {
        match &self.processes.drives {
            Drives::Homed(driver) => driver.python(),
            Drives::Unhomed(_) => None,
        }
    }

    fn calibration(&mut self) -> Result<Option<String>, DriveFault> {
        match &mut self.processes.drives {
            Drives::Homed(driver) => driver.calibration(),
            Drives::Unhomed(_) => Ok(None),
        }
    }

    fn urdf(&self) -> Option<String> {
        let load = self.processes.signals.load.unwrap_or(Load::NONE);
        self.robot.urdf(&self.name, &Tool { frame: self.processes.tool, load })
    }

    fn simulate(&mut self, name: Name) -> Result<(), CellError> {
        let Some(hardware) = self.processes.drives.hardware() else { return Ok(()) };
        let stand_in = core::mem::replace(&mut self.stand_in, StandIn::For(hardware.clone()));
        let drives = stand_in.drives(&self.robot, self.processes.drives.period())?;
        self.processes.drives = drives
            .filter(|drives| drives.hardware().is_none())
            .ok_or(CellError::NoStandIn { robot: name, hardware })?;
        Ok(())
    }

    fn is_simulated(&mut self) -> bool {
        match &mut self.processes.drives {
            Drives::Homed(driver) => driver.simulation().is_some(),
            Drives::Unhomed(_) => false,
        }
    }

    fn mounted_on(&self) -> Option<&str> {
        self.mounted_on.as_deref()
    }

    fn check_signals(&self, name: Name) -> Vec<CellError> {
        let wrong = self.processes.signals.check(self.channels()).into_iter();
        wrong.map(|(signal, wrong)| CellError::Signal { robot: name, signal, wrong }).collect()
    }

    fn stop_time(&self, cell: Duration) -> Duration {
        self.stop_time.unwrap_or(cell)
    }

    fn check_limits(&self, name: Name, noticing: f64, stop_time: Duration) -> Vec<CellError> {
        limits::check(
            name,
            |i| self.robot.joint(i),
            self.robot.limits(),
            &self.processes.following_error,
            noticing,
            stop_time,
        )
    }

    fn braking_time(&self) -> f64 {
        longest_braking(self.robot.limits())
    }

    fn least_margin(&self, rate: f64, step: Duration) -> RateMargin {
        least_margin(self.robot.limits(), rate, step.as_secs_f64())
    }

    fn stop_steps(&self, step: Duration, delay: Duration) -> u64 {
        stop_steps(self.robot.limits(), step, delay)
    }

    fn spawn(
        self: Box<Self>,
        link: &mut dyn Link,
        plant: &mut Site,
        place: RobotPlacement,
    ) -> Result<(), Stuck> {
        self.put_on(link, plant, place)
    }
}

impl<R: Robot> RobotSetup<R> {
    /// The channels of its drives; those of drives that look for their marks first are not known.
    fn channels(&self) -> Option<Channels> {
        match &self.processes.drives {
            // Drives without a name are simulated: they get signals.
            Drives::Homed(driver) if driver.channels() == Channels::NONE && driver.hardware().is_none() => {
                Some(Channels::ALL)
            }
            Drives::Homed(driver) => Some(driver.channels()),
            Drives::Unhomed(_) => None,
        }
    }
}
