//! Eight numbers at once: one for each of eight postures that are checked together.
//!
//! Plain arrays, whose loops the compiler turns into vector instructions of the processor that the caller is compiled for
//! ([`vectorised`](crate::check) picks it at run time). Products and sums are never contracted, so every processor gives the same
//! numbers, to the bit.

use core::ops::{Add, Mul, Neg, Sub};

/// How many.
pub(crate) const LANES: usize = 8;

/// Which lanes: bit `i` for the `i`th.
pub(crate) type Mask = u8;

/// All lanes.
pub(crate) const ALL: Mask = Mask::MAX;

/// Eight single-precision numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(32))]
pub(crate) struct Lanes(pub(crate) [f32; LANES]);

impl Lanes {
    #[inline(always)]
    pub(crate) const fn splat(x: f32) -> Self {
        Lanes([x; LANES])
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f32) -> f32) -> Self {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            out[i] = f(self.0[i]);
        }
        Lanes(out)
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            out[i] = f(self.0[i], other.0[i]);
        }
        Lanes(out)
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        self.map(f32::sqrt)
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        self.map(f32::abs)
    }

    /// The larger one; where one is no number, the other.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    /// The smaller one; where one is no number, the other.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    /// The lanes that are above the other's; none that is no number.
    #[inline(always)]
    pub(crate) fn above(self, other: Self) -> Mask {
        let mut mask = 0;
        for i in 0..LANES {
            mask |= Mask::from(self.0[i] > other.0[i]) << i;
        }
        mask
    }

    /// Sines and cosines of angles up to some thousand radians, to 2e-7 within one turn.
    #[inline(always)]
    pub(crate) fn sin_cos(self) -> (Self, Self) {
        // Cody and Waite: to the nearest quarter turn, which is taken away in three parts; then polynomials (Cephes, sinf and cosf).
        let quarters = self.map(|x| (x * core::f32::consts::FRAC_2_PI).round_ties_even());
        let x = self.zip(quarters, |x, k| ((x - k * 1.570_312_5) - k * 4.837_513e-4) - k * 7.549_79e-8);
        let z = x * x;
        let sine = z.map(|z| (-1.951_529_6e-4 * z + 8.332_161e-3) * z - 1.666_665_5e-1) * z * x + x;
        let cosine = z.map(|z| {
            ((2.443_315_7e-5 * z - 1.388_731_6e-3) * z + 4.166_664_6e-2) * z * z - 0.5 * z + 1.0
        });
        let (mut s, mut c) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let k = quarters.0[i] as i32;
            let (a, b) = if k & 1 == 0 { (sine.0[i], cosine.0[i]) } else { (cosine.0[i], sine.0[i]) };
            s[i] = if k & 2 == 0 { a } else { -a };
            c[i] = if (k + 1) & 2 == 0 { b } else { -b };
        }
        (Lanes(s), Lanes(c))
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Mul<f32> for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f32) -> Self {
        self.map(|a| a * factor)
    }
}

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

/// Points or directions \[m\], one for each lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Points(pub(crate) [Lanes; 3]);

impl Points {
    #[inline(always)]
    pub(crate) fn splat(p: [f32; 3]) -> Self {
        Points(p.map(Lanes::splat))
    }

    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> Lanes {
        self.0[0] * other.0[0] + self.0[1] * other.0[1] + self.0[2] * other.0[2]
    }

    #[inline(always)]
    pub(crate) fn cross(self, other: Self) -> Self {
        let [a, b] = [self.0, other.0];
        Points([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    }

    #[inline(always)]
    pub(crate) fn squared(self) -> Lanes {
        self.dot(self)
    }
}

impl Add for Points {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Points([self.0[0] + other.0[0], self.0[1] + other.0[1], self.0[2] + other.0[2]])
    }
}

impl Sub for Points {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Points([self.0[0] - other.0[0], self.0[1] - other.0[1], self.0[2] - other.0[2]])
    }
}

impl Mul<Lanes> for Points {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: Lanes) -> Self {
        Points(self.0.map(|x| x * factor))
    }
}

/// A frame of each lane: its axes and its origin, seen from the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Frames {
    pub(crate) x: Points,
    pub(crate) y: Points,
    pub(crate) z: Points,
    pub(crate) origin: Points,
}

impl Frames {
    /// The world in all lanes.
    #[inline(always)]
    pub(crate) fn world() -> Self {
        Frames {
            x: Points::splat([1.0, 0.0, 0.0]),
            y: Points::splat([0.0, 1.0, 0.0]),
            z: Points::splat([0.0, 0.0, 1.0]),
            origin: Points::default(),
        }
    }

    /// Where a point of the frame is in the world.
    #[inline(always)]
    pub(crate) fn place(&self, p: [f32; 3]) -> Points {
        self.origin + self.direction(p)
    }

    #[inline(always)]
    pub(crate) fn direction(&self, v: [f32; 3]) -> Points {
        let [x, y, z] = v.map(Lanes::splat);
        self.x * x + self.y * y + self.z * z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sines_and_cosines_are_those_of_double_precision(angle in -12.6_f32..12.6) {
            let (s, c) = Lanes::splat(angle).sin_cos();
            prop_assert!((f64::from(s.0[3]) - f64::from(angle).sin()).abs() < 4e-7);
            prop_assert!((f64::from(c.0[3]) - f64::from(angle).cos()).abs() < 4e-7);
        }
    }

    #[test]
    fn a_lane_that_is_no_number_is_above_nothing() {
        let mut lanes = Lanes::splat(1.0);
        lanes.0[2] = f32::NAN;
        assert_eq!(lanes.above(Lanes::splat(0.0)), 0b1111_1011);
    }
}
