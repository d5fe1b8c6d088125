//! Where the matrix is.

use mrroc_sensors::ultrasound::Array;

use crate::places::SURFACE;

/// Where its middle is, along s, and how high over the belt \[m\].
pub const MATRIX: [f64; 2] = [-0.42, 0.25];

/// The matrix, as it is believed to be: four rows of eight.
#[must_use]
pub fn array() -> Array {
    let [along, height] = MATRIX;
    Array::over(along, height, 0.5 * SURFACE[2])
}
