//! A simulated robot: its drives, regulators and encoders behind the `Driver` trait, whatever its kinematics.

use core::cell::Cell;
use core::time::Duration;
use std::rc::Rc;

use mrroc::fault::Excess;
use mrroc::pose::{Pose, Wrench};
use mrroc::robot::{DriveFault, Driver, Measured, Regulators, SimulatedDrives};
use nalgebra::{SVector, Vector6};

use super::plant::{Coupling, PERIOD, Plant};
use super::regulator::{Regulator, RegulatorSet};
use crate::models::{Driven, Irp6, Kinematics, MotorData, MotorLimits, Overload, Shafts};

/// Share of a period's current in the mean that trips the amplifier: time constant 50 ms (assumed).
const CURRENT_SHARE: f64 = PERIOD / 0.05;

/// Share of a period's increment in the measured speed: time constant 8 ms.
const SPEED_SHARE: f64 = PERIOD / 0.008;

/// A view of the true joint state of a simulated arm, for simulated sensors and for measuring executed paths.
///
/// All copies are views of the same arm.
#[derive(Clone, Debug)]
pub struct Shaft<const N: usize = 6>(Rc<Cell<Measured<SVector<f64, N>>>>);

impl<const N: usize> Shaft<N> {
    /// True joint positions [rad or m] and speeds [rad/s or m/s] at the end of the last servo period.
    #[must_use]
    pub fn state(&self) -> Measured<SVector<f64, N>> {
        self.0.get()
    }
}

/// A robot made of [`Plant`]s, [`Regulator`]s and encoders, run every 2 ms.
///
/// The demanded position of a tick is to be reached at its end; a regulator compares what its encoder reads
/// at the start of the tick with what was demanded for that moment, so constant speed leaves no lag behind.
///
/// A drive trips on a demand that is not finite, outside the motor limits, or faster than they allow
/// ([`Driven::motor_limits`]); and, unless it limits its current ([`Overload`]), on a following error above
/// [`MotorData::following`] and on a mean current (50 ms) above the lasting current. A trip is latched: every later
/// tick brakes and reports the first cause, until [`reset`](Self::reset).
///
/// Every motor's regulator has the parameter sets of [`RegulatorSet`]: 0 usual, 1 soft, 2 springy. Where joints share
/// motors, the set of joint `i` is that of motor `i`.
#[derive(Debug)]
pub struct Simulated<R, const N: usize> {
    robot: R,
    drives: [Drive; N],
    measured: Measured<SVector<f64, N>>,
    shaft: Shaft<N>,
    loads: SVector<f64, N>,
    pushes: SVector<f64, N>,
    fault: Option<DriveFault>,
    coupling: Option<Coupling<N>>,
}

/// The simulated IRp-6.
pub type SimulatedIrp6 = Simulated<Irp6, 6>;

/// One drive with its regulator.
#[derive(Clone, Copy, Debug)]
struct Drive {
    data: MotorData,
    plant: Plant,
    regulator: Regulator,
    pulse: f64,
    /// Count of the shaft's true angle less the count that the encoder shows \[pulses\]: 0 once the angle is known.
    zero: f64,
    count: f64,
    demanded: f64,
    previous: f64,
    increment: f64,
    speed: f64,
    mean_current: f64,
}

impl<const N: usize, R: Driven<N>> Simulated<R, N> {
    /// The robot at rest and in equilibrium at the joint positions `q` [rad or m].
    ///
    /// The positions must keep the joint and motor limits; otherwise the first tick trips.
    #[must_use]
    pub fn new(robot: R, q: &SVector<f64, N>) -> Self {
        let motors = robot.motors(q);
        let loads = robot.shafts(&motors, &SVector::zeros()).loads;
        let data = robot.motor_data();
        let drives =
            core::array::from_fn(|i| Drive::at_rest(&data[i], Plant::at_rest(&data[i], motors[i]), loads[i]));
        let at_rest = Measured { position: *q, velocity: SVector::zeros() };
        let shaft = Shaft(Rc::new(Cell::new(at_rest)));
        let mut simulated = Self {
            robot,
            drives,
            measured: at_rest,
            shaft,
            loads,
            pushes: SVector::zeros(),
            fault: None,
            coupling: None,
        };
        simulated.observe();
        simulated
    }

