//! How an EDP reaches its drives: real ones and, on the memory link, simulated ones are here; others are in the plant.
//!
//! In: the position for the end of a servo period. Out: what the encoders read, and which position that belongs to.

use core::time::Duration;
use std::rc::Rc;

use crate::control::command::{Command, DriveSettings, Reading, RegulatorSets, Switch};
use crate::control::guarded::guarded;
use crate::link::message::{Kind, Message};
use crate::link::{Board, Client, Waiter};
use crate::model::drive_fault::DriveFault;
use crate::model::driver::{Driver, Measured, Recovery, Regulators};
use crate::model::fault::{Fault, FaultKind, ProcessId};
use crate::model::joints::JointVector;
use crate::model::load::Load;
use crate::model::pace::{Pace, Pulse};
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::model::signals::{Outputs, Signals};
use crate::model::time::Nanos;
use crate::model::wrench::Wrench;

/// The drives of a robot.
pub(crate) enum Drive<R: Robot> {
    /// In this process.
    Here(Box<dyn Driver<R>>),
    /// In this process, or in the plant, and not to be reached, for this reason.
    Closed(Unopened<R>),
    /// In the plant.
    Plant(Box<PlantDrive<R>>),
}

/// What the encoders read, and the position that the drives had been told for that time.
pub(super) struct Followed<J> {
    pub measured: Measured<J>,
    pub demanded: J,
}

/// Where nothing is read, there is no number.
fn unknown<J: JointVector>() -> Measured<J> {
    let unknown = J::from_joints(|_| f64::NAN);
    Measured { position: unknown, velocity: unknown }
}

/// Drives that could not be opened, or read when they were to begin.
pub(crate) struct Unopened<R: Robot> {
    /// There, but while a reset tries again; `None`: nobody can.
    driver: Option<Box<dyn Driver<R>>>,
    period: Duration,
    pace: Pace,
    fault: Fault,
}

impl<R: Robot> Drive<R> {
    /// Opens drives that are in this process.
    pub fn opened(self) -> Self {
        match self {
            Drive::Here(driver) => Drive::open(driver),
            Drive::Closed(_) | Drive::Plant(_) => self,
        }
    }

    fn open(mut driver: Box<dyn Driver<R>>) -> Self {
        let opened = guarded(|| driver.open().map_err(|trip| Fault::of_drive(&trip)));
        match opened.and_then(|opened| opened) {
            Ok(()) => Drive::Here(driver),
            Err(fault) => Drive::closed(driver, fault),
        }
    }

    fn closed(driver: Box<dyn Driver<R>>, fault: Fault) -> Self {
        let (period, pace) = (driver.period(), driver.pace());
        Drive::Closed(Unopened { driver: Some(driver), period, pace, fault })
    }

    /// Simulated drives that cannot be read, in the plant, which alone has them.
    pub fn unread_in_plant(driver: &dyn Driver<R>, trip: &DriveFault) -> Self {
        let (period, pace) = (driver.period(), driver.pace());
        Drive::Closed(Unopened { driver: None, period, pace, fault: Fault::of_drive(trip) })
    }

    /// What the encoders read first, and the drives. Those that cannot be read are let go, to be opened again at a reset.
    pub fn begin(self) -> (Self, Measured<R::Joints>) {
        match (guarded(|| self.measured()).and_then(|measured| measured), self) {
            (Ok(measured), drive) => (drive, measured),
            (Err(fault), drive) => (drive.let_go(fault), unknown()),
        }
    }

    /// Drives that cannot be used, closed, to be opened again at a reset.
    pub fn let_go(self, fault: Fault) -> Self {
        match self {
            Drive::Here(mut driver) => {
                // Whether that goes well changes nothing.
                drop(guarded(|| driver.close()));
                Drive::closed(driver, fault)
            }
            Drive::Closed(_) | Drive::Plant(_) => self,
        }
    }

    /// Tells a robot that paces itself to stay at `rest`, if one of its periods has begun.
    ///
    /// # Errors
    /// The drives' fault.
    pub fn keep(&mut self, rest: &R::Joints) -> Result<(), Fault> {
        let Drive::Here(driver) = self else { return Ok(()) };
        let begun = driver.pulse(Duration::ZERO).map_err(|trip| Fault::of_drive(&trip))?;
        match begun {
            Some(_) => driver.tick(rest).map(drop).map_err(|trip| Fault::of_drive(&trip)),
            None => Ok(()),
        }
    }

