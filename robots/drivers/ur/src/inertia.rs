//! The elements of an inertia, as the controller takes and tells them.
//!
//! In: an inertia, or its elements in UR's order. Out: the other one.

use nalgebra::Matrix3;

/// The elements of an inertia, in UR's order [kg m²].
#[must_use]
pub fn elements(inertia: &Matrix3<f64>) -> [f64; 6] {
    [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|place| inertia[place])
}

/// The inertia of its elements in UR's order [kg m²].
#[must_use]
pub fn inertia([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}
