//! The simulated IRp-6: its six drives, regulators and encoders behind the `Driver` trait.

use core::cell::Cell;
use core::time::Duration;
use std::rc::Rc;

use mrroc::{DriveFault, Driver, Measured};

use crate::irp6::{Irp6, Six};
use crate::plant::{Encoder, PERIOD, Plant};
use crate::regulator::Regulator;
use crate::transmission::LinkState;

/// Gravity [m/s²].
const GRAVITY: f64 = 9.80665;

/// Largest following error of a motor \[rad\] (assumed); 0.5 deg of a joint at most.
const FOLLOWING_LIMIT: f64 = 1.0;

/// Share of a period's current in the mean that trips the amplifier: time constant 50 ms (assumed).
const CURRENT_SHARE: f64 = PERIOD / 0.05;

/// Share of a period's increment in the measured speed: time constant 8 ms.
const SPEED_SHARE: f64 = PERIOD / 0.008;

/// A look at the true joint state of a simulated arm, for simulated sensors and for measuring executed paths.
///
/// All copies look at the same arm.
#[derive(Clone, Debug)]
pub struct Shaft(Rc<Cell<Measured<Six>>>);

impl Shaft {
    /// True joint positions \[rad\] and speeds [rad/s] at the end of the last servo period.
    #[must_use]
    pub fn state(&self) -> Measured<Six> {
        self.0.get()
    }
}

/// An IRp-6 made of [`Plant`]s, [`Regulator`]s and encoders, run every 2 ms.
///
/// The demanded position of a tick is to be reached at its end; a regulator compares what its encoder reads
/// at the start of the tick with what was demanded for that moment, so constant speed leaves no lag behind.
///
/// A drive trips on a demand that is not finite, outside the motor limits, or faster than
/// [`Irp6::MOTOR_SPEED`]; on a following error above 1 rad of its motor; and on a mean current (50 ms) above
/// what the motor bears. A trip is latched: every later tick brakes and reports the first cause, until
/// [`reset`](Self::reset).
#[derive(Debug)]
pub struct SimulatedIrp6 {
    robot: Irp6,
    drives: [Drive; 6],
    measured: Measured<Six>,
    shaft: Shaft,
    loads: [f64; 2],
    fault: Option<DriveFault>,
}

/// One drive with its regulator.
#[derive(Clone, Copy, Debug)]
struct Drive {
    plant: Plant,
    regulator: Regulator,
    encoder: Encoder,
    pulse: f64,
    count: f64,
    demanded: f64,
    previous: f64,
    increment: f64,
    speed: f64,
    mean_current: f64,
}

impl SimulatedIrp6 {
    /// The arm at rest and in equilibrium at the joint positions `q` \[rad\].
    ///
    /// The positions must be feasible ([`Irp6::is_feasible`]); from others the first tick trips.
    #[must_use]
    pub fn new(robot: Irp6, q: &Six) -> Self {
        let motors = robot.transmission().motors(q);
        let transmission = robot.transmission();
        let loads = loads(&transmission.lower.link(motors[1]), &transmission.upper.link(motors[2]));
        let drives = core::array::from_fn(|i| {
            let plant = Plant::at_rest(&Irp6::MOTORS[i], motors[i]);
            Drive::at_rest(i, plant, load_of(i, &loads))
        });
        let at_rest = Measured { position: *q, velocity: Six::zeros() };
        let shaft = Shaft(Rc::new(Cell::new(at_rest)));
        let mut simulated = Self { robot, drives, measured: at_rest, shaft, loads, fault: None };
        simulated.observe();
        simulated
    }

    /// A look at the true joint state, as no encoder gives it.
    #[must_use]
    pub fn shaft(&self) -> Shaft {
        self.shaft.clone()
    }

    /// Armature currents of the motors \[A\].
    #[must_use]
    pub fn currents(&self) -> Six {
        Six::from_fn(|i, _| self.drives[i].plant.current())
    }

    /// Jams the motor of `joint`, 0 to 5, where it is; q2, q3, q4 of MRROC++ are driven as absolute angles.
    pub fn block(&mut self, joint: usize) {
        if let Some(drive) = self.drives.get_mut(joint) {
            drive.plant.set_jammed(true);
        }
    }

    /// Frees the motor of `joint` again.
    pub fn unblock(&mut self, joint: usize) {
        if let Some(drive) = self.drives.get_mut(joint) {
            drive.plant.set_jammed(false);
        }
    }

    /// Takes back the trip and powers the drives where they stand, holding their load.
    pub fn reset(&mut self) {
        self.fault = None;
        for (i, drive) in self.drives.iter_mut().enumerate() {
            *drive = Drive::at_rest(i, drive.plant, load_of(i, &self.loads));
        }
        self.observe();
    }

    /// One servo period without power and with the brakes applied, as when no demand comes any more.
    ///
    /// Call [`reset`](Self::reset) before the next tick.
    pub fn brake(&mut self) -> Measured<Six> {
        for drive in &mut self.drives {
            drive.brake();
        }
        self.observe();
        self.measured
    }

