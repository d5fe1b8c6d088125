//! Rotations of rotation vectors and back. Nearly all turns within a step are small, and for these a few terms of the
//! series give every digit without a square root or a circular function.

use mrroc::pose::AngleAxis;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// The square of an angle below which the series are exact to round-off: the terms left out are below 1e-17.
const SMALL: f64 = 4e-3;

/// The rotation by a vector, axis times angle \[rad\].
#[inline]
pub(super) fn by(turn: &Vector3<f64>) -> UnitQuaternion<f64> {
    // cos(a), sin(a) / 2a of the half angle a.
    let square = 0.25 * turn.norm_squared();
    if square > SMALL {
        return AngleAxis(*turn).rotation();
    }
    let cosine = 1.0 - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0)));
    let sine = 1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0)));
    UnitQuaternion::new_unchecked(Quaternion::from_parts(cosine, turn * (0.5 * sine)))
}

/// The vector of a rotation \[rad\], at most pi long.
#[inline]
pub(super) fn of(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    let q = rotation.quaternion();
    // 2 asin(s) / s of s, the sine of the half angle.
    let s = q.i * q.i + q.j * q.j + q.k * q.k;
    if s > SMALL || q.w < 0.0 {
        return AngleAxis::of(rotation).0;
    }
    let series =
        1.0 + s * (1.0 / 6.0 + s * (3.0 / 40.0 + s * (15.0 / 336.0 + s * (105.0 / 3456.0 + s * SIXTH))));
    q.imag() * (2.0 * series)
}

/// Of s^5 in asin(x) / x with s = x^2.
const SIXTH: f64 = 945.0 / 42_240.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_give_the_digits_of_circular_functions() {
        for k in 0..4000 {
            // Across the border between series and functions, at an angle of 0.126.
            let angle = f64::from(k) * 1e-4;
            let turn = Vector3::new(0.6, -0.48, 0.64) * angle;
            let (rotation, exact) = (by(&turn), AngleAxis(turn).rotation());
            assert!((rotation.coords - exact.coords).amax() < 3e-16, "{angle}");
            assert!((of(&exact) - turn).amax() < 2e-16 * (1.0 + angle), "{angle}");
            let turned = UnitQuaternion::new_unchecked(-exact.into_inner());
            assert!((of(&turned) - turn).amax() < 1e-15, "{angle}");
        }
    }
}
