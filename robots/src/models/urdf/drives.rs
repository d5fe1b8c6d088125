//! Assumed motors for a chain read from URDF: one a joint, made to fit what the file says of the joint.
//!
//! A URDF has no motors. These are **assumed**: every joint is driven through a gear by a motor of its own, which is just
//! large enough. With the joint's limits of speed v and acceleration a, its effort E, damping d and friction f:
//!
//! ```text
//! gear          g = min(250 rad/s / v, 500 rad/s² / a)
//! inertia       J = 1e-4 kg m² + M / g²     M: no posture has a greater inertia about the joint
//! friction      b = 0.4 J + d / g²,   tau_c = 32 J + f / g          (the IRp-6's column without d and f)
//! weight        tau_load = dV/dm:  the links' potential energy by the motor's angle, in any posture
//! current       E / (g k); where no effort above 0 is written, twice what the joint needs at its limits
//! ```
//!
//! The regulators are those of the IRp-6's column, their gains scaled so that their loops cross over as that does. M is a
//! bound: `(sum of |multiplier| sqrt(I))²` over the joints that move with the coordinate, I taken with every link as far
//! away as the links between allow. Links without `<inertial>` have no mass, as URDF says; links
//! that are not between base and tip are left out.

use mrroc::pose::Pose;
use mrroc::robot::JointKind;
use nalgebra::{SVector, Vector3};

use super::body::Body;
use super::chain::{Chain, Mover, Segment};
use super::places::MOST_SEGMENTS;
use crate::models::drives::{GRAVITY, Gains, MotorData, MotorLimits};
use crate::models::irp6::Irp6;

/// Speed [rad/s] and acceleration [rad/s²] of a motor that gears are chosen for.
const FASTEST: f64 = 250.0;
const QUICKEST: f64 = 500.0;
/// Speed of a motor above which drives refuse a demand: a little more, for round-off [rad/s].
const MOTOR_SPEED: f64 = 260.0;
/// Inertia of a rotor [kg m²].
pub(super) const ROTOR: f64 = 1e-4;
/// Viscous friction of a motor by its inertia [1/s].
const VISCOUS: f64 = 0.4;
/// Coulomb friction of a motor by its inertia [rad/s²].
const COULOMB: f64 = 32.0;
/// The drive whose servo loop they have.
const COLUMN: MotorData = Irp6::MOTORS[0];
/// Part of the voltage that is left at full speed, divided by the torque constant and by a fifth more torque [V/(N m/A)].
const SPARE: f64 = 0.8 * COLUMN.torque_constant * 44.0;

/// The drives of a chain, and the bodies that they carry.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Drives<const N: usize> {
    pub(super) motors: [MotorData; N],
    pub(super) limits: MotorLimits<N>,
    pub(super) gears: SVector<f64, N>,
    pub(super) bodies: Vec<Body>,
}

impl<const N: usize> Drives<N> {
    /// The drives of `chain`, whose joints are accelerated by at most `acceleration`.
    pub(super) fn of(chain: &Chain, acceleration: &SVector<f64, N>) -> Self {
        let gears =
            SVector::from_fn(|i, _| (FASTEST / chain.movers[i].velocity).min(QUICKEST / acceleration[i]));
        let range = |i: usize| chain.movers[i].range;
        Self {
            motors: core::array::from_fn(|i| {
                motor(&chain.movers[i], gears[i], acceleration[i], &Carried::by(chain, i))
            }),
            limits: MotorLimits {
                lower: core::array::from_fn(|i| gears[i] * range(i).0),
                upper: core::array::from_fn(|i| gears[i] * range(i).1),
                speed: MOTOR_SPEED,
            },
            gears,
            bodies: chain.bodies.clone(),
        }
    }
}

