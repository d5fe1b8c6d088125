//! The drives of the base: encoders, regulators and geared motors, on a floor.

use core::time::Duration;

use mrroc::fault::Excess;
use mrroc::robot::{DriveFault, Driver, Limits, Measured, Regulators, Robot as _, SimulatedDrives};
use mrroc_robots::{Encoder, Gains, MotorData, Overload, Regulator, RegulatorSet};

use super::chassis::Chassis;
use super::floor::Floor;
use super::motor::Motor;
use crate::model::{DiffDrive, Two};

/// Servo period \[s\].
const PERIOD: f64 = 0.002;

/// Integration steps in a servo period.
const STEPS: usize = 20;

/// Share of a period's current in the mean that trips the amplifier: time constant 50 ms.
const CURRENT_SHARE: f64 = PERIOD / 0.05;

/// Share of a period's increment in the measured speed: time constant 8 ms.
const SPEED_SHARE: f64 = PERIOD / 0.008;

/// The simulated drives of a [`DiffDrive`] on a [`Floor`].
///
/// Each wheel has a geared motor with an encoder and the same [`Regulator`] that the joints of arms have, every 2 ms. Encoders measure the wheels, not the
/// floor: what tyres slip is not in them. A drive trips on a demand that is not finite or faster than its limit, when it does not
/// follow, and on too much current in the mean of 50 ms; the cause is kept until power is switched on again.
///
/// ```
/// use mrroc::robot::Driver;
/// use mrroc_wheels::simulation::{Floor, Ground};
/// use mrroc_wheels::{DiffDrive, Planar, Rolling};
///
/// let floor = Floor::new(Ground::default(), Planar::default());
/// let mut base = Rolling::new(DiffDrive::new(), floor.clone());
/// // Half a metre along a smooth profile.
/// for k in 1..=1000 {
///     let t = f64::from(k) / 1000.0;
///     base.tick(&DiffDrive::wheels(0.5 * t * t * (3.0 - 2.0 * t), 0.0))?;
/// }
/// assert!((floor.motion().pose.x - 0.5).abs() < 2e-3);
/// # Ok::<(), mrroc::robot::DriveFault>(())
/// ```
#[derive(Debug)]
pub struct Rolling {
    robot: DiffDrive,
    floor: Floor,
    drives: [Drive; 2],
    measured: Measured<Two>,
    fault: Option<DriveFault>,
}

/// A motor with its regulator.
#[derive(Clone, Copy, Debug)]
struct Drive {
    motor: Motor,
    regulator: Regulator,
    count: f64,
    demanded: f64,
    previous: f64,
    increment: f64,
    speed: f64,
    mean_current: f64,
}

impl Rolling {
    /// Turns of a motor for one of its wheel.
    pub const GEAR: f64 = 10.0;

    /// Of the motors, all assumed, as small motors with iron-free rotors have them. `inertia` is what a motor moves when the base
    /// goes straight.
    pub const MOTOR: MotorData = MotorData {
        encoder: Encoder { pulses: 2048.0 },
        gains: Gains { a: 0.429, b0: 0.974, b1: 0.942, feedforward: 0.35 },
        current_limit: 0.6,
        resistance: 3.4,
        torque_constant: 6.6e-3,
        inertia: 5.1e-7,
        viscous: 1e-7,
        coulomb: 2e-4,
        following: 3.0,
        brake: 2e4,
        overload: Overload::Trip,
    };

    /// Inertia of a rotor with its gear and wheel, at the motor [kg m²]: without the body, which moves on its tyres.
    const ROTOR: f64 = 1.26e-7;

    /// The drives of a base that rests on this floor, all angles 0.
    #[must_use]
    pub fn new(robot: DiffDrive, floor: Floor) -> Self {
        let mut rolling = Self {
            robot,
            floor,
            drives: [Drive::at_rest(Motor::at_rest(0.0)); 2],
            measured: Measured { position: Two::zeros(), velocity: Two::zeros() },
            fault: None,
        };
        rolling.observe();
        rolling
    }

    fn observe(&mut self) {
        let pulse = Self::MOTOR.encoder.pulse();
        let of = |value: fn(&Drive) -> f64| Two::from_fn(|i, _| value(&self.drives[i]) / Self::GEAR);
        self.measured =
            Measured { position: of(|drive| drive.count) * pulse, velocity: of(|drive| drive.speed) };
    }

    /// What is wrong with a demand.
    fn refusal(&self, demanded: &Two) -> Option<DriveFault> {
        let Limits { lower, upper, velocity, .. } = *self.robot.limits();
        for (i, drive) in self.drives.iter().enumerate() {
            let fault = |what, actual, limit, unit| {
                Some(DriveFault::exceeded(i, what, Excess::new(actual, limit, unit)))
            };
            let angle = demanded[i];
            let before = drive.demanded * Self::MOTOR.encoder.pulse() / Self::GEAR;
            let speed = (angle - before) / PERIOD;
            if !(lower[i]..=upper[i]).contains(&angle) {
                return fault("demanded wheel angle", angle, upper[i], "rad");
            }
            if speed.abs() > 1.5 * velocity[i] {
                return fault("demanded wheel speed", speed, 1.5 * velocity[i], "rad/s");
            }
        }
        None
    }

