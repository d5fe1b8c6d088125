//! Inverse kinematics of arms whose axes are nearly those of a closed form: angles in their file are rounded (`1.5708`), or the arm
//! is calibrated.
//!
//! The closed form of the nearest exact geometry, whose flange is `X(q)`, stands for the inverse of the arm's own `F(q)`. It
//! is corrected by what the arm is off, which is Newton's iteration with the derivative of the exact geometry:
//!
//! ```text
//! q_0 = X^-1(wanted),   q_i+1 = X^-1(Y_i+1),   Y_0 = wanted,   Y_i+1 = Y_i F(q_i)^-1 wanted
//! ```
//!
//! Each step leaves of the error a part as large as the rounding (1e-9 to 1e-4), divided by the distance to a singularity; so two
//! steps are enough nearly everywhere. A calibrated arm is off by 1e-3 to 1e-2, and needs four to six. The branch is that of the closed form, and so is the arm angle of seven joints: nothing
//! drifts along a path.

use mrroc::pose::Pose;
use mrroc::robot::NoInverse;
use nalgebra::SVector;

use super::chain::Segment;
use super::closed::Closed;
use super::error::UrdfError;
use super::motion::Linkage;

/// How far axes may be from perpendicular or parallel \[rad\] and from meeting \[m\], for the closed form to be tried: right
/// angles of four decimals are off by at most 5e-5.
pub(super) const ROUNDED: f64 = 1e-4;

/// Error that a solution may have [m, rad]. Round-off of the chain's forward and inverse kinematics is some 1e-15.
const GOOD: f64 = 1e-12;

/// Most corrections: beside a singularity each of them leaves more of the error.
const CORRECTIONS: usize = 12;

/// The same for a calibrated arm.
const MORE_CORRECTIONS: usize = 40;

/// How far the flange of a calibrated arm may be from that of the nominal one \[m\], and turned against it \[rad\]. Published
/// calibrations are off by 5 mm and 0.012 rad; another model, by 70 mm and more.
const NEAR: (f64, f64) = (0.03, 0.05);

/// Postures at which the closed form must lead to the arm's own solution for it to be taken.
const TRIALS: u32 = 32;

/// The closed form of the exact geometry that is nearest to a chain's.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rounded {
    nearest: Closed,
    corrections: usize,
}

impl Rounded {
    /// That of a chain which is near one; `None` if solutions are not found in that form.
    #[allow(non_snake_case)]
    pub(super) fn of<const N: usize>(segments: &[Segment], X_tip: &Pose, linkage: &Linkage) -> Option<Self> {
        let nearest = Closed::within(ROUNDED, segments, X_tip)?;
        let rounded = Self { nearest, corrections: CORRECTIONS };
        let leads_back = |trial: u32| {
            let q = posture::<N>(trial);
            rounded.nearest.near_singularity(&q).is_some()
                || rounded
                    .inverse(linkage, &linkage.forward(&q), &q)
                    .is_ok_and(|found| (found - q).amax() < 0.1)
        };
        (0..TRIALS).all(leads_back).then_some(rounded)
    }

    /// That of a nominal arm, for one that differs from it by its calibration.
    pub(super) fn calibrated(nominal: &Closed) -> Self {
        Self { nearest: nominal.clone(), corrections: MORE_CORRECTIONS }
    }

    /// The closed form of the nearest exact geometry: for what a rounding does not change, such as which singularity is near.
    pub(super) const fn nearest(&self) -> &Closed {
        &self.nearest
    }

    /// The solution nearest to `near`.
    #[allow(non_snake_case)]
    pub(super) fn inverse<const N: usize>(
        &self,
        linkage: &Linkage,
        X_WF: &Pose,
        near: &SVector<f64, N>,
    ) -> Result<SVector<f64, N>, NoInverse> {
        corrected(self.corrections, linkage, X_WF, near, |wanted, near| self.nearest.inverse(wanted, near))
    }