    /// Why the drives could not be opened.
    pub fn unopened(&self) -> Option<&Fault> {
        match self {
            Drive::Closed(unopened) => Some(&unopened.fault),
            Drive::Here(_) | Drive::Plant(_) => None,
        }
    }

    /// Lets the drives go.
    pub fn close(&mut self) {
        match self {
            Drive::Here(driver) => driver.close(),
            Drive::Closed(_) | Drive::Plant(_) => {}
        }
    }

    /// Where the drives hold the robot by themselves, if they know that better than by what the encoders read.
    pub fn held(&self) -> Option<R::Joints> {
        match self {
            Drive::Here(driver) => driver.held(),
            Drive::Closed(_) | Drive::Plant(_) => None,
        }
    }

    pub fn period(&self) -> Duration {
        match self {
            Drive::Here(driver) => driver.period(),
            Drive::Closed(unopened) => unopened.period,
            Drive::Plant(drive) => drive.period,
        }
    }

    /// Who says when the servo periods begin. Simulated drives in the plant are paced by the cell.
    pub fn pace(&self) -> Pace {
        match self {
            Drive::Here(driver) => driver.pace(),
            Drive::Closed(unopened) => unopened.pace,
            Drive::Plant(_) => Pace::Cell,
        }
    }

    /// The beginning of a servo period that the robot has told by `now`.
    ///
    /// # Errors
    /// The drives' fault.
    pub fn pulse(&mut self, now: Nanos) -> Result<Option<Pulse>, Fault> {
        match self {
            Drive::Here(driver) => {
                driver.pulse(Duration::from_nanos(now)).map_err(|trip| Fault::of_drive(&trip))
            }
            Drive::Closed(unopened) => Err(unopened.fault.clone()),
            Drive::Plant(_) => Ok(None),
        }
    }

    /// What the encoders read now.
    ///
    /// # Errors
    /// The drives' fault.
    pub fn measured(&self) -> Result<Measured<R::Joints>, Fault> {
        match self {
            Drive::Here(driver) => driver.measured().map_err(|trip| Fault::of_drive(&trip)),
            Drive::Closed(unopened) => Err(unopened.fault.clone()),
            Drive::Plant(drive) => Ok(drive.shown.measured),
        }
    }

    /// The currents of the motors \[A\], if the drives measure them.
    pub fn motor_currents(&self) -> Option<R::Joints> {
        match self {
            Drive::Here(driver) => driver.motor_currents(),
            Drive::Closed(_) => None,
            Drive::Plant(drive) => drive.shown.currents,
        }
    }

    /// What the robot's inputs read, and what its outputs are.
    pub fn signals(&self) -> Signals {
        match self {
            Drive::Here(driver) => driver.signals(),
            Drive::Closed(_) => Signals::OFF,
            Drive::Plant(drive) => drive.shown.signals,
        }
    }

    /// Tells its outputs these values.
    pub fn switch_outputs(&mut self, outputs: &Outputs) {
        match self {
            Drive::Here(driver) => driver.switch_outputs(outputs),
            Drive::Closed(_) => {}
            Drive::Plant(drive) => drive.told.outputs = *outputs,
        }
    }

    /// Tells the drives what the robot carries.
    pub fn carry(&mut self, load: &Load) {
        match self {
            Drive::Here(driver) => driver.carry(load),
            Drive::Closed(_) => {}
            Drive::Plant(drive) => {
                drive.told.load = *load;
                drive.told.loads += 1;
            }
        }
    }

    /// For how long the robot must stand until it reckons with that. Simulated drives in the plant do at once.
    pub fn load_time(&self) -> Duration {
        match self {
            Drive::Here(driver) => driver.load_time(),
            Drive::Closed(_) | Drive::Plant(_) => Duration::ZERO,
        }
    }

    /// The wrench of the surroundings on the flange, `F_F`, if the robot tells it.
    pub fn wrench(&self) -> Option<Wrench> {
        match self {
            Drive::Here(driver) => driver.wrench(),
            Drive::Closed(_) | Drive::Plant(_) => None,
        }
    }

