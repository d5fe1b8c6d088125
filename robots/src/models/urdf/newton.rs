//! Inverse kinematics by iteration, for chains without a closed form.
//!
//! Levenberg and Marquardt's step on the error between the poses, with the damping that Sugihara gives it
//! (*Solvability-Unconcerned Inverse Kinematics by the Levenberg-Marquardt Method*, IEEE T-RO 2011): as large as the
//! squared error, so that the last steps are Newton's and converge quadratically, at singularities too.
//!
//! ```text
//! e = (p_wanted - p) / reach, log(R_wanted R^T)        (J^T J + lambda 1) dq = J^T e,   lambda = mu |e|^2
//! ```
//!
//! Joints that a step would push through a limit are stopped there, and the others take the step without them. What
//! comes out is the solution that lies downhill from the seed. Where that descent ends above 0 (at a singularity that the
//! seed lies beyond, or at a limit), it is tried again from [`TRIES`] places around the seed, ever farther from it, and
//! always the same ones.

use mrroc::pose::Pose;
use mrroc::robot::Limits;
use nalgebra::{SMatrix, SVector, Vector3};

use super::motion::Linkage;

/// Most steps, those that are taken back included.
const STEPS: usize = 40;

/// Starts: from the seed, then from places around it, the last ones [`FARTHEST`] away [rad or m].
const TRIES: u32 = 24;

/// See [`TRIES`].
const FARTHEST: f64 = 1.0;

/// After so many steps in a row that leave more than [`STALL`] of the squared error, the bottom is taken to be reached.
const STALLS: u32 = 4;

/// See [`STALLS`].
const STALL: f64 = 0.9;

/// Error that counts as zero [parts of the reach, rad]: round-off stops further progress.
const EXACT: f64 = 1e-14;

/// Largest error of a solution [parts of the reach, rad].
pub(super) const GOOD: f64 = 1e-10;

/// Longest step of a joint [rad or m].
const LONGEST: f64 = 0.7;

/// The factor of the damping begins at 1 and stays between these.
const LEAST_FACTOR: f64 = 1e-6;
const MOST_FACTOR: f64 = 1e6;

/// Least damping: redundant chains have no step of their own in some direction.
const LEAST: f64 = 1e-14;

/// Where the iteration stands.
#[derive(Clone, Copy)]
struct Point<const N: usize> {
    q: SVector<f64, N>,
    error: SVector<f64, 6>,
    jacobian: SMatrix<f64, 6, N>,
}

impl<const N: usize> Point<N> {
    fn at(q: SVector<f64, N>, linkage: &Linkage, wanted: &Pose, reach: f64) -> Self {
        let (pose, mut jacobian) = linkage.jacobian(&q);
        let offset = (wanted.translation.vector - pose.translation.vector) / reach;
        let turn = logarithm(wanted, &pose);
        for mut column in jacobian.column_iter_mut() {
            for i in 0..3 {
                column[i] /= reach;
            }
        }
        let error = SVector::<f64, 6>::new(offset.x, offset.y, offset.z, turn.x, turn.y, turn.z);
        Self { q, error, jacobian }
    }
}

/// The turn from one orientation to another: axis times angle \[rad\], at most pi long.
fn logarithm(to: &Pose, from: &Pose) -> Vector3<f64> {
    let q = (to.rotation * from.rotation.inverse()).into_inner();
    let (axis, cosine) = if q.w < 0.0 { (-q.imag(), -q.w) } else { (q.imag(), q.w) };
    let sine = axis.norm();
    let factor = if sine > 1e-9 { 2.0 * sine.atan2(cosine) / sine } else { 2.0 };
    axis * factor
}

/// The joint positions within the limits to which the iteration from `near` comes, with the error of their pose at
/// most [`GOOD`]; else the least error that it came to.
pub(super) fn solve<const N: usize>(
    linkage: &Linkage,
    limits: &Limits<SVector<f64, N>>,
    reach: f64,
    wanted: &Pose,
    near: &SVector<f64, N>,
) -> Result<SVector<f64, N>, f64> {
    let at = |q: SVector<f64, N>| {
        let within = SVector::<f64, N>::from_fn(|i, _| bounded(q[i], limits.lower[i], limits.upper[i]));
        Point::at(within, linkage, wanted, reach)
    };
    let mut least = f64::INFINITY;
    for attempt in 0..TRIES {
        let point = descend(at(near + around::<N>(attempt)), limits, at);
        let error = point.error.norm();
        if error <= GOOD {
            return Ok(point.q);
        }
        least = least.min(error);
    }
    Err(least)
}

/// The value, or the bound that it lies beyond; NaN stays NaN.
fn bounded(value: f64, lower: f64, upper: f64) -> f64 {
    if value < lower {
        lower
    } else if value > upper {
        upper
    } else {
        value
    }
}

/// How far from the seed an attempt begins: at 0, then spread evenly in all directions (the additive recurrence of
/// square roots of primes, whose fractional parts are equidistributed).
fn around<const N: usize>(attempt: u32) -> SVector<f64, N> {
    const PRIMES: [f64; 8] = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0];
    let size = FARTHEST * f64::from(attempt) / f64::from(TRIES - 1);
    SVector::<f64, N>::from_fn(|i, _| {
        size * (2.0 * (f64::from(attempt) * PRIMES[i % 8].sqrt()).fract() - 1.0)
    })
}

/// Goes downhill until the error is round-off or does not shrink.
fn descend<const N: usize>(
    mut point: Point<N>,
    limits: &Limits<SVector<f64, N>>,
    at: impl Fn(SVector<f64, N>) -> Point<N>,
) -> Point<N> {
    let mut mu = 1.0;
    let mut stalled = 0;
    for _ in 0..STEPS {
        if point.error.norm() < EXACT || stalled == STALLS {
            break;
        }
        let Some(step) = step(&point, limits, mu) else { break };
        let next = at(point.q + step);
        let before = point.error.norm_squared();
        let after = next.error.norm_squared();
        stalled = if after > STALL * before { stalled + 1 } else { 0 };
        if after < before {
            point = next;
            mu = (0.25 * mu).max(LEAST_FACTOR);
        } else if point.error.norm() < GOOD || mu >= MOST_FACTOR {
            break;
        } else {
            mu *= 8.0;
        }
    }
    point
}

/// The damped step, without the joints that stand at a limit and would be pushed through it.
fn step<const N: usize>(
    point: &Point<N>,
    limits: &Limits<SVector<f64, N>>,
    mu: f64,
) -> Option<SVector<f64, N>> {
    let downhill = point.jacobian.tr_mul(&point.error);
    let mut matrix = point.jacobian.tr_mul(&point.jacobian);
    let mut right = downhill;
    let damping = mu * point.error.norm_squared() + LEAST;
    for i in 0..N {
        let stopped = (point.q[i] <= limits.lower[i] && downhill[i] < 0.0)
            || (point.q[i] >= limits.upper[i] && downhill[i] > 0.0);
        if stopped {
            for k in 0..N {
                matrix[(i, k)] = 0.0;
                matrix[(k, i)] = 0.0;
            }
            matrix[(i, i)] = 1.0;
            right[i] = 0.0;
        }
        matrix[(i, i)] += damping;
    }
    let mut step = matrix.cholesky()?.solve(&right);
    let longest = step.amax();
    if longest > LONGEST {
        step *= LONGEST / longest;
    }
    Some(step)
}
