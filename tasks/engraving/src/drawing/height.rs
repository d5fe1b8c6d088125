//! The height of the tool's tip along a curve piece: what makes a ramp, a helix or a plunge of it.
//!
//! A piece says where the tip is over the plate, over its parameter t in 0..=1; a [`Height`] says over the same t how
//! high it is. Linear heights are exact for lines and helices (both run evenly over t), cubic ones are Bézier curves.

/// A height over the plate's surface along a piece \[mm\]: below 0 the tip is in the material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Height {
    /// From one height to another, evenly over the piece's parameter.
    Linear {
        /// At the piece's start \[mm\].
        from: f64,
        /// At its end \[mm\].
        to: f64,
    },
    /// A cubic Bézier curve's control values \[mm\].
    Cubic([f64; 4]),
}

impl Height {
    /// One height all along \[mm\].
    #[must_use]
    pub fn level(at: f64) -> Self {
        Self::Linear { from: at, to: at }
    }

    /// The height at `t` in 0..=1 \[mm\].
    #[must_use]
    pub fn at(&self, t: f64) -> f64 {
        match *self {
            Self::Linear { from, to } => from + (to - from) * t,
            Self::Cubic([a, b, c, d]) => {
                let s = 1.0 - t;
                a * (s * s * s) + b * (3.0 * s * s * t) + c * (3.0 * s * t * t) + d * (t * t * t)
            }
        }
    }

    /// First and second derivative by `t` \[mm\].
    #[must_use]
    pub fn derivatives(&self, t: f64) -> (f64, f64) {
        match *self {
            Self::Linear { from, to } => (to - from, 0.0),
            Self::Cubic([a, b, c, d]) => {
                let s = 1.0 - t;
                let (ab, bc, cd) = (b - a, c - b, d - c);
                (
                    (ab * (s * s) + bc * (2.0 * s * t) + cd * (t * t)) * 3.0,
                    ((bc - ab) * s + (cd - bc) * t) * 6.0,
                )
            }
        }
    }

    /// An upper bound of |z''(t)| \[mm\].
    #[must_use]
    pub fn second_derivative_bound(&self) -> f64 {
        match *self {
            Self::Linear { .. } => 0.0,
            Self::Cubic([a, b, c, d]) => 6.0 * (a - 2.0 * b + c).abs().max((b - 2.0 * c + d).abs()),
        }
    }

