//! Motors that their links couple: all plants of a robot in one integration step.
//!
//! With motor angles m, `qdot = T omega`, `T = dq/dm`, the links' mass matrix M and bias h, and the rotors' inertias J:
//!
//! ```text
//! (J + T^T M T) omegadot + T^T (M Tdot omega + h) = kt i - b omega - tau_load - tau_c sign(omega)
//! ```
//!
//! A step of length h is that of a single plant: current, viscous and Coulomb friction are those at its end, so
//!
//! ```text
//! J (omega' - omega) + T^T M (T omega' - qdot) = h (kt i' - b omega' - tau_load - tau_f' - T^T h(q, qdot))
//! ```
//!
//! where qdot are the joints' speeds at the end of the step before, by the T of that step: their difference has the term of
//! Tdot. Every motor stands, or turns with or without its current at the limit; in each case its equation is linear. The cases
//! are found by solving for all motors at once and correcting those that came out otherwise, in the end one by one from the
//! first (Murty 1974: this ends, for the matrix is positive definite). Mass matrix and bias are those of the step's begin, so
//! energy is kept to the order of the step, not exactly as by a single plant.

#[cfg(test)]
mod tests;

use nalgebra::{SMatrix, SVector};

use super::{H, Plant};
use crate::dynamics::{Dynamics, Equation};
use crate::models::Driven;

/// Corrections of all motors at once, and of one at a time, after which a step takes what it has.
const TOGETHER: u32 = 8;
const SINGLE: u32 = 200;

/// The links between the motors of a robot.
#[derive(Debug)]
pub(in crate::simulation) struct Coupling<const N: usize> {
    links: Box<dyn Dynamics<N>>,
    motors: [Motor; N],
    /// Joint speeds at the end of the last step [rad/s or m/s].
    velocity: SVector<f64, N>,
}

/// What a motor has beside its [`Plant`], as changes of momentum in a step.
#[derive(Clone, Copy, Debug)]
struct Motor {
    rotor: f64,
    per_current: f64,
    viscous: f64,
    friction: f64,
    case: Case,
}

/// In which case a motor is: its equation in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Case {
    /// Held by its friction.
    Stands,
    /// Turns in this direction, with the current that the voltage gives.
    Turns(f64),
    /// Turns in this direction, with this current, its limit \[A\].
    Limited(f64, f64),
}

impl<const N: usize> Coupling<N> {
    /// The links of a robot at rest; `None` where their masses are not known, or leave nothing for a rotor.
    pub(in crate::simulation) fn of(robot: &impl Driven<N>) -> Option<Self> {
        let links = robot.dynamics()?;
        let rotors = robot.rotors();
        if !rotors.iter().all(|rotor| *rotor > 0.0) {
            return None;
        }
        let motors = core::array::from_fn(|i| {
            let data = &robot.motor_data()[i];
            Motor {
                rotor: rotors[i],
                per_current: H * data.torque_constant,
                viscous: H * data.viscous,
                friction: H * data.coulomb,
                case: Case::Stands,
            }
        });
        Some(Self { links, motors, velocity: SVector::zeros() })
    }

    /// Torques of the links' weight at the motors where these stand at `angles` [N m].
    pub(in crate::simulation) fn weight(
        &self,
        robot: &impl Driven<N>,
        angles: &SVector<f64, N>,
    ) -> SVector<f64, N> {
        let held = self.links.equation(&robot.positions(angles), &SVector::zeros());
        robot.ratios(angles).tr_mul(&held.bias)
    }

    /// Takes the joints' speeds from the motors, after these were moved otherwise.
    pub(in crate::simulation) fn follow(&mut self, robot: &impl Driven<N>, plants: &[Plant; N]) {
        let angles = SVector::from_fn(|i, _| plants[i].angle);
        self.velocity = robot.ratios(&angles) * SVector::from_fn(|i, _| plants[i].speed);
    }

    /// One servo period with the pulse widths `pwm` against the torques `loads` from outside [N m] (positive: against positive
    /// motion).
    pub(in crate::simulation) fn run(
        &mut self,
        robot: &impl Driven<N>,
        plants: &mut [Plant; N],
        pwm: &[f64; N],
        loads: &SVector<f64, N>,
    ) {
        for _ in 0..Plant::SUBSTEPS {
            self.step(robot, plants, pwm, loads);
        }
    }