    /// The solution nearest to `near` at a value of the redundancy.
    #[allow(non_snake_case)]
    pub(super) fn inverse_at<const N: usize>(
        &self,
        linkage: &Linkage,
        X_WF: &Pose,
        redundancy: f64,
        near: &SVector<f64, N>,
    ) -> Result<SVector<f64, N>, NoInverse> {
        corrected(self.corrections, linkage, X_WF, near, |wanted, near| {
            self.nearest.inverse_at(wanted, redundancy, near)
        })
    }

    /// All solutions.
    #[allow(non_snake_case)]
    pub(super) fn solutions<const N: usize>(
        &self,
        linkage: &Linkage,
        X_WF: &Pose,
        near: &SVector<f64, N>,
        visit: &mut dyn FnMut(&SVector<f64, N>),
    ) -> Result<(), NoInverse> {
        let mut last = None;
        let mut found = false;
        self.nearest.solutions(X_WF, near, &mut |branch: &SVector<f64, N>| match self
            .inverse(linkage, X_WF, branch)
        {
            Ok(q) => {
                visit(&q);
                found = true;
            }
            Err(error) => last = Some(error),
        })?;
        match last {
            Some(error) if !found => Err(error),
            Some(_) | None => Ok(()),
        }
    }
}

/// Corrects what the closed form `solve` gives, on its branch.
#[allow(non_snake_case)]
fn corrected<const N: usize>(
    corrections: usize,
    linkage: &Linkage,
    X_WF: &Pose,
    near: &SVector<f64, N>,
    solve: impl Fn(&Pose, &SVector<f64, N>) -> Result<SVector<f64, N>, NoInverse>,
) -> Result<SVector<f64, N>, NoInverse> {
    let mut q = solve(X_WF, near)?;
    let mut shifted = *X_WF;
    let mut best = (q, f64::INFINITY);
    for _ in 0..corrections {
        let missing = linkage.forward(&q).inv_mul(X_WF);
        let error = missing.translation.vector.norm().max(2.0 * missing.rotation.imag().norm());
        if error < best.1 {
            best = (q, error);
        }
        if error < GOOD {
            break;
        }
        shifted *= missing;
        q = solve(&shifted, &q)?;
    }
    // Beside a singularity the last digits may be out of reach of the joints' own round-off.
    if best.1 < 100.0 * GOOD {
        Ok(best.0)
    } else {
        Err(NoInverse::NotConverged { error: best.1, tolerance: 100.0 * GOOD })
    }
}

impl Linkage {
    /// How far its flange is from that of another linkage at most, at some postures \[m\]; a turn counts as at the end of a metre.
    pub(super) fn apart<const N: usize>(&self, other: &Linkage) -> f64 {
        let at = |trial: u32| {
            let q = posture::<N>(trial);
            let apart = other.forward(&q).inv_mul(&self.forward(&q));
            apart.translation.vector.norm().max(apart.rotation.angle())
        };
        (0..TRIALS).map(at).fold(0.0, f64::max)
    }
}

/// Checks that one arm is another one, calibrated.
///
/// # Errors
/// [`UrdfError::NotNear`], with how far they are apart.
pub(super) fn check_near<const N: usize>(arm: &Linkage, nominal: &Linkage) -> Result<(), UrdfError> {
    let (mut position, mut angle) = (0.0_f64, 0.0_f64);
    for trial in 0..TRIALS {
        let q = posture::<N>(trial);
        let apart = nominal.forward(&q).inv_mul(&arm.forward(&q));
        position = position.max(apart.translation.vector.norm());
        angle = angle.max(apart.rotation.angle());
    }
    let (most_position, most_angle) = NEAR;
    match position <= most_position && angle <= most_angle {
        true => Ok(()),
        false => Err(UrdfError::NotNear { position, angle, most_position, most_angle }),
    }
}

/// Postures all over the range of a turn, always the same ones: fractional parts of square roots of primes.
fn posture<const N: usize>(trial: u32) -> SVector<f64, N> {
    const PRIMES: [f64; 8] = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0];
    SVector::<f64, N>::from_fn(|i, _| {
        core::f64::consts::TAU * ((f64::from(trial) + 0.5) * PRIMES[i % 8].sqrt()).fract()
            - core::f64::consts::PI
    })
}