    /// The share of its demands' speed at which the robot goes.
    pub fn speed_scaling(&self) -> f64 {
        match self {
            Drive::Here(driver) => driver.speed_scaling(),
            Drive::Closed(_) | Drive::Plant(_) => 1.0,
        }
    }

    pub fn has_regulator(&self, joint: usize, set: u8) -> bool {
        match self {
            Drive::Here(driver) => driver.has_regulator(joint, set),
            Drive::Closed(_) => set == 0,
            Drive::Plant(drive) => drive.sets.has(joint, set),
        }
    }

    pub fn choose_regulators(&mut self, sets: &Regulators) {
        match self {
            Drive::Here(driver) => driver.choose_regulators(sets),
            Drive::Closed(_) => {}
            Drive::Plant(drive) => drive.chosen = (drive.chosen.0 + 1, *sets),
        }
    }

    pub fn has_brakes(&self) -> bool {
        match self {
            Drive::Here(driver) => driver.has_brakes(),
            Drive::Closed(_) => true,
            Drive::Plant(drive) => drive.brakes,
        }
    }

    /// Takes the power away.
    pub fn switch_off(&mut self, waiter: &dyn Waiter) {
        match self {
            Drive::Here(driver) => driver.switch_off(),
            Drive::Closed(_) => {}
            // A plant that does not hear it takes the power away when no demands come.
            Drive::Plant(drive) => drop(drive.switch(false, waiter)),
        }
    }

    /// Does what the robot needs after a stop of its own; opens drives that could not be opened before.
    ///
    /// # Errors
    /// What the robot refuses.
    pub fn recover(&mut self) -> Result<Recovery, Fault> {
        match self {
            Drive::Here(driver) => driver.recover().map_err(|trip| Fault::of_drive(&trip)),
            Drive::Closed(unopened) => {
                let Some(driver) = unopened.driver.take() else { return Err(unopened.fault.clone()) };
                *self = Drive::open(driver);
                self.unopened().map_or(Ok(Recovery::Over), |fault| Err(fault.clone()))
            }
            Drive::Plant(_) => Ok(Recovery::Over),
        }
    }

    /// Gives power; where the plant runs in its own time, a drive that does not come on is a fault of the next tick.
    ///
    /// # Errors
    /// A fault while a drive cannot come on.
    pub fn switch_on(&mut self, waiter: &dyn Waiter) -> Result<(), Fault> {
        match self {
            Drive::Here(driver) => driver.switch_on().map_err(|trip| Fault::of_drive(&trip)),
            Drive::Closed(unopened) => Err(unopened.fault.clone()),
            Drive::Plant(drive) => drive.switch(true, waiter),
        }
    }

    /// The servo period that begins at `now`, with this tool in force.
    #[allow(non_snake_case)]
    pub(super) fn tick(
        &mut self,
        now: Nanos,
        demanded: &R::Joints,
        X_FE: &Pose,
        waiter: &dyn Waiter,
    ) -> Result<Followed<R::Joints>, Fault> {
        match self {
            Drive::Here(driver) => {
                let period = driver.period();
                let measured = match driver.stepped() {
                    Some(drives) => drives.tick_in(period_at(period, now), demanded),
                    None => driver.tick(demanded),
                };
                let measured = measured.map_err(|trip| Fault::of_drive(&trip))?;
                Ok(Followed { measured, demanded: *demanded })
            }
            Drive::Closed(unopened) => Err(unopened.fault.clone()),
            Drive::Plant(drive) => drive.tick(now, demanded, X_FE, waiter),
        }
    }

    /// The servo period that begins at `now` passes without power. A simulator of others waits for all of its robots.
    pub fn stand_by(&mut self, now: Nanos) {
        if let Drive::Here(driver) = self {
            let number = period_at(driver.period(), now);
            if let Some(drives) = driver.stepped() {
                drives.stand_by(number);
            }
        }
    }
}

/// The number of the servo period that begins at `now`, counted from the cell's start.
fn period_at(period: Duration, now: Nanos) -> u64 {
    now / (period.as_nanos() as Nanos).max(1)
}

