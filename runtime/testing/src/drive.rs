//! Drives that fail: a blocked or stiff joint, a drive that trips, an encoder with wrong values.
//!
//! In: drives, and how one of them fails from which servo period on. Out: drives that fail like this.

use core::time::Duration;

use mrroc_core::fault::Excess;
use mrroc_core::pose::Wrench;
use mrroc_core::robot::{
    Channels, DriveFault, Driver, JointVector, Load, Measured, Outputs, Pace, Pulse, Recovery, Regulators,
    Robot, Signals, SimulatedDrives, Stepped,
};

/// How a joint's drive fails. Joints are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriveTrouble {
    /// The joint stays where it is.
    Blocked,
    /// In each servo period the joint moves by this share of its distance to the demand, 0 to 1.
    Friction(f64),
    /// The drive trips, and applies its brake.
    Trip,
    /// The encoder gives NaN.
    EncoderNan,
    /// The encoder repeats its last value.
    EncoderStuck,
}

/// Drives of which one joint's fails from some servo period on.
///
/// ```
/// use mrroc::cell::RobotSetup;
/// use mrroc::testing::{DriveTrouble, FaultyDrive};
/// use mrroc_robots::{Irp6, SimulatedIrp6};
///
/// let arm = SimulatedIrp6::new(Irp6::nominal(), &Irp6::READY);
/// // The second joint is blocked from the 300th servo period on.
/// let drives = FaultyDrive::<Irp6, _>::new(arm, DriveTrouble::Blocked, 1, 300);
/// let setup = RobotSetup::new("irp6", Irp6::nominal(), drives);
/// ```
pub struct FaultyDrive<R: Robot, D> {
    drives: D,
    trouble: DriveTrouble,
    joint: usize,
    from: u64,
    ticks: u64,
    /// The last values of the encoders, once there were any, and where the failing joint was sent last [rad or m].
    said: Option<Measured<R::Joints>>,
    at: Option<f64>,
}

impl<R: Robot, D: Driver<R>> FaultyDrive<R, D> {
    /// Lets `joint` of `drives`, counted from 0, fail in servo period `from`, counted from 1, and in all later ones.
    ///
    /// # Panics
    /// If the robot has no such joint.
    pub fn new(drives: D, trouble: DriveTrouble, joint: usize, from: u64) -> Self {
        assert!(joint < R::Joints::LEN, "joint {joint} of {}", R::Joints::LEN);
        FaultyDrive { at: None, drives, trouble, joint, from, ticks: 0, said: None }
    }
}

// What drives do not say here would be the default of the trait, and not what they do.
#[deny(clippy::missing_trait_methods)]
impl<R: Robot, D: Driver<R>> Driver<R> for FaultyDrive<R, D> {
    fn period(&self) -> Duration {
        self.drives.period()
    }

    fn pace(&self) -> Pace {
        self.drives.pace()
    }

    fn pulse(&mut self, now: Duration) -> Result<Option<Pulse>, DriveFault> {
        self.drives.pulse(now)
    }

    fn measured(&self) -> Result<Measured<R::Joints>, DriveFault> {
        self.said.map_or_else(|| self.drives.measured(), Ok)
    }

    fn motor_currents(&self) -> Option<R::Joints> {
        self.drives.motor_currents()
    }

    fn held(&self) -> Option<R::Joints> {
        self.drives.held()
    }

    fn speed_scaling(&self) -> f64 {
        self.drives.speed_scaling()
    }

    fn channels(&self) -> Channels {
        self.drives.channels()
    }

    fn signals(&self) -> Signals {
        self.drives.signals()
    }

    fn switch_outputs(&mut self, outputs: &Outputs) {
        self.drives.switch_outputs(outputs);
    }

    fn declare_outputs(&mut self, named: &Outputs, when_lost: &Outputs) {
        self.drives.declare_outputs(named, when_lost);
    }

    fn carry(&mut self, load: &Load) {
        self.drives.carry(load);
    }

    fn load_time(&self) -> Duration {
        self.drives.load_time()
    }

    fn recover(&mut self) -> Result<Recovery, DriveFault> {
        self.drives.recover()
    }

    fn tick(&mut self, demanded: &R::Joints) -> Result<Measured<R::Joints>, DriveFault> {
        self.ticks += 1;
        let (joint, fails) = (self.joint, self.ticks >= self.from);
        let mut told = *demanded;
        let before = self.measured()?;
        let at = self.at.unwrap_or(before.position[joint]);
        match self.trouble {
            DriveTrouble::Trip if fails => {
                return Err(DriveFault::exceeded(joint, "motor current", Excess::new(30.0, 25.0, "A")));
            }
            DriveTrouble::Blocked if fails => told[joint] = at,
            DriveTrouble::Friction(share) if fails => {
                told[joint] = at + (demanded[joint] - at) * share.clamp(0.0, 1.0);
            }
            DriveTrouble::Trip
            | DriveTrouble::Blocked
            | DriveTrouble::Friction(_)
            | DriveTrouble::EncoderNan
            | DriveTrouble::EncoderStuck => {}
        }
        self.at = Some(told[joint]);
        let mut measured = self.drives.tick(&told)?;
        match self.trouble {
            DriveTrouble::EncoderNan if fails => measured.position[joint] = f64::NAN,
            DriveTrouble::EncoderStuck if fails => {
                measured.position[joint] = before.position[joint];
                measured.velocity[joint] = 0.0;
            }
            DriveTrouble::Trip
            | DriveTrouble::Blocked
            | DriveTrouble::Friction(_)
            | DriveTrouble::EncoderNan
            | DriveTrouble::EncoderStuck => {}
        }
        self.said = Some(measured);
        Ok(measured)
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        self.drives.open()
    }

    fn close(&mut self) {
        self.drives.close();
    }

    fn hardware(&self) -> Option<String> {
        self.drives.hardware()
    }

    fn has_brakes(&self) -> bool {
        self.drives.has_brakes()
    }

    fn switch_off(&mut self) {
        self.drives.switch_off();
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.drives.switch_on()
    }

    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<R::Joints>> {
        if self.drives.simulation().is_some() { Some(self) } else { None }
    }

    fn has_regulator(&self, joint: usize, set: u8) -> bool {
        self.drives.has_regulator(joint, set)
    }

    fn choose_regulators(&mut self, sets: &Regulators) {
        self.drives.choose_regulators(sets);
    }

    fn wrench(&self) -> Option<Wrench> {
        self.drives.wrench()
    }

    fn calibration(&mut self) -> Result<Option<String>, DriveFault> {
        self.drives.calibration()
    }

    fn python(&self) -> Option<String> {
        self.drives.python()
    }

    // Drives in a simulator of others count their periods themselves, where nobody does it for them.
    fn stepped(&mut self) -> Option<&mut dyn Stepped<R::Joints>> {
        None
    }
}

impl<R: Robot, D: Driver<R>> SimulatedDrives<R::Joints> for FaultyDrive<R, D> {
    fn brake(&mut self) -> Measured<R::Joints> {
        let simulation = self.drives.simulation().expect("simulated drives alone offer this");
        *self.said.insert(simulation.brake())
    }
}