    /// The same with the links' inertia in every posture, the forces between them, and their rotors', in place of one inertia for
    /// each motor; `None` where the links' masses are not known
    /// ([`Driven::dynamics`]), or leave a motor no inertia for its rotor ([`Driven::rotors`]). What a flange carries is no part of it.
    #[must_use]
    pub fn coupled(robot: R, q: &SVector<f64, N>) -> Option<Self> {
        let coupling = Coupling::of(&robot)?;
        let mut simulated = Self { coupling: Some(coupling), ..Self::new(robot, q) };
        simulated.reset();
        Some(simulated)
    }

    /// The robot whose drives they are.
    #[must_use]
    pub fn robot(&self) -> &R {
        &self.robot
    }

    /// A view of the true joint state, which no encoder measures exactly.
    #[must_use]
    pub fn shaft(&self) -> Shaft<N> {
        self.shaft.0.set(self.true_shafts().joints);
        self.shaft.clone()
    }

    /// The true joint state at the end of the last servo period, as of [`shaft`](Self::shaft).
    #[must_use]
    pub fn state(&self) -> Measured<SVector<f64, N>> {
        if self.is_seen() { self.shaft.state() } else { self.true_shafts().joints }
    }

    /// Whether somebody else looks at the true joints.
    fn is_seen(&self) -> bool {
        Rc::strong_count(&self.shaft.0) > 1
    }

    /// What the true shafts say of the joints.
    fn true_shafts(&self) -> Shafts<N> {
        let drives = &self.drives;
        self.robot.shafts(
            &SVector::from_fn(|i, _| drives[i].plant.angle()),
            &SVector::from_fn(|i, _| drives[i].plant.speed()),
        )
    }

    /// Armature currents of the motors \[A\].
    #[must_use]
    pub fn currents(&self) -> SVector<f64, N> {
        SVector::from_fn(|i, _| self.drives[i].plant.current())
    }

    /// Jams the motor of `joint`, from 0, where it is; q2, q3, q4 of an IRp-6 are driven as absolute angles.
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

    /// Pushes the motor of `joint`, from 0, with a torque [N m] from outside until the next call; positive: against positive
    /// motion.
    pub fn push(&mut self, joint: usize, torque: f64) {
        if joint < N {
            self.pushes[joint] = torque;
        }
    }

    /// Pushes all motors as a wrench on a tool does, until the next call: `F_E` [N, N m] at the origin of E, along the world's axes.
    #[allow(non_snake_case)]
    pub fn push_tool(&mut self, X_FE: &Pose, F_E: &Wrench)
    where
        R: Kinematics<N>,
    {
        if *F_E == Wrench::default() {
            self.pushes = SVector::zeros();
            return;
        }
        let q = self.state().position;
        // From the tool's origin to the flange's, where the Jacobian is taken.
        let lever = self.robot.forward(&q).rotation * X_FE.translation.vector;
        let f = F_E.force;
        let t = F_E.torque + lever.cross(&F_E.force);
        let torques = self.robot.jacobian(&q).tr_mul(&Vector6::new(f.x, f.y, f.z, t.x, t.y, t.z));
        // A drive's load counts against its motion.
        self.pushes = -self.robot.motor_torques(&self.robot.motors(&q), &torques);
    }

    /// Resets the trip and powers the drives where they stand, holding their load.
    pub fn reset(&mut self) {
        self.fault = None;
        if let Some(coupling) = &self.coupling {
            let angles = SVector::from_fn(|i, _| self.drives[i].plant.angle());
            self.loads = coupling.weight(&self.robot, &angles);
        }
        for (i, drive) in self.drives.iter_mut().enumerate() {
            let (set, zero) = (drive.regulator.set(), drive.zero);
            *drive = Drive::at_rest(&drive.data, drive.plant, self.loads[i] + self.pushes[i]);
            drive.regulator.choose(set);
            drive.shift(-zero);
        }
        self.observe();
    }

    /// One servo period without power and with the brakes applied, as when no demand comes any more.
    ///
    /// Call [`reset`](Self::reset) before the next tick.
    pub fn brake(&mut self) -> Measured<SVector<f64, N>> {
        for drive in &mut self.drives {
            drive.brake();
        }
        if let Some(coupling) = &mut self.coupling {
            coupling.follow(&self.robot, &self.drives.each_ref().map(|drive| drive.plant));
        }
        self.observe();
        self.measured
    }

