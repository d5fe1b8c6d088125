//! Vectors with one entry per joint, or per motor, of robots with so many of them.

use nalgebra::SVector;

/// The one entry of a robot with one joint.
pub type One = SVector<f64, 1>;

/// One entry per joint, or per motor, of a robot with five.
pub type Five = SVector<f64, 5>;

/// One entry per joint, or per motor, of a robot with six.
pub type Six = SVector<f64, 6>;

/// One entry per joint, or per motor, of a robot with seven.
pub type Seven = SVector<f64, 7>;
