//! Sines, cosines and arc tangents of several angles at once: without branches, so that the compiler computes them
//! side by side.
//!
//! Argument reduction after Cody and Waite (1980), by multiples of pi/2 in three parts; the polynomials on
//! -pi/4..pi/4 and for the arc tangent below 7/16 are those of Sun's fdlibm (`k_sin.c`, `k_cos.c`, `s_atan.c`).
//!
//! **Accuracy.** Sines and cosines of angles up to [`LARGEST`] are off by less than 2.3e-16, those of small angles by less
//! than the last place; arc tangents by less than 5e-16. Where one angle of a call is beyond [`LARGEST`] (joints that turn
//! without end come there after 159 000 turns), the platform's own functions serve for all of them: slower, as accurate.
//! An odd number of angles costs as much as the next even one.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Largest angle that is reduced here \[rad\]: its quarter turns are fewer than 2^20.
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

/// Coefficients of `(t - atan t) / t³` in `t²`, of even powers ..
#[allow(clippy::excessive_precision)]
const EVEN: [f64; 6] = [
    3.333_333_333_333_293_180_27e-01,
    1.428_571_427_250_346_637_11e-01,
    9.090_887_133_436_506_561_96e-02,
    6.661_073_137_387_531_206_69e-02,
    4.976_877_994_615_932_360_17e-02,
    1.628_582_011_536_578_236_23e-02,
];

/// .. and of odd ones.
#[allow(clippy::excessive_precision)]
const ODD: [f64; 6] = [
    -1.999_999_999_987_648_324_76e-01,
    -1.111_111_040_546_235_578_8e-01,
    -7.691_876_205_044_829_994_95e-02,
    -5.833_570_133_790_573_486_45e-02,
    -3.653_157_274_421_691_552_7e-02,
    0.0,
];

/// tan(pi/8): above this ratio the arc tangent is taken from pi/4.
const EIGHTH: f64 = core::f64::consts::SQRT_2 - 1.0;

/// Value of a polynomial, the constant first: pairs of terms apart from each other (Estrin 1960), which shortens the chain
/// of sums that wait for each other.
#[inline(always)]
fn polynomial([c0, c1, c2, c3, c4, c5]: &[f64; 6], x: f64) -> f64 {
    let square = x * x;
    (c0 + x * c1) + square * ((c2 + x * c3) + square * (c4 + x * c5))
}

/// Sine and cosine of each of the angles \[rad\]; NaN for an angle that is not finite.
#[inline(always)]
pub(crate) fn sin_cos<const L: usize>(angles: [f64; L]) -> [(f64, f64); L] {
    // Not-a-numbers are not small, either.
    let small = angles.iter().fold(true, |small, angle| small & (angle.abs() <= LARGEST));
    if small { reduced(angles) } else { angles.map(by_platform) }
}

/// By value, not as an array: an array that is handed on would be written to memory in the common case, too.
#[cold]
#[inline(never)]
fn by_platform(angle: f64) -> (f64, f64) {
    angle.sin_cos()
}

#[inline(always)]
fn reduced<const L: usize>(angles: [f64; L]) -> [(f64, f64); L] {
    // Two arrays: the compiler then fills each two or four entries at a time.
    let mut sines = [0.0; L];
    let mut cosines = [0.0; L];
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
    core::array::from_fn(|i| (sines[i], cosines[i]))
}

