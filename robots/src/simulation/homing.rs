//! Homing of simulated incremental drives: from power-up, when no drive knows its motor's angle, until all do.
//!
//! Every motor has a synchronisation switch, which tells on which side of it the shaft is, and an encoder with one index
//! line a turn. The motor angle of the first index line above the switch is known ([`Driven::marks`]); the switch is half a
//! turn below it, so that a switch which is off by less than that does no harm. One motor after the other is homed, while
//! the others hold:
//!
//! ```text
//! below the switch:  up at search speed until it is passed
//! above it:          down at search speed until it is passed
//! then:              up at creep speed, past the switch, to the next index line; there the encoder learns its angle
//! at last:           to rest
//! ```
//!
//! Speeds are MRROC++'s: 0.03 and 0.007 rad per 2 ms, for motors whose limit is 0.5 rad per 2 ms; the acceleration takes a
//! quarter of the lasting torque (assumed). Only the switch and the index line depend on the true shaft.

use core::time::Duration;

use mrroc::fault::Excess;
use mrroc::robot::{DriveFault, Homing, Search};
use nalgebra::SVector;

use core::f64::consts::{PI, TAU};

use super::plant::PERIOD;
use super::simulated::{Shaft, Simulated};
use crate::models::Driven;

/// Search speed, as a part of the motor's speed limit.
const SEARCH: f64 = 0.06;
/// Creep speed, likewise.
const CREEP: f64 = 0.014;
/// Part of the lasting torque that is used to accelerate.
const TORQUE: f64 = 0.25;
/// How far above the switch the index line must come \[rad\]: half a turn, and a turn of play.
const TO_INDEX: f64 = 1.5 * TAU;
/// For how long a motor must have stood before it is done [servo periods].
const REST: u32 = 50;

/// Simulated drives that do not know where the robot is. They take no demands:
///
/// ```compile_fail,E0599
/// use mrroc::robot::Driver;
/// use mrroc_robots::{Irp6, Unhomed};
/// let q = Irp6::READY;
/// let mut drives = Unhomed::new(Irp6::nominal(), &q);
/// drives.tick(&q);
/// ```
///
/// They search, and become [`Simulated`] drives when they have found their marks:
///
/// ```
/// use mrroc::robot::{Driver, Homing, Search};
/// use mrroc_robots::{Irp6, Unhomed};
/// let q = Irp6::READY;
/// let mut search = Unhomed::new(Irp6::nominal(), &q);
/// let mut drives = loop {
///     match search.search()? {
///         Search::Searching(on) => search = on,
///         Search::Found(drives) => break drives,
///     }
/// };
/// let here = drives.measured()?.position;
/// drives.tick(&here)?;
/// # Ok::<(), mrroc::robot::DriveFault>(())
/// ```
#[derive(Debug)]
pub struct Unhomed<R, const N: usize> {
    drives: Simulated<R, N>,
    marks: SVector<f64, N>,
    /// Motors whose switches never close.
    cut: [bool; N],
    /// Demanded angle of each drive, as its encoder counts \[rad\].
    demanded: SVector<f64, N>,
    /// The motor that searches, and how far it has come.
    motor: usize,
    stage: Stage,
    /// Its demanded speed [rad/s], and how far it has turned in this stage \[rad\].
    speed: f64,
    travelled: f64,
}

/// What the searching motor does.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    /// Goes up until the switch tells that it is above.
    Up,
    /// Goes down until the switch tells that it is below.
    Down,
    /// Creeps up: first past the switch.
    ToSwitch,
    /// Creeps up to the index line.
    ToIndex,
    /// Knows its angle and comes to rest; it has stood for so many periods.
    Resting(u32),
}

impl<const N: usize, R: Driven<N>> Unhomed<R, N> {
    /// The robot at power-up, at rest and in equilibrium at the joint positions `hidden` [rad or m], which its drives do not
    /// know.
    #[must_use]
    pub fn new(robot: R, hidden: &SVector<f64, N>) -> Self {
        Self::with(Simulated::new(robot, hidden))
    }

    /// The same with motors that their links couple ([`Simulated::coupled`]); `None` where the links' masses are not known.
    #[must_use]
    pub fn coupled(robot: R, hidden: &SVector<f64, N>) -> Option<Self> {
        Simulated::coupled(robot, hidden).map(Self::with)
    }

