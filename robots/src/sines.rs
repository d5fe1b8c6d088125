//! Sines and cosines of several angles at once: without branches, so that the compiler computes them
//! side by side.
//!
//! Argument reduction after Cody and Waite (1980), by multiples of pi/2 in three parts; the polynomials on
//! -pi/4..pi/4 are those of Sun's fdlibm (`k_sin.c`, `k_cos.c`).
//! Results are off by less than 3e-16.

/// Largest angle that is reduced here \[rad\]; beyond it the platform's own functions serve.
const LARGEST: f64 = 1e6;

/// Adding this rounds to the nearest whole number, which then stands in the low bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// pi/2 in parts: products of the first two with whole numbers below 2^20 are exact.
#[allow(clippy::excessive_precision)]
const PARTS: [f64; 3] =
    [1.570_796_326_734_125_614_17, 6.077_100_506_303_965_976_6e-11, 2.022_266_248_795_950_631_54e-21];

/// Coefficients of `(sin r - r) / r³` in `r²`.
#[allow(clippy::excessive_precision)]
const SINE: [f64; 6] = [
    -1.666_666_666_666_663_243_48e-01,
    8.333_333_333_322_489_461_24e-03,
    -1.984_126_982_985_794_931_34e-04,
    2.755_731_370_707_006_767_89e-06,
    -2.505_076_025_340_686_341_95e-08,
    1.589_690_995_211_550_102_21e-10,
];

/// Coefficients of `(cos r - 1 + r²/2) / r⁴` in `r²`.
#[allow(clippy::excessive_precision)]
const COSINE: [f64; 6] = [
    4.166_666_666_666_660_190_37e-02,
    -1.388_888_888_887_410_957_49e-03,
    2.480_158_728_947_672_941_78e-05,
    -2.755_731_435_139_066_330_35e-07,
    2.087_572_321_298_174_827_9e-09,
    -1.135_964_755_778_819_482_65e-11,
];

/// Value of a polynomial by Horner's rule, the constant first.
#[inline(always)]
fn polynomial<const C: usize>(coefficients: &[f64; C], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Sines and cosines of the angles \[rad\]; NaN for an angle that is not finite.
#[inline(always)]
pub(crate) fn sin_cos<const L: usize>(angles: [f64; L]) -> ([f64; L], [f64; L]) {
    if angles.iter().fold(0.0_f64, |sum, angle| sum + angle.abs()) <= LARGEST {
        reduced(angles)
    } else {
        by_platform(angles)
    }
}

#[cold]
fn by_platform<const L: usize>(angles: [f64; L]) -> ([f64; L], [f64; L]) {
    (angles.map(f64::sin), angles.map(f64::cos))
}

#[inline(always)]
fn reduced<const L: usize>(angles: [f64; L]) -> ([f64; L], [f64; L]) {
    let (mut sines, mut cosines) = ([0.0; L], [0.0; L]);
    for i in 0..L {
        let rounded = angles[i] * core::f64::consts::FRAC_2_PI + ROUNDER;
        let quadrant = rounded.to_bits();
        let n = rounded - ROUNDER;
        let r = ((angles[i] - n * PARTS[0]) - n * PARTS[1]) - n * PARTS[2];
        let square = r * r;
        let sine = r + r * square * polynomial(&SINE, square);
        let cosine = 1.0 - (0.5 * square - square * square * polynomial(&COSINE, square));
        // Odd quadrants swap the two; the sign bits follow from the second bit of the quadrant.
        let odd = (quadrant & 1).wrapping_neg();
        let (s, c) = (sine.to_bits(), cosine.to_bits());
        let swap = (s ^ c) & odd;
        sines[i] = f64::from_bits(s ^ swap ^ ((quadrant & 2) << 62));
        cosines[i] = f64::from_bits(c ^ swap ^ ((quadrant.wrapping_add(1) & 2) << 62));
    }
    (sines, cosines)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::FRAC_PI_4;

    /// Angles in all quadrants, close to the multiples of pi/4, tiny, and at the ends of the range.
    fn angles() -> impl Iterator<Item = f64> {
        let near = (-40..=40)
            .flat_map(|k| [0.0, 1e-300, 1e-17, 1e-9, 1e-3, 0.3].map(|d| f64::from(k) * FRAC_PI_4 + d));
        let far = [9.9e4, -9.9e4, 2.4e5, -4.9e5, 1.1e6, -3e9, 1e300];
        near.chain(far).flat_map(|angle| [angle, -angle])
    }

    /// Expected values: the platform's libm.
    #[test]
    fn sines_and_cosines_are_those_of_libm_to_3e_16() {
        for angle in angles() {
            let (sines, cosines) = sin_cos([angle, 0.5 * angle]);
            for (i, angle) in [angle, 0.5 * angle].into_iter().enumerate() {
                assert!((sines[i] - angle.sin()).abs() < 3e-16, "{angle}: {}", sines[i] - angle.sin());
                assert!((cosines[i] - angle.cos()).abs() < 3e-16, "{angle}: {}", cosines[i] - angle.cos());
            }
        }
    }

    #[test]
    fn small_sines_keep_their_digits() {
        for angle in [1e-300, 1e-20, 1e-9, 1e-5] {
            assert_eq!(sin_cos([angle]).0[0], angle.sin());
        }
    }

    #[test]
    fn an_angle_that_is_not_finite_has_no_sine() {
        for angle in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let (sine, cosine) = sin_cos([angle]);
            assert!(sine[0].is_nan() && cosine[0].is_nan());
        }
    }
}