/// Simulated drives in the plant.
pub(crate) struct PlantDrive<R: Robot> {
    end: PlantEnd,
    period: Duration,
    sets: RegulatorSets,
    brakes: bool,
    /// The newest reading.
    shown: Reading<R::Joints>,
    /// Whether a reading has come, or has been waited for.
    began: bool,
    /// How many choices of regulators there were, and the last one.
    chosen: (u64, Regulators),
    /// What its outputs were told, and what it carries.
    told: DriveSettings,
    /// How often power was taken away or given.
    switched: u64,
    /// For how long no new reading may come \[ns\].
    timeout: Nanos,
    message: Message,
}

/// The EDP's end of what it tells the plant.
pub(crate) enum PlantEnd {
    /// It asks the process at this place and has its answer before it goes on.
    Asks(Box<dyn Client>, usize),
    /// It shows its command and takes the latest reading.
    Reads(Rc<dyn Board>, Rc<dyn Board>),
}

impl<R: Robot> PlantDrive<R> {
    /// These drives, which are in the plant and have been read.
    pub fn new(driver: &dyn Driver<R>, measured: Measured<R::Joints>, end: PlantEnd, timeout: Nanos) -> Self {
        PlantDrive {
            end,
            period: driver.period(),
            sets: RegulatorSets::of(driver),
            brakes: driver.has_brakes(),
            shown: Reading {
                period: 0,
                measured,
                demanded: measured.position,
                currents: None,
                signals: Signals::OFF,
            },
            began: false,
            chosen: (0, Regulators::default()),
            told: DriveSettings::default(),
            switched: 0,
            timeout,
            message: Message::empty(),
        }
    }

    #[allow(non_snake_case)]
    fn tick(
        &mut self,
        now: Nanos,
        demanded: &R::Joints,
        X_FE: &Pose,
        waiter: &dyn Waiter,
    ) -> Result<Followed<R::Joints>, Fault> {
        let servo = (self.period.as_nanos() as Nanos).max(1);
        let (choice, regulators) = self.chosen;
        let period = period_at(self.period, now);
        let switched = self.switched;
        let (demanded, tool, told) = (*demanded, *X_FE, self.told);
        let command = Command { period, switched, choice, regulators, demanded, tool, told };
        command.put(&mut self.message);
        self.tell(waiter)?;
        if !core::mem::replace(&mut self.began, true) {
            self.shown.period = self.shown.period.max(command.period);
        }
        // In time, the reading is that of the period before.
        if command.period.saturating_sub(self.shown.period + 1) * servo >= self.timeout {
            return Err(lost());
        }
        Ok(Followed { measured: self.shown.measured, demanded: self.shown.demanded })
    }

    /// Power for the drives, or none.
    fn switch(&mut self, on: bool, waiter: &dyn Waiter) -> Result<(), Fault> {
        self.switched += 1;
        Switch { ordinal: self.switched, on }.put(&mut self.message);
        // Until the plant has acted, it shows readings of the time before the switch.
        self.began = false;
        match &self.end {
            PlantEnd::Asks(..) => self.tell(waiter),
            PlantEnd::Reads(commands, _) => {
                commands.write(&self.message);
                Ok(())
            }
        }
    }

    /// Tells the plant what is in the message, and takes its reading.
    fn tell(&mut self, waiter: &dyn Waiter) -> Result<(), Fault> {
        let message = &mut self.message;
        let came = match &self.end {
            PlantEnd::Asks(port, plant) => {
                port.send(message);
                waiter.call(*plant).is_ok() && port.receive(message)
            }
            PlantEnd::Reads(commands, readings) => {
                commands.write(message);
                readings.read(message) && message.header.instruction == self.switched as u32
            }
        };
        if came {
            if message.header.kind == Kind::Fault {
                return Err(message.fault());
            }
            self.shown = Reading::get(message).map_err(|_| Fault::new(FaultKind::Message))?;
        } else if matches!(self.end, PlantEnd::Asks(..)) {
            return Err(lost());
        }
        Ok(())
    }
}

/// The plant says nothing.
fn lost() -> Fault {
    Fault::new(FaultKind::PeerLost).in_process(ProcessId::PLANT)
}
