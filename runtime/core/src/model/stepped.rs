//! Drives in a simulator that others wrote: a program of its own, which simulates one step at a time, when the robots in it have
//! been told where to be.
//!
//! In: the position for the end of each servo period, with the number of the period. Out: what the simulated encoders read, and the
//! wrench at the flange. [`Simulator`] is the link to the program, for a robot of any kind; [`SteppedDrives`] are the drives that a
//! cell knows.

use core::time::Duration;

use crate::model::drive_fault::DriveFault;
use crate::model::driver::{Driver, Measured, Recovery, Stepped};
use crate::model::joints::{JointVector, MAX_JOINTS};
use crate::model::robot::Robot;
use crate::model::time::Clock;
use crate::model::wrench::Wrench;

/// A robot in a simulator of others. Joint vectors have as many entries as the robot has joints.
pub trait Simulator {
    /// What it is, for messages and for the whole machine, as [`Driver::hardware`].
    fn hardware(&self) -> String;

    /// A Python module with which such a simulator is written: `external NAME` on the command line prints it. `None`, the
    /// default: there is none.
    fn python(&self) -> Option<String> {
        None
    }

    /// Connects to the simulator, and lets the robot stand where it is to begin. It may take seconds.
    ///
    /// # Errors
    /// There is no simulator, it is another one's, or it speaks otherwise.
    fn open(&mut self, begin: &Begin<'_>) -> Result<Simulated, DriveFault>;

    /// The same for a simulator that was lost, which may be another one by now. It returns at once; `None`: it has not answered
    /// yet.
    ///
    /// # Errors
    /// As for [`open`](Simulator::open).
    fn open_again(&mut self, begin: &Begin<'_>) -> Result<Option<Simulated>, DriveFault>;

    /// Tells it where the robot is to be at the end of this servo period \[rad or m\]; `None`: it has no power, and its brakes are
    /// applied. Returns what is known at the beginning of the period: the state at the end of the one before. Under the virtual
    /// clock that is waited for; in real time it is there, or an older one is returned.
    ///
    /// # Errors
    /// The simulator says nothing any more, or what cannot be. Nothing is told to it then until it is opened again.
    fn step(&mut self, period: u64, demanded: Option<&[f64]>) -> Result<Simulated, DriveFault>;

    /// Tells it that nothing more comes.
    fn close(&mut self);
}

/// How a robot begins in a simulator.
#[derive(Clone, Copy, Debug)]
pub struct Begin<'a> {
    /// By which clock the cell runs.
    pub clock: Clock,
    /// The servo period.
    pub period: Duration,
    /// Where it stands \[rad or m\].
    pub start: &'a [f64],
    /// The first servo period that will be told, counted from the cell's start; at the start of a cell 0, or later.
    pub first: u64,
}

/// A robot's state in a simulator. Entries beyond the robot's joints say nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Simulated {
    /// Joint positions \[rad or m\].
    pub position: [f64; MAX_JOINTS],
    /// Joint velocities \[rad/s or m/s\].
    pub velocity: [f64; MAX_JOINTS],
    /// The wrench of the surroundings on the flange, `F_F`, if the simulator tells it.
    pub wrench: Option<Wrench>,
}

/// The drives of a robot in a simulator of others. They name [hardware](Driver::hardware), and follow the virtual clock all the
/// same.
pub struct SteppedDrives<R: Robot> {
    simulator: Box<dyn Simulator>,
    period: Duration,
    has_brakes: bool,
    clock: Clock,
    measured: Measured<R::Joints>,
    wrench: Option<Wrench>,
    is_open: bool,
    /// Why nothing is told to the simulator any more.
    lost: Option<DriveFault>,
    /// The period that comes next.
    next: u64,
}

impl<R: Robot> SteppedDrives<R> {
    /// Of a robot that begins at `start` \[rad or m\].
    pub(crate) fn new(
        simulator: Box<dyn Simulator>,
        start: R::Joints,
        period: Duration,
        has_brakes: bool,
    ) -> Self {
        SteppedDrives {
            simulator,
            period,
            has_brakes,
            clock: Clock::Virtual,
            measured: Measured { position: start, velocity: R::Joints::zeros() },
            wrench: None,
            is_open: false,
            lost: None,
            next: 0,
        }
    }

    fn step(&mut self, period: u64, demanded: Option<&R::Joints>) -> Result<(), DriveFault> {
        self.next = period + 1;
        if let Some(fault) = self.lost {
            return Err(fault);
        }
        let stepped = self.simulator.step(period, demanded.map(JointVector::as_slice));
        self.lost = stepped.err();
        self.know(&stepped?);
        Ok(())
    }

    fn know(&mut self, state: &Simulated) {
        self.measured = Measured {
            position: R::Joints::from_joints(|i| state.position[i]),
            velocity: R::Joints::from_joints(|i| state.velocity[i]),
        };
        self.wrench = state.wrench;
    }

    /// Where the robot is to stand in a simulator that may be a new one: where it was last.
    fn begin<'a>(&self, start: &'a R::Joints) -> Begin<'a> {
        Begin { clock: self.clock, period: self.period, start: start.as_slice(), first: self.next }
    }
}

impl<R: Robot> Driver<R> for SteppedDrives<R> {
    fn period(&self) -> Duration {
        self.period
    }

    fn hardware(&self) -> Option<String> {
        Some(self.simulator.hardware())
    }

    fn python(&self) -> Option<String> {
        self.simulator.python()
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        let start = self.measured.position;
        let state = self.simulator.open(&self.begin(&start))?;
        self.know(&state);
        (self.is_open, self.lost) = (true, None);
        Ok(())
    }

    fn close(&mut self) {
        self.is_open = false;
        self.simulator.close();
    }

    fn measured(&self) -> Result<Measured<R::Joints>, DriveFault> {
        if self.is_open { Ok(self.measured) } else { Err(DriveFault::NoAnswer) }
    }

    fn tick(&mut self, demanded: &R::Joints) -> Result<Measured<R::Joints>, DriveFault> {
        self.tick_in(self.next, demanded)
    }

    fn wrench(&self) -> Option<Wrench> {
        self.wrench
    }

    fn has_brakes(&self) -> bool {
        self.has_brakes
    }

    fn recover(&mut self) -> Result<Recovery, DriveFault> {
        if self.lost.is_none() {
            return Ok(Recovery::Over);
        }
        let start = self.measured.position;
        let begin = self.begin(&start);
        let opened = match self.clock {
            // No time passes meanwhile, so that the period which comes next stays that.
            Clock::Virtual => self.simulator.open(&begin).map(Some),
            Clock::Real => self.simulator.open_again(&begin),
        };
        let Some(state) = opened? else { return Ok(Recovery::GoesOn) };
        self.know(&state);
        self.lost = None;
        Ok(Recovery::Over)
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.lost.map_or(Ok(()), Err)
    }

    fn stepped(&mut self) -> Option<&mut dyn Stepped<R::Joints>> {
        Some(self)
    }
}

impl<R: Robot> Stepped<R::Joints> for SteppedDrives<R> {
    fn run_by(&mut self, clock: Clock) {
        self.clock = clock;
    }

    fn tick_in(&mut self, period: u64, demanded: &R::Joints) -> Result<Measured<R::Joints>, DriveFault> {
        self.step(period, Some(demanded))?;
        Ok(self.measured)
    }

    fn stand_by(&mut self, period: u64) {
        self.next = period + 1;
        if self.is_open && self.lost.is_none() {
            let _ = self.step(period, None);
        }
    }
}
