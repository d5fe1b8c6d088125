//! Sine and cosine of an angle at once, in line with what surrounds them and without a branch: what a step on a circle costs.
//!
//! With `n` the nearest multiple of pi / 2, `r = x - n pi / 2` is formed with pi / 2 in two parts (Cody and Waite 1980), and
//! the polynomials on `|r| <= pi / 4` are those of fdlibm's `__kernel_sin` and `__kernel_cos` (Sun Microsystems 1993), whose
//! error is below 2^-58.

/// `pi / 2` as a sum: the first has 33 bits, so that its product with `n` is exact.
const HALF_PI: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];
const SIN: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_007e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];
const COS: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];
/// Added and taken away again, this leaves the nearest whole number.
const WHOLE: f64 = 6_755_399_441_055_744.0;
/// Angles up to which two parts of pi / 2 are enough \[rad\].
const FARTHEST: f64 = 1e5;

/// `(sin x, cos x)` to 2.3e-16, `x` in rad.
#[inline]
pub(super) fn sin_cos(x: f64) -> (f64, f64) {
    if x.abs() > FARTHEST || x.is_nan() {
        return x.sin_cos();
    }
    let shifted = x * core::f64::consts::FRAC_2_PI + WHOLE;
    let n = shifted - WHOLE;
    let quadrant = shifted.to_bits();
    let r = (x - n * HALF_PI[0]) - n * HALF_PI[1];
    let z = r * r;
    let zz = z * z;
    let polynomial = |c: &[f64; 6]| (c[0] + c[1] * z) + zz * ((c[2] + c[3] * z) + zz * (c[4] + c[5] * z));
    let sin = r + r * z * polynomial(&SIN);
    let cos = (1.0 - 0.5 * z) + zz * polynomial(&COS);
    let (s, c) = if quadrant & 1 == 0 { (sin, cos) } else { (cos, sin) };
    let sign = |negative: u64, x: f64| f64::from_bits(x.to_bits() ^ (negative << 63));
    (sign(quadrant >> 1 & 1, s), sign((quadrant + 1) >> 1 & 1, c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn multiples_of_a_quarter_turn_and_what_is_no_angle_are_as_they_should() {
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        assert_eq!(sin_cos(1e300), 1e300_f64.sin_cos());
        assert!(sin_cos(f64::NAN).0.is_nan() && sin_cos(f64::INFINITY).1.is_nan());
        for n in -8..=8 {
            let x = f64::from(n) * std::f64::consts::FRAC_PI_2;
            let (sin, cos) = sin_cos(x);
            assert!((sin - x.sin()).abs() < 1e-16 && (cos - x.cos()).abs() < 1e-16, "{n}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn it_agrees_with_the_mathematical_library(x in prop_oneof![-7.0..7.0f64, -1e5..1e5f64, -1e-8..1e-8f64]) {
            let (sin, cos) = sin_cos(x);
            prop_assert!((sin - x.sin()).abs() < 2.3e-16 && (cos - x.cos()).abs() < 2.3e-16, "{} {}", sin, cos);
        }
    }
}
