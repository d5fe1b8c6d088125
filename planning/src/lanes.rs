//! Eight numbers at once: one for each of eight postures that are checked together.
//!
//! By `wide`: two vectors of four where a program is compiled for any processor, one of eight where it is compiled for those with AVX.

use core::ops::{Add, Mul, Neg, Sub};

use wide::f32x8;

/// How many.
pub(crate) const LANES: usize = 8;

/// Which lanes: bit `i` for the `i`th.
pub(crate) type Mask = u8;

/// All lanes.
pub(crate) const ALL: Mask = Mask::MAX;

/// Eight single-precision numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Lanes(f32x8);

impl Lanes {
    #[inline]
    pub(crate) fn splat(x: f32) -> Self {
        Lanes(f32x8::splat(x))
    }

    #[inline]
    pub(crate) fn new(lanes: [f32; LANES]) -> Self {
        Lanes(f32x8::new(lanes))
    }

    #[inline]
    pub(crate) fn array(self) -> [f32; LANES] {
        self.0.to_array()
    }

    #[inline]
    pub(crate) fn lane(&self, lane: usize) -> f32 {
        self.0.as_array()[lane]
    }

    #[inline]
    pub(crate) fn set(&mut self, lane: usize, x: f32) {
        self.0.as_mut_array()[lane] = x;
    }

    #[inline]
    pub(crate) fn sqrt(self) -> Self {
        Lanes(self.0.sqrt())
    }

    #[inline]
    pub(crate) fn abs(self) -> Self {
        Lanes(self.0.abs())
    }

    /// The larger one; `other` where one of them is no number.
    #[inline]
    pub(crate) fn max(self, other: Self) -> Self {
        Lanes(self.0.fast_max(other.0))
    }

    /// The smaller one; `other` where one of them is no number.
    #[inline]
    pub(crate) fn min(self, other: Self) -> Self {
        Lanes(self.0.fast_min(other.0))
    }

    /// The lanes that are above the other's; none that is no number.
    #[inline]
    pub(crate) fn above(self, other: Self) -> Mask {
        self.0.simd_gt(other.0).to_bitmask() as Mask
    }

    /// Sines and cosines of angles of some turns, to 4e-7 within two turns.
    #[inline]
    pub(crate) fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.0.sin_cos();
        (Lanes(s), Lanes(c))
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Lanes(self.0 + other.0)
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Lanes(self.0 - other.0)
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        Lanes(self.0 * other.0)
    }
}

impl Mul<f32> for Lanes {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f32) -> Self {
        Lanes(self.0 * f32x8::splat(factor))
    }
}

impl Neg for Lanes {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Lanes(-self.0)
    }
}

/// Points or directions \[m\], one for each lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Points(pub(crate) [Lanes; 3]);

impl Points {
    #[inline]
    pub(crate) fn splat(p: [f32; 3]) -> Self {
        Points([Lanes::splat(p[0]), Lanes::splat(p[1]), Lanes::splat(p[2])])
    }

    #[inline]
    pub(crate) fn dot(self, other: Self) -> Lanes {
        self.0[0] * other.0[0] + self.0[1] * other.0[1] + self.0[2] * other.0[2]
    }

    #[inline]
    pub(crate) fn cross(self, other: Self) -> Self {
        let [a, b] = [self.0, other.0];
        Points([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    }

    #[inline]
    pub(crate) fn squared(self) -> Lanes {
        self.dot(self)
    }
}

impl Add for Points {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Points([self.0[0] + other.0[0], self.0[1] + other.0[1], self.0[2] + other.0[2]])
    }
}

impl Sub for Points {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Points([self.0[0] - other.0[0], self.0[1] - other.0[1], self.0[2] - other.0[2]])
    }
}

impl Mul<Lanes> for Points {
    type Output = Self;
    #[inline]
    fn mul(self, factor: Lanes) -> Self {
        Points([self.0[0] * factor, self.0[1] * factor, self.0[2] * factor])
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
    #[inline]
    pub(crate) fn world() -> Self {
        Frames {
            x: Points::splat([1.0, 0.0, 0.0]),
            y: Points::splat([0.0, 1.0, 0.0]),
            z: Points::splat([0.0, 0.0, 1.0]),
            origin: Points::default(),
        }
    }

    /// Where a point of the frame is in the world.
    #[inline]
    pub(crate) fn place(&self, p: [f32; 3]) -> Points {
        self.origin + self.direction(p)
    }

    /// This frame as seen from another one.
    #[inline]
    pub(crate) fn relative_to(&self, other: &Frames) -> Self {
        let turned = |v: Points| Points([other.x.dot(v), other.y.dot(v), other.z.dot(v)]);
        Frames {
            x: turned(self.x),
            y: turned(self.y),
            z: turned(self.z),
            origin: turned(self.origin - other.origin),
        }
    }

    #[inline]
    pub(crate) fn direction(&self, v: [f32; 3]) -> Points {
        self.x * Lanes::splat(v[0]) + self.y * Lanes::splat(v[1]) + self.z * Lanes::splat(v[2])
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
            prop_assert!((f64::from(s.lane(3)) - f64::from(angle).sin()).abs() < 4e-7);
            prop_assert!((f64::from(c.lane(3)) - f64::from(angle).cos()).abs() < 4e-7);
        }
    }

    #[test]
    fn a_lane_that_is_no_number_is_above_nothing() {
        let mut lanes = Lanes::splat(1.0);
        lanes.set(2, f32::NAN);
        assert_eq!(lanes.above(Lanes::splat(0.0)), 0b1111_1011);
    }
}
