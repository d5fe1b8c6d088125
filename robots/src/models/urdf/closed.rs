//! The closed forms of chains that have one, for any number of joints.

use mrroc::pose::Pose;
use mrroc::robot::NoInverse;
use nalgebra::SVector;

use super::chain::Segment;
use super::recognition::{Axes, EXACT};
use crate::models::opw::OrthoParallel;
use crate::models::spherical::Spherical;
use crate::models::three_parallel::ThreeParallel;

/// A chain in closed form; its number of joints is that of the chain.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Closed {
    OrthoParallel(OrthoParallel),
    ThreeParallel(ThreeParallel),
    Spherical(Spherical),
}

impl Closed {
    /// The closed form of the chain, if it has one.
    pub(super) fn of(segments: &[Segment], #[allow(non_snake_case)] X_tip: &Pose) -> Option<Self> {
        Self::within(EXACT, segments, X_tip)
    }

    /// The closed form of a chain whose axes are so far from those of one \[rad, m\].
    pub(super) fn within(
        tolerance: f64,
        segments: &[Segment],
        #[allow(non_snake_case)] X_tip: &Pose,
    ) -> Option<Self> {
        let axes = Axes::of(segments, X_tip, tolerance)?;
        let parallel = || axes.three_parallel().map(Self::ThreeParallel);
        let spherical = || axes.spherical().map(Self::Spherical);
        axes.ortho_parallel().map(Self::OrthoParallel).or_else(parallel).or_else(spherical)
    }

    /// The solution nearest to `near`.
    #[inline]
    #[allow(non_snake_case)]
    pub(super) fn inverse<const N: usize>(
        &self,
        X_WF: &Pose,
        near: &SVector<f64, N>,
    ) -> Result<SVector<f64, N>, NoInverse> {
        match self {
            Self::OrthoParallel(arm) => arm.inverse(X_WF, &joints(near)).map(|q| vector(&q)),
            Self::ThreeParallel(arm) => arm.inverse(X_WF, &joints(near)).map(|q| vector(&q)),
            Self::Spherical(arm) => arm.inverse(X_WF, &joints(near)).map(|q| vector(&q)),
        }
    }

    /// The solution nearest to `near` at a value of the redundancy.
    #[allow(non_snake_case)]
    pub(super) fn inverse_at<const N: usize>(
        &self,
        X_WF: &Pose,
        redundancy: f64,
        near: &SVector<f64, N>,
    ) -> Result<SVector<f64, N>, NoInverse> {
        match self {
            Self::Spherical(arm) => arm.inverse_at(X_WF, redundancy, &joints(near)).map(|q| vector(&q)),
            Self::OrthoParallel(_) | Self::ThreeParallel(_) => Err(NoInverse::NotRedundant),
        }
    }

    /// All solutions.
    #[allow(non_snake_case)]
    pub(super) fn solutions<const N: usize>(
        &self,
        X_WF: &Pose,
        near: &SVector<f64, N>,
        visit: &mut dyn FnMut(&SVector<f64, N>),
    ) -> Result<(), NoInverse> {
        match self {
            Self::OrthoParallel(arm) => arm.solutions(X_WF, &joints(near), |q| visit(&vector(q))),
            Self::ThreeParallel(arm) => arm.solutions(X_WF, &joints(near), |q| visit(&vector(q))),
            Self::Spherical(arm) => arm.solutions(X_WF, &joints(near), |q| visit(&vector(q))),
        }
    }

    /// The singularity that `q` lies near, if any.
    pub(super) fn near_singularity<const N: usize>(&self, q: &SVector<f64, N>) -> Option<&'static str> {
        match self {
            Self::OrthoParallel(arm) => arm.near_singularity(&joints(q)),
            Self::ThreeParallel(arm) => arm.near_singularity(&joints(q)),
            Self::Spherical(arm) => arm.near_singularity(&joints(q)),
        }
    }

    /// The value of the redundancy at `q`, of an arm that has one.
    pub(super) fn redundancy<const N: usize>(&self, q: &SVector<f64, N>) -> Option<f64> {
        match self {
            Self::Spherical(arm) => Some(arm.arm_angle(&joints(q))),
            Self::OrthoParallel(_) | Self::ThreeParallel(_) => None,
        }
    }
}

/// The first `M` coordinates, filled up by 0; a closed form of `M` joints belongs to a chain of as many.
#[inline(always)]
pub(super) fn joints<const N: usize, const M: usize>(q: &SVector<f64, N>) -> [f64; M] {
    core::array::from_fn(|i| if i < N { q[i] } else { 0.0 })
}

#[inline(always)]
fn vector<const N: usize, const M: usize>(q: &[f64; M]) -> SVector<f64, N> {
    SVector::from_fn(|i, _| if i < M { q[i] } else { 0.0 })
}