    /// Counts the encoders from 0 where the motors are, as at power-up.
    pub(crate) fn forget(&mut self) {
        for drive in &mut self.drives {
            let count = drive.count;
            drive.shift(-count);
            // The demand at which it holds is counted in the same pulses.
            drive.demanded = 0.0;
            drive.previous = 0.0;
        }
        self.observe();
    }

    /// Makes the encoder of `motor` read `angle` \[rad\] where the true shaft is at `line` \[rad\]; returns by how much more it
    /// reads from now on \[rad\].
    pub(crate) fn learn(&mut self, motor: usize, line: f64, angle: f64) -> f64 {
        let drive = &mut self.drives[motor];
        let encoder = drive.data.encoder;
        let latched = encoder.count(line) - drive.zero;
        let more = encoder.count(angle) - latched;
        drive.shift(more);
        self.observe();
        more * encoder.pulse()
    }

    /// One servo period towards the angles that the encoders are to read \[rad\], which need not be the true ones.
    pub(crate) fn follow(&mut self, angles: &SVector<f64, N>) -> Result<(), DriveFault> {
        self.run(angles);
        self.observe();
        if self.fault.is_some() {
            self.brake();
        }
        self.fault.map_or(Ok(()), Err)
    }

    /// One servo period of all drives towards these motor angles \[rad\].
    fn run(&mut self, angles: &SVector<f64, N>) {
        let Some(coupling) = &mut self.coupling else {
            for (i, drive) in self.drives.iter_mut().enumerate() {
                let pwm = drive.regulate(angles[i]);
                drive.plant.run(pwm, self.loads[i] + self.pushes[i]);
                self.fault = self.fault.or(drive.check(i));
            }
            return;
        };
        let mut pwm = [0.0; N];
        for (i, drive) in self.drives.iter_mut().enumerate() {
            pwm[i] = drive.regulate(angles[i]);
        }
        let mut plants = self.drives.each_ref().map(|drive| drive.plant);
        coupling.run(&self.robot, &mut plants, &pwm, &self.pushes);
        for (i, (drive, plant)) in self.drives.iter_mut().zip(plants).enumerate() {
            drive.plant = plant;
            self.fault = self.fault.or(drive.check(i));
        }
    }

    pub(crate) fn true_angle(&self, motor: usize) -> f64 {
        self.drives[motor].plant.angle()
    }

    pub(crate) fn motor_data(&self, motor: usize) -> &MotorData {
        &self.drives[motor].data
    }

    pub(crate) fn motor_limits(&self) -> &MotorLimits<N> {
        self.robot.motor_limits()
    }

    pub(crate) fn servo_period(&self) -> Duration {
        Duration::from_millis(2)
    }

    /// The first drive that cannot take the motor angles `motors` \[rad\], with the reason.
    fn refusal(&self, motors: &SVector<f64, N>) -> Option<DriveFault> {
        let limits = self.robot.motor_limits();
        for (i, drive) in self.drives.iter().enumerate() {
            let angle = motors[i];
            let speed = (motors[i] - drive.angle_demanded()) / PERIOD;
            let (lower, upper) = (limits.lower[i], limits.upper[i]);
            let fault = |what, actual, limit, unit| {
                Some(DriveFault::exceeded(i, what, Excess::new(actual, limit, unit)))
            };
            if !angle.is_finite() || angle < lower {
                return fault("demanded motor angle", angle, lower, "rad");
            }
            if angle > upper {
                return fault("demanded motor angle", angle, upper, "rad");
            }
            if speed.abs() > limits.speed {
                return fault("demanded motor speed", speed, limits.speed, "rad/s");
            }
        }
        None
    }

    /// Reads the encoders and the true shafts.
    fn observe(&mut self) {
        let drives = &self.drives;
        let measured = self.robot.shafts(
            &SVector::from_fn(|i, _| drives[i].count * drives[i].pulse),
            &SVector::from_fn(|i, _| drives[i].speed),
        );
        self.measured = measured.joints;
        if !self.is_seen() {
            self.loads = self.robot.loads(&SVector::from_fn(|i, _| drives[i].plant.angle()));
            return;
        }
        let shafts = self.true_shafts();
        self.shaft.0.set(shafts.joints);
        self.loads = shafts.loads;
    }
}

impl<const N: usize, R: Driven<N>> Driver<R> for Simulated<R, N> {
    fn period(&self) -> Duration {
        self.servo_period()
    }