    fn step(
        &mut self,
        robot: &impl Driven<N>,
        plants: &mut [Plant; N],
        pwm: &[f64; N],
        loads: &SVector<f64, N>,
    ) {
        let angles = SVector::from_fn(|i, _| plants[i].angle);
        let ratios = robot.ratios(&angles);
        let Equation { mass, bias } = self.links.equation(&robot.positions(&angles), &self.velocity);
        let carried = mass * ratios;
        let mut matrix = ratios.tr_mul(&carried);
        let mut momentum = carried.tr_mul(&self.velocity) - ratios.tr_mul(&bias) * H - loads * H;
        for (i, motor) in self.motors.iter().enumerate() {
            matrix[(i, i)] += motor.rotor;
            momentum[i] += motor.rotor * plants[i].speed;
        }
        let speeds = self.solve(&matrix, &momentum, plants, pwm);
        for (i, plant) in plants.iter_mut().enumerate() {
            plant.speed = speeds[i];
            plant.current = plant.current_at(pwm[i]);
            plant.angle += H * plant.speed;
        }
        self.velocity = ratios * speeds;
    }

    /// The speeds at the end of a step: `matrix speeds = momentum + what current and friction give` [rad/s].
    fn solve(
        &mut self,
        matrix: &SMatrix<f64, N, N>,
        momentum: &SVector<f64, N>,
        plants: &[Plant; N],
        pwm: &[f64; N],
    ) -> SVector<f64, N> {
        let mut speeds = SVector::zeros();
        for trial in 0..TOGETHER + SINGLE {
            let mut own = *matrix;
            let mut right = *momentum;
            for (i, motor) in self.motors.iter().enumerate() {
                let model = &plants[i].model;
                own[(i, i)] += motor.viscous;
                match motor.case {
                    Case::Stands => {
                        own.row_mut(i).fill(0.0);
                        own.column_mut(i).fill(0.0);
                        own[(i, i)] = 1.0;
                        right[i] = 0.0;
                    }
                    Case::Turns(side) => {
                        own[(i, i)] += motor.per_current * model.current_per_speed;
                        right[i] +=
                            motor.per_current * model.current_per_pwm * pwm[i] - side * motor.friction;
                    }
                    Case::Limited(side, current) => {
                        right[i] += motor.per_current * current - side * motor.friction;
                    }
                }
            }
            // Positive definite: rotors have inertia.
            let Some(factors) = own.cholesky() else { return speeds };
            speeds = factors.solve(&right);
            let mut all_hold = true;
            for i in 0..N {
                let case = self.case(i, &speeds, matrix, momentum, &plants[i], pwm[i]);
                if case != self.motors[i].case {
                    self.motors[i].case = case;
                    all_hold = false;
                    if trial >= TOGETHER {
                        break;
                    }
                }
            }
            if all_hold {
                break;
            }
        }
        speeds
    }

    /// The case of motor `i` with these speeds at the end of the step.
    fn case(
        &self,
        i: usize,
        speeds: &SVector<f64, N>,
        matrix: &SMatrix<f64, N, N>,
        momentum: &SVector<f64, N>,
        plant: &Plant,
        pwm: f64,
    ) -> Case {
        let motor = &self.motors[i];
        if plant.jammed {
            return Case::Stands;
        }
        let side = match motor.case {
            Case::Stands => {
                let pushed = momentum[i] - matrix.row(i).transpose().dot(speeds)
                    + motor.per_current * plant.limited(plant.model.current_per_pwm * pwm);
                if pushed.abs() <= motor.friction {
                    return Case::Stands;
                }
                1.0_f64.copysign(pushed)
            }
            Case::Turns(side) | Case::Limited(side, _) => {
                if side * speeds[i] < 0.0 {
                    return Case::Stands;
                }
                side
            }
        };
        let current = plant.model.current_per_pwm * pwm - plant.model.current_per_speed * speeds[i];
        let limited = plant.limited(current);
        if limited == current { Case::Turns(side) } else { Case::Limited(side, limited) }
    }
}