    /// The first drive that cannot take the motor angles `motors` \[rad\], with the reason.
    fn refusal(&self, motors: &Six) -> Option<DriveFault> {
        for (i, drive) in self.drives.iter().enumerate() {
            let (angle, speed) = (motors[i], (motors[i] - drive.angle_demanded()) / PERIOD);
            let (lower, upper) = (Irp6::MOTOR_LOWER[i], Irp6::MOTOR_UPPER[i]);
            let fault = |what, actual, limit, unit| Some(DriveFault { joint: i, what, actual, limit, unit });
            if !angle.is_finite() || angle < lower {
                return fault("demanded motor angle", angle, lower, "rad");
            }
            if angle > upper {
                return fault("demanded motor angle", angle, upper, "rad");
            }
            if speed.abs() > Irp6::MOTOR_SPEED {
                return fault("demanded motor speed", speed, Irp6::MOTOR_SPEED, "rad/s");
            }
        }
        None
    }

    /// Reads the encoders and the true shafts.
    fn observe(&mut self) {
        let transmission = self.robot.transmission();
        let read = |angles: &Six, speeds: &Six| {
            let (lower, upper) = (transmission.lower.link(angles[1]), transmission.upper.link(angles[2]));
            let state = Measured {
                position: transmission.assemble(angles, &lower, &upper),
                velocity: transmission.joint_rates(speeds, &lower, &upper),
            };
            (state, loads(&lower, &upper))
        };
        let drives = &self.drives;
        let (measured, _) = read(
            &Six::from_fn(|i, _| drives[i].count * drives[i].pulse),
            &Six::from_fn(|i, _| drives[i].speed),
        );
        let (shaft, loads) = read(
            &Six::from_fn(|i, _| drives[i].plant.angle()),
            &Six::from_fn(|i, _| drives[i].plant.speed()),
        );
        self.measured = measured;
        self.shaft.0.set(shaft);
        self.loads = loads;
    }
}

impl Driver<Irp6> for SimulatedIrp6 {
    fn period(&self) -> Duration {
        Duration::from_millis(2)
    }

    fn measured(&self) -> Measured<Six> {
        self.measured
    }

    fn tick(&mut self, demanded: &Six) -> Result<Measured<Six>, DriveFault> {
        let motors = self.robot.transmission().motors(demanded);
        if self.fault.is_none() {
            self.fault = self.refusal(&motors);
        }
        if self.fault.is_some() {
            self.brake();
        } else {
            for (i, drive) in self.drives.iter_mut().enumerate() {
                let tripped = drive.tick(i, motors[i], load_of(i, &self.loads));
                self.fault = self.fault.or(tripped);
            }
            self.observe();
        }
        self.fault.map_or(Ok(self.measured), Err)
    }
}

impl Drive {
    fn at_rest(index: usize, plant: Plant, load: f64) -> Self {
        let data = &Irp6::MOTORS[index];
        let pulse = data.encoder.pulse();
        let demanded = plant.angle() / pulse;
        Self {
            plant,
            regulator: Regulator::holding(data.gains, plant.holding(load)),
            encoder: data.encoder,
            pulse,
            count: data.encoder.count(plant.angle()),
            demanded,
            previous: demanded,
            increment: 0.0,
            speed: 0.0,
            mean_current: 0.0,
        }
    }

    /// The motor angle demanded last \[rad\].
    fn angle_demanded(&self) -> f64 {
        self.demanded * self.pulse
    }

    /// One servo period towards `angle` \[rad\]; tells whether the drive trips at its end.
    fn tick(&mut self, index: usize, angle: f64, load: f64) -> Option<DriveFault> {
        let data = &Irp6::MOTORS[index];
        let deviation = (self.demanded - self.previous) - self.increment;
        self.previous = self.demanded;
        self.demanded = angle / self.pulse;
        let pwm = self.regulator.step(deviation, self.demanded - self.previous);
        self.plant.run(pwm, load);
        self.read_encoder();
        self.mean_current += CURRENT_SHARE * (self.plant.current().abs() - self.mean_current);
        let following = (self.demanded - self.count) * self.pulse;
        let fault = |what, actual, limit, unit| Some(DriveFault { joint: index, what, actual, limit, unit });
        if following.abs() > FOLLOWING_LIMIT {
            return fault("motor following error", following, FOLLOWING_LIMIT, "rad");
        }
        if self.mean_current > data.current_limit {
            return fault("motor current", self.mean_current, data.current_limit, "A");
        }
        None
    }

    /// One servo period without power.
    fn brake(&mut self) {
        self.plant.brake();
        self.read_encoder();
    }

    fn read_encoder(&mut self) {
        let count = self.encoder.count(self.plant.angle());
        self.increment = count - self.count;
        self.count = count;
        self.speed += SPEED_SHARE * (self.increment * self.pulse / PERIOD - self.speed);
    }
}

/// Torques of the links' weight at the motors of the lower and the upper arm [N m]: it turns a link downwards,
/// so a negative load.
fn loads(lower: &LinkState, upper: &LinkState) -> [f64; 2] {
    let [lower_moment, upper_moment] = Irp6::GRAVITY_MOMENT;
    [
        -GRAVITY * lower_moment * lower.cosine / lower.ratio,
        -GRAVITY * upper_moment * upper.cosine / upper.ratio,
    ]
}

/// The load torque of motor `index` [N m].
fn load_of(index: usize, loads: &[f64; 2]) -> f64 {
    match index {
        1 => loads[0],
        2 => loads[1],
        _ => 0.0,
    }
}