    fn measured(&self) -> Result<Measured<SVector<f64, N>>, DriveFault> {
        Ok(self.measured)
    }

    fn tick(&mut self, demanded: &SVector<f64, N>) -> Result<Measured<SVector<f64, N>>, DriveFault> {
        let motors = self.robot.motors(demanded);
        if self.fault.is_none() {
            self.fault = self.refusal(&motors);
        }
        if self.fault.is_some() {
            self.brake();
        } else {
            self.run(&motors);
            self.observe();
        }
        self.fault.map_or(Ok(self.measured), Err)
    }

    fn motor_currents(&self) -> Option<SVector<f64, N>> {
        Some(self.currents())
    }

    /// False where motors limit their current instead of tripping: a gripper has no brake and keeps its grasp.
    fn has_brakes(&self) -> bool {
        self.drives.iter().all(|drive| drive.data.overload != Overload::Limit)
    }

    fn switch_off(&mut self) {
        self.brake();
    }

    /// Motors that a trip left moving are first brought to rest by their brakes.
    fn switch_on(&mut self) -> Result<(), DriveFault> {
        while self.drives.iter().any(|drive| drive.plant.speed() != 0.0) {
            self.brake();
        }
        self.reset();
        Ok(())
    }

    fn has_regulator(&self, joint: usize, set: u8) -> bool {
        joint < N && RegulatorSet::numbered(set).is_some()
    }

    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<R::Joints>> {
        Some(self)
    }

    fn choose_regulators(&mut self, sets: &Regulators) {
        for (i, drive) in self.drives.iter_mut().enumerate() {
            match RegulatorSet::numbered(sets.set(i)) {
                Some(set) if set != drive.regulator.set() => drive.regulator.choose(set),
                Some(_) | None => {}
            }
        }
    }
}

impl<const N: usize, R: Driven<N>> SimulatedDrives<R::Joints> for Simulated<R, N> {
    fn brake(&mut self) -> Measured<SVector<f64, N>> {
        Simulated::brake(self)
    }
}

impl Drive {
    fn at_rest(data: &MotorData, plant: Plant, load: f64) -> Self {
        let pulse = data.encoder.pulse();
        let demanded = plant.angle() / pulse;
        Self {
            data: *data,
            plant,
            regulator: Regulator::holding(data.gains, plant.holding(load)),
            pulse,
            zero: 0.0,
            count: data.encoder.count(plant.angle()),
            demanded,
            previous: demanded,
            increment: 0.0,
            speed: 0.0,
            mean_current: 0.0,
        }
    }

    /// Counts the place where the drive stands by so many pulses more.
    fn shift(&mut self, pulses: f64) {
        self.zero -= pulses;
        self.count += pulses;
        self.demanded += pulses;
        self.previous += pulses;
    }

    /// The motor angle demanded last \[rad\].
    fn angle_demanded(&self) -> f64 {
        self.demanded * self.pulse
    }

    /// The pulse width of a servo period towards `angle` \[rad\].
    fn regulate(&mut self, angle: f64) -> f64 {
        let deviation = (self.demanded - self.previous) - self.increment;
        self.previous = self.demanded;
        self.demanded = angle / self.pulse;
        self.regulator.step(deviation, self.demanded - self.previous)
    }

    /// Reads the encoder at the end of a servo period; tells whether the drive trips.
    fn check(&mut self, index: usize) -> Option<DriveFault> {
        self.read_encoder();
        self.mean_current += CURRENT_SHARE * (self.plant.current().abs() - self.mean_current);
        let following = (self.demanded - self.count) * self.pulse;
        let fault = |what, actual, limit, unit| {
            Some(DriveFault::exceeded(index, what, Excess::new(actual, limit, unit)))
        };
        if self.data.overload == Overload::Limit {
            return None;
        }
        if following.abs() > self.data.following {
            return fault("motor following error", following, self.data.following, "rad");
        }
        if self.mean_current > self.data.current_limit {
            return fault("motor current", self.mean_current, self.data.current_limit, "A");
        }
        None
    }

    /// One servo period without power.
    fn brake(&mut self) {
        self.plant.brake();
        self.read_encoder();
    }

    fn read_encoder(&mut self) {
        let count = self.data.encoder.count(self.plant.angle()) - self.zero;
        self.increment = count - self.count;
        self.count = count;
        self.speed += SPEED_SHARE * (self.increment * self.pulse / PERIOD - self.speed);
    }
}