/// A motor that fits its joint.
fn motor(mover: &Mover, gear: f64, acceleration: f64, carried: &Carried) -> MotorData {
    let inertia = ROTOR + carried.inertia / (gear * gear);
    let viscous = VISCOUS * inertia + mover.damping / (gear * gear);
    let coulomb = COULOMB * inertia + mover.friction / gear;
    let needed =
        inertia * acceleration * gear + carried.weight / gear + viscous * mover.velocity * gear + coulomb;
    let effort = mover.effort.filter(|effort| *effort > 0.0);
    // Its loop gain is that of the column; a joint that needs more torque than that gives has less resistance.
    let alike = COLUMN.resistance * COLUMN.inertia / inertia;
    let resistance = alike.min(SPARE / needed);
    let scale = resistance / alike;
    let Gains { a, b0, b1, feedforward } = COLUMN.gains;
    MotorData {
        gains: Gains { a, b0: scale * b0, b1: scale * b1, feedforward },
        current_limit: effort.map_or(2.0 * needed, |effort| effort / gear) / COLUMN.torque_constant,
        resistance,
        inertia,
        viscous,
        coulomb,
        ..COLUMN
    }
}

/// What a coordinate carries, whatever the posture.
struct Carried {
    /// No posture has a greater inertia about it [kg m² or kg].
    inertia: f64,
    /// No posture has a greater effort by the weight [N m or N].
    weight: f64,
}

impl Carried {
    fn by(chain: &Chain, leader: usize) -> Self {
        let mut root = 0.0;
        let mut weight = 0.0;
        for (s, segment) in chain.segments.iter().enumerate().filter(|(_, one)| one.leader == leader) {
            let share = segment.multiplier.abs();
            // How far what follows can be from this joint.
            let mut inertia = 0.0;
            let mut moment = 0.0;
            let mut away = 0.0;
            for (k, body) in chain.bodies.iter().enumerate().skip(s) {
                away += if k == s { 0.0 } else { chain.segments[k].X_before.translation.vector.norm() };
                away += slide(&chain.movers, &chain.segments[k]);
                let reach = away + body.centre.norm();
                match segment.kind {
                    JointKind::Revolute => {
                        inertia += body.mass * reach * reach + body.spin;
                        moment += body.mass * reach;
                    }
                    JointKind::Prismatic => {
                        inertia += body.mass;
                        moment += body.mass;
                    }
                }
            }
            root += share * f64::sqrt(inertia);
            weight += share * GRAVITY * moment;
        }
        Self { inertia: root * root, weight }
    }
}

/// How far a slide is drawn out at most \[m\].
fn slide(movers: &[Mover], segment: &Segment) -> f64 {
    let at = |q: f64| (segment.multiplier * q + segment.offset).abs();
    match segment.kind {
        JointKind::Revolute => 0.0,
        JointKind::Prismatic => {
            movers.get(segment.leader).map_or(0.0, |mover| at(mover.range.0).max(at(mover.range.1)))
        }
    }
}

/// Efforts of the bodies' weight at the coordinates [N m or N], positive against positive motion: the derivatives of the
/// potential energy, gravity along -z of the world.
#[allow(non_snake_case)]
pub(super) fn efforts<const N: usize>(
    segments: &[Segment],
    bodies: &[Body],
    q: &SVector<f64, N>,
) -> SVector<f64, N> {
    let mut axes = [(Vector3::zeros(), Vector3::zeros(), Vector3::zeros()); MOST_SEGMENTS];
    let mut X_WL = Pose::identity();
    for ((segment, body), axis) in segments.iter().zip(bodies).zip(&mut axes) {
        X_WL *= segment.X_before;
        let direction = X_WL.rotation * Vector3::z();
        let point = X_WL.translation.vector;
        let value = segment.multiplier * q[segment.leader] + segment.offset;
        X_WL *= match segment.kind {
            JointKind::Revolute => Pose::rotation(Vector3::z() * value),
            JointKind::Prismatic => Pose::translation(0.0, 0.0, value),
        };
        *axis = (direction, point, X_WL.translation.vector + X_WL.rotation * body.centre);
    }
    let mut efforts = SVector::zeros();
    let mut mass = 0.0;
    let mut moment = Vector3::zeros();
    for ((segment, body), (direction, point, centre)) in segments.iter().zip(bodies).zip(axes).rev() {
        mass += body.mass;
        moment += centre * body.mass;
        let raised = match segment.kind {
            JointKind::Revolute => direction.cross(&(moment - point * mass)).z,
            JointKind::Prismatic => direction.z * mass,
        };
        efforts[segment.leader] += segment.multiplier * GRAVITY * raised;
    }
    efforts
}