    fn run(&mut self, demanded: &Two) {
        let mut pwm = [0.0; 2];
        for (i, drive) in self.drives.iter_mut().enumerate() {
            pwm[i] = drive.regulate(demanded[i] * Self::GEAR);
        }
        let drives = &mut self.drives;
        self.floor.run(STEPS, |pushes| {
            core::array::from_fn(|i| {
                let load = pushes[i] * DiffDrive::WHEEL / Self::GEAR;
                let motor = &mut drives[i].motor;
                motor.step(&Self::MOTOR, Self::ROTOR, pwm[i], load, Chassis::STEP);
                motor.speed / Self::GEAR
            })
        });
        for (i, drive) in self.drives.iter_mut().enumerate() {
            self.fault = self.fault.or(drive.check(i));
        }
    }

    /// One servo period without power and with the brakes on the motors; the body slides on if it is fast.
    fn brake(&mut self) {
        let drives = &mut self.drives;
        self.floor.run(STEPS, |_| {
            core::array::from_fn(|i| {
                drives[i].motor.brake(&Self::MOTOR, Chassis::STEP);
                drives[i].motor.speed / Self::GEAR
            })
        });
        for drive in &mut self.drives {
            drive.read();
        }
    }
}

impl Driver<DiffDrive> for Rolling {
    fn period(&self) -> Duration {
        Duration::from_millis(2)
    }

    fn measured(&self) -> Result<Measured<Two>, DriveFault> {
        Ok(self.measured)
    }

    fn tick(&mut self, demanded: &Two) -> Result<Measured<Two>, DriveFault> {
        if self.fault.is_none() {
            self.fault = self.refusal(demanded);
        }
        if self.fault.is_some() {
            self.brake();
        } else {
            self.run(demanded);
        }
        self.observe();
        self.fault.map_or(Ok(self.measured), Err)
    }

    fn motor_currents(&self) -> Option<Two> {
        Some(Two::from_fn(|i, _| self.drives[i].motor.current))
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        while self.drives.iter().any(|drive| drive.motor.speed != 0.0) {
            self.brake();
        }
        self.fault = None;
        for drive in &mut self.drives {
            let set = drive.regulator.set();
            *drive = Drive::at_rest(drive.motor);
            drive.regulator.choose(set);
        }
        self.observe();
        Ok(())
    }

    fn has_regulator(&self, joint: usize, set: u8) -> bool {
        joint < 2 && RegulatorSet::numbered(set).is_some()
    }

    fn choose_regulators(&mut self, sets: &Regulators) {
        for (i, drive) in self.drives.iter_mut().enumerate() {
            if let Some(set) = RegulatorSet::numbered(sets.set(i))
                && set != drive.regulator.set()
            {
                drive.regulator.choose(set);
            }
        }
    }

    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<Two>> {
        Some(self)
    }
}

impl SimulatedDrives<Two> for Rolling {
    fn brake(&mut self) -> Measured<Two> {
        Rolling::brake(self);
        self.observe();
        self.measured
    }
}

impl Drive {
    fn at_rest(motor: Motor) -> Self {
        let demanded = motor.angle / Rolling::MOTOR.encoder.pulse();
        Self {
            motor,
            regulator: Regulator::holding(Rolling::MOTOR.gains, 0.0),
            count: Rolling::MOTOR.encoder.count(motor.angle),
            demanded,
            previous: demanded,
            increment: 0.0,
            speed: 0.0,
            mean_current: 0.0,
        }
    }

    /// The pulse width of a servo period towards a motor angle \[rad\].
    fn regulate(&mut self, angle: f64) -> f64 {
        let deviation = (self.demanded - self.previous) - self.increment;
        self.previous = self.demanded;
        self.demanded = angle / Rolling::MOTOR.encoder.pulse();
        self.regulator.step(deviation, self.demanded - self.previous)
    }

    fn read(&mut self) {
        let count = Rolling::MOTOR.encoder.count(self.motor.angle);
        self.increment = count - self.count;
        self.count = count;
        self.speed += SPEED_SHARE * (self.increment * Rolling::MOTOR.encoder.pulse() / PERIOD - self.speed);
    }

    /// Reads the encoder at the end of a period; whether the drive trips.
    fn check(&mut self, index: usize) -> Option<DriveFault> {
        self.read();
        self.mean_current += CURRENT_SHARE * (self.motor.current.abs() - self.mean_current);
        let data = &Rolling::MOTOR;
        let following = (self.demanded - self.count) * data.encoder.pulse();
        let fault = |what, actual, limit, unit| {
            Some(DriveFault::exceeded(index, what, Excess::new(actual, limit, unit)))
        };
        if following.abs() > data.following {
            return fault("motor following error", following, data.following, "rad");
        }
        if self.mean_current > data.current_limit {
            return fault("motor current", self.mean_current, data.current_limit, "A");
        }
        None
    }
}
