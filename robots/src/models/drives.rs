//! The drives of a robot as data: its motors, their limits, and how they turn with the joints.
//!
//! In: joint positions. Out: motor angles, and back, with the torques that the links' weight puts on the motors.
//! [`Simulated`](crate::Simulated) simulates every robot that implements [`Driven`].

use core::f64::consts::{PI, TAU};

use mrroc::fault::Excess;
use mrroc::robot::{CoupledLimit, Measured, Robot};
use nalgebra::{SMatrix, SVector};

use crate::dynamics::{Dynamics, Tree};

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

/// Gains of the regulator of one motor; [`Regulator`](crate::Regulator) has the law.
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

/// A motor with its encoder, its regulator's gains and its load.
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
    /// What happens when the motor would need more than its lasting current.
    pub overload: Overload,
}

impl MotorData {
    /// A disc motor on a geared axis. Each axis of the IRp-6 overrides the figures in which it differs.
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

/// What a drive does when its demand takes more than its lasting current.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overload {
    /// Gives up to twice the lasting current, and trips when the mean over 50 ms exceeds it or the motor does not follow.
    Trip,
    /// Gives the lasting current and no more, for any time, even if the motor then does not reach its demand: a gripper
    /// that presses on an object.
    Limit,
}

/// Limits of a robot's motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorLimits<const N: usize> {
    /// Lowest motor angles \[rad\].
    pub lower: [f64; N],
    /// Highest motor angles \[rad\], above `lower`.
    pub upper: [f64; N],
    /// Largest speed of every motor [rad/s], > 0.
    pub speed: f64,
}

/// A robot's joints as its motor shafts determine them, and the load on each motor.
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

    /// Limits of the motors.
    fn motor_limits(&self) -> &MotorLimits<N>;

    /// Motor angles at which the motors are synchronised \[rad\]: for each motor that of the first index line above its
    /// switch. By default those of the middle of the joint limits (assumed).
    fn marks(&self) -> SVector<f64, N> {
        let limits = self.limits();
        self.motors(&((limits.lower + limits.upper) * 0.5))
    }

    /// Motor angles \[rad\] of the joint positions `q` [rad or m].
    fn motors(&self, q: &SVector<f64, N>) -> SVector<f64, N>;

    /// The joints and the loads at motor angles \[rad\] and motor speeds [rad/s].
    fn shafts(&self, angles: &SVector<f64, N>, speeds: &SVector<f64, N>) -> Shafts<N>;

    /// The loads of [`shafts`](Driven::shafts) alone, for robots that have them for less.
    fn loads(&self, angles: &SVector<f64, N>) -> SVector<f64, N> {
        self.shafts(angles, &SVector::zeros()).loads
    }

    /// The links with their masses, as an open tree whose coordinates are the joints; `None` (by default) where they are no such
    /// tree, or nothing is known of them.
    fn tree(&self) -> Option<Tree<N>> {
        None
    }

    /// What the links do to the joints: by default their [`tree`](Driven::tree), if it has a mass.
    fn dynamics(&self) -> Option<Box<dyn Dynamics<N>>> {
        let tree = self.tree().filter(|tree| tree.mass() > 0.0)?;
        Some(Box::new(tree))
    }

    /// Joint positions at motor angles \[rad\] [rad or m].
    fn positions(&self, angles: &SVector<f64, N>) -> SVector<f64, N> {
        self.shafts(angles, &SVector::zeros()).joints.position
    }

    /// dq/dm at motor angles \[rad\], the joint speeds of one motor that turns alone in each column [rad/rad or m/rad].
    fn ratios(&self, angles: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        let mut ratios = SMatrix::<f64, N, N>::zeros();
        for i in 0..N {
            let alone = SVector::from_fn(|j, _| if i == j { 1.0 } else { 0.0 });
            ratios.set_column(i, &self.shafts(angles, &alone).joints.velocity);
        }
        ratios
    }

    /// Inertias of the rotors [kg m²], apart from their links: by default what the links, at the [marks](Driven::marks), leave of
    /// [`MotorData::inertia`], so that there a motor has the same inertia with its links as without.
    fn rotors(&self) -> SVector<f64, N> {
        let marks = self.marks();
        let data = self.motor_data();
        let ratios = self.ratios(&marks);
        let q = self.shafts(&marks, &SVector::zeros()).joints.position;
        let links = self.dynamics().map(|links| links.equation(&q, &SVector::zeros()).mass);
        let seen = links.map_or_else(SMatrix::zeros, |mass| ratios.transpose() * mass * ratios);
        SVector::from_fn(|i, _| data[i].inertia - seen[(i, i)])
    }

    /// Torques at the motors [N m] that do the same work as `torques` do at the joints [N m, or N on a prismatic joint]:
    /// `(dq/dm)^T torques`.
    fn motor_torques(&self, angles: &SVector<f64, N>, torques: &SVector<f64, N>) -> SVector<f64, N> {
        let ratios = self.ratios(angles);
        SVector::from_fn(|i, _| ratios.column(i).dot(torques))
    }
}

/// Whether the motors may go from joint positions `from` to `to` in `duration` \[s\].
pub(crate) fn check_motors<const N: usize>(
    robot: &impl Driven<N>,
    from: &SVector<f64, N>,
    to: &SVector<f64, N>,
    duration: f64,
) -> Result<(), CoupledLimit> {
    check_motors_on_moves(robot, from, [(to, duration)])
}

/// The same on one move after another, in the time of each \[s\].
pub(crate) fn check_motors_on_moves<const N: usize, const MOVES: usize>(
    robot: &impl Driven<N>,
    from: &SVector<f64, N>,
    moves: [(&SVector<f64, N>, f64); MOVES],
) -> Result<(), CoupledLimit> {
    let mut before = robot.motors(from);
    for (to, duration) in moves {
        let after = robot.motors(to);
        check_turn(robot.motor_limits(), &before, &after, duration)?;
        before = after;
    }
    Ok(())
}

/// The limits that these checks keep, in words.
pub(crate) fn motor_limits_in_words<const N: usize>(robot: &impl Driven<N>) -> Vec<String> {
    let MotorLimits { lower, upper, speed } = robot.motor_limits();
    let range = |i: usize| {
        format!("motor {}: {:.1} to {:.1} rad, at most {speed:.1} rad/s", i + 1, lower[i], upper[i])
    };
    (0..N).map(range).collect()
}

/// Whether the motors may turn so far in `duration` \[s\].
fn check_turn<const N: usize>(
    limits: &MotorLimits<N>,
    before: &SVector<f64, N>,
    after: &SVector<f64, N>,
    duration: f64,
) -> Result<(), CoupledLimit> {
    for i in 0..N {
        let (lower, upper) = (limits.lower[i], limits.upper[i]);
        let limit = if after[i] < lower { lower } else { upper };
        if !(lower..=upper).contains(&after[i]) {
            let what = "angle of the motor";
            return Err(CoupledLimit { joint: i, what, excess: Excess::new(after[i], limit, "rad") });
        }
        let speed = (after[i] - before[i]).abs() / duration;
        if speed > limits.speed {
            let (what, limit) = ("speed of the motor", limits.speed);
            return Err(CoupledLimit { joint: i, what, excess: Excess::new(speed, limit, "rad/s") });
        }
    }
    Ok(())
}
