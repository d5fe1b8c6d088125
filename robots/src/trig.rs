//! Sines and cosines of several angles at once, without branches: the processor works on all the joints together.
//!
//! `x = n pi/2 + r + t` with `pi/2` in two parts (Cody and Waite), the first of 33 bits, so that `n` times it is exact;
//! then the polynomials of fdlibm (Sun Microsystems 1993) on `|r| <= pi/4`, with the tail `t`. The error is below one unit
//! in the last place of 1; angles of a million radians or more are left to the standard library.

use core::f64::consts::FRAC_2_PI;

/// pi/2, its first 33 bits.
const HALF_PI: f64 = 1.570_796_326_734_125_6;
/// What is missing.
const HALF_PI_TAIL: f64 = 6.077_100_506_506_192e-11;
/// 1.5 * 2^52: adding it rounds to a whole number, which then stands in the last bits.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// Angles from here on have too many quarter turns for the two parts \[rad\].
const FAR: f64 = 1e6;

const SINE: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];

const COSINE: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// Sines and cosines of the angles `x` \[rad\], in pairs.
#[inline(always)]
pub(crate) fn sin_cos<const M: usize>(x: [f64; M]) -> [(f64, f64); M] {
    // Not-a-numbers are not below, either.
    if x.iter().fold(true, |near, x| near & (x.abs() < FAR)) { near_zero(x) } else { far(x) }
}

/// No branch in here: one loop over all the angles that the compiler can do two or four at a time.
#[inline(always)]
fn near_zero<const M: usize>(x: [f64; M]) -> [(f64, f64); M] {
    let [s1, s2, s3, s4, s5, s6] = SINE;
    let [c1, c2, c3, c4, c5, c6] = COSINE;
    let (mut sines, mut cosines) = ([0.0; M], [0.0; M]);
    for i in 0..M {
        let shifted = x[i] * FRAC_2_PI + ROUND;
        let (turns, quadrant) = (shifted - ROUND, shifted.to_bits());
        let head = x[i] - turns * HALF_PI;
        let missing = turns * HALF_PI_TAIL;
        let r = head - missing;
        let tail = (head - r) - missing;
        let z = r * r;
        let cube = z * r;
        let sine = s2 + z * (s3 + z * (s4 + z * (s5 + z * s6)));
        let sine = r - ((z * (0.5 * tail - cube * sine) - tail) - cube * s1);
        let cosine = z * (c1 + z * (c2 + z * (c3 + z * (c4 + z * (c5 + z * c6)))));
        let (half, one) = (0.5 * z, 1.0 - 0.5 * z);
        let cosine = one + (((1.0 - one) - half) + (z * cosine - r * tail));
        // An odd quadrant swaps them; the second and third turn the sine's sign, the first and second the cosine's.
        let odd = 0_u64.wrapping_sub(quadrant & 1);
        let (a, b) = (sine.to_bits(), cosine.to_bits());
        let swapped = (a ^ b) & odd;
        sines[i] = f64::from_bits(a ^ swapped ^ ((quadrant & 2) << 62));
        cosines[i] = f64::from_bits(b ^ swapped ^ ((quadrant.wrapping_add(1) & 2) << 62));
    }
    core::array::from_fn(|i| (sines[i], cosines[i]))
}

#[cold]
fn far<const M: usize>(x: [f64; M]) -> [(f64, f64); M] {
    x.map(f64::sin_cos)
}

#[cfg(test)]
mod tests {
    use super::sin_cos;

    /// Expected values: the C library's, which are correctly rounded but for rare last bits.
    #[test]
    fn sine_and_cosine_are_those_of_the_standard_library_to_the_last_place() {
        let mut worst = 0.0_f64;
        let mut check = |x: f64| {
            let ((s, c), (expected_s, expected_c)) = (sin_cos([x])[0], x.sin_cos());
            worst = worst.max((s - expected_s).abs()).max((c - expected_c).abs());
        };
        for k in 0..2_000_000_u32 {
            check(f64::from(k) * 1.000_1e-5 - 10.0);
            check((f64::from(k) * 0.618_033_988_749).fract() * 1.9e6 - 0.95e6);
        }
        for k in -2000..2000 {
            for off in [-1e-9, -1e-16, 0.0, 1e-16, 1e-9] {
                check(f64::from(k) * std::f64::consts::FRAC_PI_4 + off);
            }
        }
        assert!(worst <= f64::EPSILON / 2.0, "{worst:e}");
        assert_eq!(sin_cos([0.0]), [(0.0, 1.0)]);
        assert!(sin_cos([-0.0])[0].0.is_sign_negative());
        assert!(sin_cos([f64::NAN])[0].0.is_nan() && sin_cos([f64::INFINITY])[0].1.is_nan());
        assert_eq!(sin_cos([1e9, 1.0]), [1e9_f64.sin_cos(), 1.0_f64.sin_cos()]);
    }
}
