//! Rational Bézier curves of any degree: what one span of a NURBS is.

use super::{Affine, Vec2};

/// A rational Bézier curve: `P(t) = Σ B_i(t) w_i p_i / Σ B_i(t) w_i`.
#[derive(Clone, Debug, PartialEq)]
pub struct RationalBezier {
    /// Control points \[mm\] with their weights, > 0; at least two.
    controls: Box<[(Vec2, f64)]>,
}

impl RationalBezier {
    /// A curve over at least two control points with positive weights; `None` otherwise.
    #[must_use]
    pub fn new(controls: Vec<(Vec2, f64)>) -> Option<Self> {
        let sound = controls.len() >= 2 && controls.iter().all(|(_, w)| w.is_finite() && *w > 0.0);
        sound.then(|| Self { controls: controls.into() })
    }

    /// The control points with their weights.
    #[must_use]
    pub fn controls(&self) -> &[(Vec2, f64)] {
        &self.controls
    }

    /// The point \[mm\], and the first and second derivatives \[mm\], at `t` in 0..=1.
    #[must_use]
    pub fn evaluate(&self, t: f64) -> (Vec2, Vec2, Vec2) {
        // Homogeneous sums and their two derivatives by Horner-like Bernstein recursion on all three at once.
        let n = self.controls.len() - 1;
        let degree = n as f64;
        let mut value = [(Vec2::zeros(), 0.0); 3];
        let s = 1.0 - t;
        for (order, slot) in value.iter_mut().enumerate() {
            if order > n {
                continue;
            }
            let m = n - order;
            let mut sum = (Vec2::zeros(), 0.0);
            for i in 0..=m {
                let basis = bernstein(m, i, s, t);
                let (p, w) = self.difference(order, i);
                sum.0 += p * basis;
                sum.1 += w * basis;
            }
            let factor = match order {
                0 => 1.0,
                1 => degree,
                _ => degree * (degree - 1.0),
            };
            *slot = (sum.0 * factor, sum.1 * factor);
        }
        let [(a, w), (a1, w1), (a2, w2)] = value;
        let p = a / w;
        let d1 = (a1 - p * w1) / w;
        let d2 = (a2 - d1 * (2.0 * w1) - p * w2) / w;
        (p, d1, d2)
    }

    /// Forward difference of the homogeneous controls.
    fn difference(&self, order: usize, i: usize) -> (Vec2, f64) {
        let h = |k: usize| {
            let (p, w) = self.controls[k];
            (p * w, w)
        };
        match order {
            0 => h(i),
            1 => {
                let (a, b) = (h(i), h(i + 1));
                (b.0 - a.0, b.1 - a.1)
            }
            _ => {
                let (a, b, c) = (h(i), h(i + 1), h(i + 2));
                (c.0 - b.0 * 2.0 + a.0, c.1 - 2.0 * b.1 + a.1)
            }
        }
    }

    /// The same curve travelled in the other direction.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self { controls: self.controls.iter().rev().copied().collect() }
    }

    /// The curve's image.
    #[must_use]
    pub fn transformed(&self, map: &Affine) -> Self {
        Self { controls: self.controls.iter().map(|(p, w)| (map.point(*p), *w)).collect() }
    }
}

/// The Bernstein polynomial `C(n, i) s^(n-i) t^i`.
fn bernstein(n: usize, i: usize, s: f64, t: f64) -> f64 {
    let mut choose = 1.0;
    for k in 0..i {
        choose = choose * (n - k) as f64 / (k + 1) as f64;
    }
    choose * s.powi((n - i) as i32) * t.powi(i as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rational_quadratic_is_a_quarter_circle() {
        let w = 0.5f64.sqrt();
        let curve = RationalBezier::new(vec![
            (Vec2::new(1.0, 0.0), 1.0),
            (Vec2::new(1.0, 1.0), w),
            (Vec2::new(0.0, 1.0), 1.0),
        ])
        .unwrap();
        for k in 0..=10 {
            let t = f64::from(k) / 10.0;
            let (p, d, dd) = curve.evaluate(t);
            assert!((p.norm() - 1.0).abs() < 1e-14);
            assert!(p.dot(&d).abs() < 1e-13);
            // |p|² = 1 derived twice: d·d + p·dd = 0.
            assert!((d.norm_squared() + p.dot(&dd)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_weight_of_zero_is_no_curve() {
        assert!(RationalBezier::new(vec![(Vec2::zeros(), 1.0), (Vec2::zeros(), 0.0)]).is_none());
    }
}