/// The angles \[rad\] of the directions (x, y), -pi to pi; 0 or pi where both are zero.
#[inline(always)]
pub(crate) fn atan2<const L: usize>(y: [f64; L], x: [f64; L]) -> [f64; L] {
    let mut angles = [0.0; L];
    for i in 0..L {
        let (across, along) = (y[i].abs(), x[i].abs());
        let steep = across > along;
        let (low, high) = if steep { (along, across) } else { (across, along) };
        let wide = low > EIGHTH * high;
        let (numerator, denominator) = if wide { (low - high, low + high) } else { (low, high) };
        let ratio = numerator / if denominator == 0.0 { 1.0 } else { denominator };
        // Even and odd terms apart: two short chains instead of a long one.
        let square = ratio * ratio;
        let fourth = square * square;
        let sum = polynomial(&EVEN, fourth) + square * polynomial(&ODD, fourth);
        let arc = ratio - ratio * square * sum;
        let arc = if wide { FRAC_PI_4 + arc } else { arc };
        let arc = if steep { FRAC_PI_2 - arc } else { arc };
        let arc = if x[i] < 0.0 { PI - arc } else { arc };
        angles[i] = arc.copysign(y[i]);
    }
    angles
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Angles in all quadrants, close to the multiples of pi/4, tiny, and at the ends of the range.
    fn angles() -> impl Iterator<Item = f64> {
        let near = (-40..=40)
            .flat_map(|k| [0.0, 1e-300, 1e-17, 1e-9, 1e-3, 0.3].map(|d| f64::from(k) * FRAC_PI_4 + d));
        let far = [9.9e4, -9.9e4, 2.4e5, -4.9e5, 1e6, 1.1e6, -3e9, 1e300];
        near.chain(far).flat_map(|angle| [angle, -angle])
    }

    /// Largest error of a sine and a cosine against the platform's libm, which rounds correctly but for rare last bits.
    fn error_at(angle: f64) -> f64 {
        let [first, (s, c)] = sin_cos([0.5 * angle, angle]);
        assert_eq!(sin_cos([0.5 * angle]), [first], "the neighbours do not matter");
        (s - angle.sin()).abs().max((c - angle.cos()).abs())
    }

    #[test]
    fn sines_and_cosines_are_those_of_libm_to_2_3e_16_over_the_whole_range() {
        let dense = (0..1_000_000_u32).map(|k| f64::from(k) * 2.000_1e-5 - 10.0);
        let wide = (0..1_000_000_u32).map(|k| (f64::from(k) * 0.618_033_988_749).fract() * 2e6 - 1e6);
        // Next to the ends of the quadrants, where r is nearly 0, or pi/4, and cancellation is greatest.
        let edges = (-600_000..600_000).map(|k| f64::from(k) * FRAC_PI_4);
        let worst = dense.chain(wide).chain(edges).chain(angles()).map(error_at).fold(0.0, f64::max);
        println!("largest error {worst:.2e}");
        assert!(worst < 2.3e-16, "{worst:e}");
    }

    #[test]
    fn beyond_the_range_the_platform_serves_for_all_angles_of_the_call() {
        assert_eq!(sin_cos([1e9, 1.0]), [1e9_f64.sin_cos(), 1.0_f64.sin_cos()]);
        assert_eq!(sin_cos([-1.000_001e6]), [(-1.000_001e6_f64).sin_cos()]);
    }

    #[test]
    fn small_sines_keep_their_digits() {
        for angle in [1e-300, 1e-20, 1e-9, 1e-5] {
            assert_eq!(sin_cos([angle])[0].0, angle.sin());
        }
        assert_eq!(sin_cos([0.0]), [(0.0, 1.0)]);
    }

    #[test]
    fn an_angle_that_is_not_finite_has_no_sine() {
        for angle in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let [(sine, cosine)] = sin_cos([angle]);
            assert!(sine.is_nan() && cosine.is_nan());
        }
    }

    /// Expected values: the platform's libm.
    #[test]
    fn arc_tangents_are_those_of_libm_to_5e_16() {
        for angle in angles() {
            let (y, x) = angle.sin_cos();
            for scale in [1.0, 1e-8, 1e-170, 1e100] {
                let error = atan2([scale * y], [scale * x])[0] - (scale * y).atan2(scale * x);
                assert!(error.abs() < 5e-16, "{angle} {scale}: {error}");
            }
        }
        for (y, x) in [(0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 0.0), (1.0, 1.0), (-2.0, -2.0)]
        {
            assert!((atan2([y], [x])[0] - y.atan2(x)).abs() < 5e-16, "{y} {x}");
        }
        assert!(atan2([f64::NAN], [1.0])[0].is_nan());
        assert!(atan2([1.0], [f64::NAN])[0].is_nan());
    }
}
