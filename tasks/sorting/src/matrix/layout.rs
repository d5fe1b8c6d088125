//! Where the matrix is.

use mrroc_sensors::ultrasound::Array;

use crate::camera::kinds::KINDS;
use crate::places::SURFACE;

/// Where its middle is, along s, and how high over the belt \[m\].
pub const MATRIX: [f64; 2] = [-0.42, 0.25];

/// Up to which misfit a part is of its kind, in their order: flat, compact parts fit better than others. What true parts hardly exceed; of
/// half-cylinders with a tenth of their echoes lost one in ten does.
pub const LIMITS: [f64; KINDS] = [0.95, 1.2, 0.7, 0.9, 1.2, 1.2, 1.2, 1.2];

/// The matrix, as it is believed to be: four rows of eight.
#[must_use]
pub fn array() -> Array {
    let [along, height] = MATRIX;
    Array::over(along, height, 0.5 * SURFACE[2])
}