    fn with(mut drives: Simulated<R, N>) -> Self {
        let marks = drives.robot().marks();
        drives.forget();
        Self {
            drives,
            marks,
            cut: [false; N],
            demanded: SVector::zeros(),
            motor: 0,
            stage: Stage::Up,
            speed: 0.0,
            travelled: 0.0,
        }
    }

    /// A view of the true joint state, which no encoder measures exactly.
    #[must_use]
    pub fn shaft(&self) -> Shaft<N> {
        self.drives.shaft()
    }

    /// Jams the motor of `joint`, from 0, where it is.
    pub fn block(&mut self, joint: usize) {
        self.drives.block(joint);
    }

    /// Cuts the wire of the switch of `joint`, from 0: from then on it always tells that the motor is below.
    pub fn cut_switch(&mut self, joint: usize) {
        if let Some(cut) = self.cut.get_mut(joint) {
            *cut = true;
        }
    }

    /// Whether the switch of the searching motor tells that it is above.
    fn is_above(&self) -> bool {
        let switch = self.marks[self.motor] - PI;
        !self.cut[self.motor] && self.drives.true_angle(self.motor) >= switch
    }

    /// The stage that follows. Where the index line was passed upwards from the true angle `before`, the encoder
    /// learns its angle.
    fn after(&mut self, before: f64) -> Stage {
        let above = self.is_above();
        match self.stage {
            Stage::Up if above => Stage::Down,
            Stage::Down if !above => Stage::ToSwitch,
            Stage::ToSwitch if above => Stage::ToIndex,
            Stage::ToIndex => {
                // Index lines are a turn apart; the one that comes now is the mark, if the switch is where it should be.
                let turns = |angle: f64| ((angle - self.marks[self.motor]) / TAU).floor();
                let now = self.drives.true_angle(self.motor);
                if turns(now) <= turns(before) {
                    return Stage::ToIndex;
                }
                let line = self.marks[self.motor] + TAU * turns(now);
                self.demanded[self.motor] += self.drives.learn(self.motor, line, self.marks[self.motor]);
                Stage::Resting(0)
            }
            Stage::Resting(stood) if self.speed == 0.0 => Stage::Resting(stood + 1),
            stage => stage,
        }
    }

    /// The fault of a motor that has gone farther than what it looks for can be away.
    fn lost(&self) -> Option<DriveFault> {
        let limits = self.drives.motor_limits();
        let range = limits.upper[self.motor] - limits.lower[self.motor];
        let (what, limit) = match self.stage {
            Stage::Up | Stage::Down | Stage::ToSwitch => ("distance to the synchronisation switch", range),
            Stage::ToIndex => ("distance to the encoder's index line", TO_INDEX),
            Stage::Resting(_) => return None,
        };
        let fault = DriveFault::exceeded(self.motor, what, Excess::new(self.travelled, limit, "rad"));
        (self.travelled > limit).then_some(fault)
    }
}

impl<const N: usize, R: Driven<N>> Homing<R> for Unhomed<R, N> {
    type Drives = Simulated<R, N>;

    fn period(&self) -> Duration {
        self.drives.servo_period()
    }

    fn search(mut self) -> Result<Search<Self, Self::Drives>, DriveFault> {
        if self.motor == N {
            return Ok(Search::Found(self.drives));
        }
        let data = self.drives.motor_data(self.motor);
        let step = TORQUE * data.torque_constant * data.current_limit / data.inertia * PERIOD;
        let fastest = self.drives.motor_limits().speed;
        let wanted = match self.stage {
            Stage::Up => SEARCH * fastest,
            Stage::Down => -SEARCH * fastest,
            Stage::ToSwitch | Stage::ToIndex => CREEP * fastest,
            Stage::Resting(_) => 0.0,
        };
        self.speed += (wanted - self.speed).clamp(-step, step);
        self.travelled += self.speed.abs() * PERIOD;
        self.demanded[self.motor] += self.speed * PERIOD;
        let before = self.drives.true_angle(self.motor);
        self.drives.follow(&self.demanded)?;
        if let Some(fault) = self.lost() {
            self.drives.brake();
            return Err(fault);
        }
        let stage = self.after(before);
        if core::mem::discriminant(&stage) != core::mem::discriminant(&self.stage) {
            self.travelled = 0.0;
        }
        self.stage = stage;
        if self.stage == Stage::Resting(REST) {
            self.motor += 1;
            self.stage = Stage::Up;
            self.travelled = 0.0;
        }
        Ok(Search::Searching(self))
    }
}
