//! What a result must at least be: how well poses must fit, and how well what was found must be known. What is worse is not written.
//!
//! Standard deviations come from what is left of the measurements. Few measurements may fit by accident better than anybody measures, so that at least a usual noise
//! is counted: the floors below. By them poses that hardly differ are told from those that do, whatever the data's own noise.

use crate::fit::FoundParameter;
use crate::parameter::Unit;

/// Poses that are off by more than this, as root mean square, do not fit: positions \[m\], orientations \[rad\] (the same at an arm's length of 0.25 m), corners \[pixel\].
pub const WRONG: f64 = 5e-3;
/// See [`WRONG`].
pub const WRONG_TURN: f64 = 2e-2;
/// See [`WRONG`].
pub const WRONG_PIXELS: f64 = 8.0;

/// A single pose is a mistake that is off by so many times that.
pub const WRONG_ALONE: f64 = 3.0;

/// The standard deviation at most of each coordinate of a tip \[m\]: a fifth of what counts as no fit.
pub const TIP: f64 = 1e-3;

/// The same of a camera on a hand or beside an arm: position \[m\], and orientation \[rad\], which is as much at 0.4 m from it.
pub const CAMERA: f64 = 2e-3;
/// See [`CAMERA`].
pub const CAMERA_TURN: f64 = 5e-3;

/// The same of a base: the middle of the points that were touched \[m\], and turns \[rad\], which are as much at 0.5 m from it.
pub const BASE: f64 = 1e-3;
/// See [`BASE`].
pub const BASE_TURN: f64 = 2e-3;

/// The same of a focal length, as a share of it, and of the centre and of what the lens bends, as shares of the focal length: what is seen at 0.5 m is then 5 mm beside.
pub const LENS: f64 = 0.01;

/// Frames that come with an arm, from its own calibration: position \[m\], and orientation \[rad\], twice what zeros of joints are usually off by.
pub const FRAME: f64 = 5e-3;
/// See [`FRAME`].
pub const FRAME_TURN: f64 = 2e-2;

/// A parameter of an arm counts as unknown whose standard deviation is still more than this share of its tolerance.
pub const HARDLY: f64 = 0.5;

/// Whether a parameter of an arm's calibration is as good as unknown: the measurements say little more of it than its tolerance, or, without one, less than a frame is worth.
#[must_use]
pub fn is_unknown(found: &FoundParameter) -> bool {
    let most = match (found.parameter.tolerance, found.parameter.unit) {
        (Some(tolerance), _) => HARDLY * tolerance,
        (None, Unit::Metre) => FRAME,
        (None, Unit::Radian) => FRAME_TURN,
        (None, Unit::Pixel | Unit::One | Unit::RadianPerNewtonMetre) => return false,
    };
    let is_sure = found.sigma <= most;
    !is_sure
}

/// A tip is put on a point by hand to no better than this \[m\].
pub(crate) const TOUCHING: f64 = 1e-4;

/// A board is seen to no better than this: position \[m\], orientation \[rad\], corners \[pixel\].
pub(crate) const SEEING: f64 = 1e-4;
/// See [`SEEING`].
pub(crate) const SEEING_TURN: f64 = 3e-4;
/// See [`SEEING`].
pub(crate) const SEEING_PIXELS: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::Parameter;

    #[test]
    fn a_parameter_is_unknown_that_is_hardly_better_known_than_before() {
        let found = |parameter: Parameter, sigma: f64| FoundParameter { parameter, value: 0.0, sigma };
        let zero = || Parameter::new("joint 2 zero", Unit::Radian).within(1e-2);
        let base = || Parameter::new("arm base x", Unit::Metre);
        assert!(!is_unknown(&found(zero(), 4e-3)) && is_unknown(&found(zero(), 6e-3)));
        assert!(!is_unknown(&found(base(), 4e-3)) && is_unknown(&found(base(), 6e-3)));
        assert!(is_unknown(&found(base(), f64::NAN)));
    }
}