    /// The lowest and the highest height \[mm\].
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        let inner = self.turns();
        let heights = inner.iter().chain(&[0.0, 1.0]).map(|t| self.at(*t));
        heights.fold((f64::MAX, f64::MIN), |(low, high), z| (low.min(z), high.max(z)))
    }

    /// The same heights travelled in the other direction.
    #[must_use]
    pub fn reversed(&self) -> Self {
        match *self {
            Self::Linear { from, to } => Self::Linear { from: to, to: from },
            Self::Cubic([a, b, c, d]) => Self::Cubic([d, c, b, a]),
        }
    }

    /// The part between two parameters, over 0..=1 again: the control values are the blossom's.
    #[must_use]
    pub fn part(&self, from: f64, to: f64) -> Self {
        match *self {
            Self::Linear { .. } => Self::Linear { from: self.at(from), to: self.at(to) },
            Self::Cubic(controls) => {
                let blossom = |x, y, z| blossom(controls, [x, y, z], |a, b, f| a + (b - a) * f);
                Self::Cubic([
                    blossom(from, from, from),
                    blossom(from, from, to),
                    blossom(from, to, to),
                    blossom(to, to, to),
                ])
            }
        }
    }

    /// Parameters strictly inside 0..1 at which the height passes through `level` \[mm\], in order.
    #[must_use]
    pub fn crossings(&self, level: f64) -> Vec<f64> {
        let mut ends = self.turns();
        ends.insert(0, 0.0);
        ends.push(1.0);
        let mut found = Vec::new();
        for span in ends.windows(2) {
            let (mut low, mut high) = (span[0], span[1]);
            let above = |t: f64| self.at(t) > level;
            if above(low) == above(high) {
                continue;
            }
            if let Self::Linear { from, to } = *self {
                found.push((level - from) / (to - from));
                continue;
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if above(middle) == above(low) {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            found.push(0.5 * (low + high));
        }
        found.retain(|t| *t > 0.0 && *t < 1.0);
        found
    }

    /// Parameters strictly inside 0..1 where the height turns, in order.
    fn turns(&self) -> Vec<f64> {
        let Self::Cubic([a, b, c, d]) = *self else { return Vec::new() };
        let (p, q, r) = (b - a, c - b, d - c);
        let mut turns = Vec::new();
        quadratic_roots(p - 2.0 * q + r, 2.0 * (q - p), p, &mut turns);
        turns.retain(|t| *t > 0.0 && *t < 1.0);
        turns.sort_by(f64::total_cmp);
        turns
    }
}

/// The blossom of a cubic Bézier curve at three parameters (Ramshaw 1989), with the values' own interpolation.
pub(super) fn blossom<T: Copy>(controls: [T; 4], at: [f64; 3], between: impl Fn(T, T, f64) -> T) -> T {
    let [a, b, c, d] = controls;
    let [x, y, z] = at;
    let (p, q, r) = (between(a, b, x), between(b, c, x), between(c, d, x));
    let (p, q) = (between(p, q, y), between(q, r, y));
    between(p, q, z)
}

/// Real roots of `a t² + b t + c`.
pub(super) fn quadratic_roots(a: f64, b: f64, c: f64, into: &mut Vec<f64>) {
    if a.abs() < 1e-12 * (b.abs() + c.abs()) {
        if b != 0.0 {
            into.push(-c / b);
        }
        return;
    }
    let discriminant = b * b - 4.0 * a * c;
    if discriminant >= 0.0 {
        let q = -0.5 * (b + discriminant.sqrt().copysign(b));
        into.push(q / a);
        if q != 0.0 {
            into.push(c / q);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_a_cubic_is_the_same_curve() {
        let height = Height::Cubic([1.0, -3.0, 2.0, -1.0]);
        let part = height.part(0.2, 0.7);
        for k in 0..=10 {
            let t = f64::from(k) / 10.0;
            assert!((part.at(t) - height.at(0.2 + 0.5 * t)).abs() < 1e-12);
        }
    }

    #[test]
    fn crossings_are_where_the_surface_is_passed() {
        assert_eq!(Height::Linear { from: 1.0, to: -3.0 }.crossings(0.0), [0.25]);
        assert!(Height::Linear { from: -1.0, to: -3.0 }.crossings(0.0).is_empty());
        // 8 (t - 1/4)(t - 1/2)(t - 3/4) has the Bernstein values -3/4, 13/12, -13/12, 3/4.
        let height = Height::Cubic([-0.75, 13.0 / 12.0, -13.0 / 12.0, 0.75]);
        let found = height.crossings(0.0);
        assert_eq!(found.len(), 3);
        for (t, expected) in found.iter().zip([0.25, 0.5, 0.75]) {
            assert!((t - expected).abs() < 1e-12, "{found:?}");
        }
        let (low, high) = height.range();
        assert!((low + 0.75).abs() < 1e-12 && (high - 0.75).abs() < 1e-12);
    }

    #[test]
    fn a_reversed_height_ends_where_it_began() {
        let height = Height::Cubic([0.0, -1.0, 4.0, 2.0]);
        assert_eq!(height.reversed().at(0.0), 2.0);
        assert!((height.reversed().at(0.3) - height.at(0.7)).abs() < 1e-12);
        assert!((height.reversed().derivatives(0.3).0 + height.derivatives(0.7).0).abs() < 1e-12);
    }
}
