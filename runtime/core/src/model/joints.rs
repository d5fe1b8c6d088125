//! Joint coordinates: fixed-size vectors, so that no step allocates.

use core::fmt::Debug;
use core::ops::{Add, Index, IndexMut, Mul, Sub};

use nalgebra::SVector;

/// The most joints that one robot may have; the wire format reserves this many words per vector.
pub const MAX_JOINTS: usize = 8;

mod sealed {
    pub trait Sealed {}
    impl<const N: usize> Sealed for nalgebra::SVector<f64, N> {}
}

/// A vector with one entry per joint of a robot: positions [rad or m], velocities, accelerations ..
///
/// Implemented for `nalgebra::SVector<f64, N>`; a robot names its own as [`Robot::Joints`](crate::robot::Robot::Joints).
pub trait JointVector:
    sealed::Sealed
    + Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Index<usize, Output = f64>
    + IndexMut<usize>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<f64, Output = Self>
{
    /// Number of joints, 0..=[`MAX_JOINTS`]. A device without joints has inputs and outputs alone.
    const LEN: usize;

    /// The vector whose entry `i` is `entry(i)`.
    fn from_joints(entry: impl FnMut(usize) -> f64) -> Self;

    /// The entries in joint order.
    fn as_slice(&self) -> &[f64];

    /// All entries zero.
    #[must_use]
    fn zeros() -> Self {
        Self::from_joints(|_| 0.0)
    }

    /// Whether no entry is NaN or infinite.
    fn is_finite(&self) -> bool {
        self.as_slice().iter().all(|entry| entry.is_finite())
    }
}

impl<const N: usize> JointVector for SVector<f64, N> {
    const LEN: usize = {
        assert!(N <= MAX_JOINTS, "a robot has up to 8 joints");
        N
    };

    fn from_joints(mut entry: impl FnMut(usize) -> f64) -> Self {
        // Less than half of the code that `SVector::from_fn` is compiled to, for every closure and number of joints.
        let mut joints = [0.0; N];
        for (i, joint) in joints.iter_mut().enumerate() {
            *joint = entry(i);
        }
        SVector::from(joints)
    }

    fn as_slice(&self) -> &[f64] {
        SVector::as_slice(self)
    }
}
