//! What a robot says of its drives: their data, how they turn with the joints, what they bear.
//!
//! In: joint positions. Out: motor angles, and back, with the torques that the links' weight puts on the motors. A
//! robot that implements [`Driven`] can be simulated ([`Simulated`](crate::Simulated)) without more.

use core::f64::consts::{PI, TAU};

use mrroc::{CoupledLimit, Measured, Robot};
use nalgebra::SVector;

/// Gravity [m/s²].
pub(crate) const GRAVITY: f64 = 9.80665;

/// An incremental encoder on a motor shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoder {
    /// Pulses per turn, > 0.
    pub pulses: f64,
}

impl Encoder {
    /// The whole number of pulses nearest to a shaft angle \[rad\].
    #[must_use]
    pub fn count(&self, angle: f64) -> f64 {
        (angle * (self.pulses / TAU)).round()
    }

    /// The shaft angle of one pulse \[rad\].
    #[must_use]
    pub fn pulse(&self) -> f64 {
        2.0 * PI / self.pulses
    }
}

/// Gains of one regulator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// Pole of the lag, 0 to 1.
    pub a: f64,
    /// Gain of the newest error [pwm/pulse].
    pub b0: f64,
    /// Gain of the error before [pwm/pulse].
    pub b1: f64,
    /// Feed-forward of the demanded increment `k_ff` [pwm per pulse and period].
    pub feedforward: f64,
}

/// One drive: what the simulated plant needs to know of a motor and its load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorData {
    /// Encoder on the motor shaft (MRROC++).
    pub encoder: Encoder,
    /// Gains of its regulator (MRROC++).
    pub gains: Gains,
    /// Largest lasting current \[A\], > 0 (MRROC++ for the robots that it knows).
    pub current_limit: f64,
    /// Armature resistance \[ohm\], > 0 (assumed).
    pub resistance: f64,
    /// Torque constant [N m/A] and back-EMF constant [V s], > 0 (assumed).
    pub torque_constant: f64,
    /// Inertia of rotor and load, seen at the motor [kg m²], > 0 (assumed).
    pub inertia: f64,
    /// Viscous friction at the motor [N m s], >= 0 (assumed).
    pub viscous: f64,
    /// Coulomb friction at the motor [N m], >= 0 (assumed).
    pub coulomb: f64,
    /// Largest following error of the motor \[rad\], > 0 (assumed): about 0.5 deg of its joint.
    pub following: f64,
    /// Deceleration by the brake [rad/s²], > 0 (assumed).
    pub brake: f64,
    /// What happens when the motor would need more current than it bears.
    pub overload: Overload,
}

impl MotorData {
    /// A disc motor on a geared axis: what the axes of the IRp-6 differ in is to be filled in.
    pub(crate) const DISC: Self = Self {
        encoder: Encoder { pulses: 4000.0 },
        gains: Gains { a: 0.429, b0: 6.834, b1: 6.606, feedforward: 0.35 },
        current_limit: 10.0,
        resistance: 3.66,
        torque_constant: 0.20,
        inertia: 2.5e-3,
        viscous: 1e-3,
        coulomb: 0.08,
        following: 1.0,
        brake: 1500.0,
        overload: Overload::Trip,
    };
}

/// What a drive does when it is asked for more than its lasting current.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overload {
    /// Gives twice that for a moment and trips when the mean (50 ms) exceeds it, or the motor does not follow.
    Trip,
    /// Gives that and no more, for as long as asked, and lets the motor stand off its demand: a gripper's grasp.
    Limit,
}

/// What the motors of a robot bear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorLimits<const N: usize> {
    /// Lowest motor angles \[rad\].
    pub lower: [f64; N],
    /// Highest motor angles \[rad\], above `lower`.
    pub upper: [f64; N],
    /// Largest speed of every motor [rad/s], > 0.
    pub speed: f64,
}

/// A robot's joints as its motor shafts determine them, and what the motors carry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shafts<const N: usize> {
    /// Joint positions [rad or m] and speeds [rad/s or m/s].
    pub joints: Measured<SVector<f64, N>>,
    /// Torques of the links' weight at the motors [N m], positive: against positive motion.
    pub loads: SVector<f64, N>,
}

/// A robot whose `N` joints are moved by `N` motors.
pub trait Driven<const N: usize>: Robot<Joints = SVector<f64, N>> {
    /// The data of the motors, in order.
    fn motor_data(&self) -> &[MotorData; N];

    /// What the motors bear.
    fn motor_limits(&self) -> &MotorLimits<N>;

    /// Motor angles of the index lines at which the motors are synchronised \[rad\]: of the first line above each motor's
    /// switch. In the middle of the joint limits unless the robot says otherwise (assumed).
    fn marks(&self) -> SVector<f64, N> {
        let limits = self.limits();
        self.motors(&((limits.lower + limits.upper) * 0.5))
    }

    /// Motor angles \[rad\] of the joint positions `q` [rad or m].
    fn motors(&self, q: &SVector<f64, N>) -> SVector<f64, N>;

    /// The joints and the loads at motor angles \[rad\] and motor speeds [rad/s].
    fn shafts(&self, angles: &SVector<f64, N>, speeds: &SVector<f64, N>) -> Shafts<N>;

    /// Torques at the motors [N m] that do the same work as `torques` do at the joints [N m, or N on a prismatic joint]:
    /// `(dq/dm)^T torques`, with the columns of dq/dm as the joint speeds of one motor that turns alone.
    fn motor_torques(&self, angles: &SVector<f64, N>, torques: &SVector<f64, N>) -> SVector<f64, N> {
        SVector::from_fn(|i, _| {
            let alone = SVector::from_fn(|j, _| if i == j { 1.0 } else { 0.0 });
            self.shafts(angles, &alone).joints.velocity.dot(torques)
        })
    }
}

/// Whether the motors may go from joint positions `from` to `to` in `duration` \[s\].
pub(crate) fn check_motors<const N: usize>(
    robot: &impl Driven<N>,
    from: &SVector<f64, N>,
    to: &SVector<f64, N>,
    duration: f64,
) -> Result<(), CoupledLimit> {
    let before = robot.motors(from);
    let after = robot.motors(to);
    let limits = robot.motor_limits();
    for i in 0..N {
        let (lower, upper) = (limits.lower[i], limits.upper[i]);
        let limit = if after[i] < lower { lower } else { upper };
        if !(lower..=upper).contains(&after[i]) {
            let what = "angle of the motor";
            return Err(CoupledLimit { joint: i, what, actual: after[i], limit, unit: "rad" });
        }
        let speed = (after[i] - before[i]).abs() / duration;
        if speed > limits.speed {
            let what = "speed of the motor";
            let limit = limits.speed;
            return Err(CoupledLimit { joint: i, what, actual: speed, limit, unit: "rad/s" });
        }
    }
    Ok(())
}
