//! NURBS as files give them, split into one Bézier curve per knot span by their blossom (Ramshaw 1989: the Bézier
//! points of a span from `a` to `b` are the blossom at `a` p - j times and `b` j times): exact, and a kink at a
//! repeated knot becomes a join that the sampler sees.

use super::{Piece, RationalBezier, Vec2};

/// The highest degree that is read: CAD files use 2 to 5.
const HIGHEST_DEGREE: usize = 11;

/// A non-uniform rational B-spline.
#[derive(Clone, Debug)]
pub struct PlanarNurbs {
    /// Degree, 1..=11.
    pub degree: usize,
    /// Knots, not decreasing, as many as control points + degree + 1.
    pub knots: Vec<f64>,
    /// Control points \[mm\] with weights > 0.
    pub controls: Vec<(Vec2, f64)>,
}

impl PlanarNurbs {
    /// The curve over open uniform knots 0..0, 1, 2, .. k..k, as LinuxCNC's G5.2 means it.
    #[must_use]
    pub fn open_uniform(degree: usize, controls: Vec<(Vec2, f64)>) -> Self {
        let spans = controls.len().saturating_sub(degree);
        let knots =
            (0..controls.len() + degree + 1).map(|i| i.saturating_sub(degree).min(spans) as f64).collect();
        Self { degree, knots, controls }
    }

    /// The exact Bézier pieces, in order.
    ///
    /// # Errors
    /// A sentence that says what is wrong with degree, knots, weights or numbers of them.
    pub fn pieces(&self) -> Result<Vec<Piece>, String> {
        self.check()?;
        let (p, n) = (self.degree, self.controls.len());
        let spans = (p..n).filter(|i| self.knots[*i] < self.knots[i + 1]);
        Ok(spans.filter_map(|i| bezier_piece((0..=p).map(|j| self.blossom(i, j)).collect())).collect())
    }

    /// The j-th Bézier point of the span from knot i, by de Boor's recursion in homogeneous coordinates.
    fn blossom(&self, i: usize, j: usize) -> (Vec2, f64) {
        let p = self.degree;
        let (a, b) = (self.knots[i], self.knots[i + 1]);
        let mut d: Vec<(Vec2, f64)> = self.controls[i - p..=i].iter().map(|(q, w)| (q * *w, *w)).collect();
        for r in 1..=p {
            let argument = if r <= j { b } else { a };
            for l in (r..=p).rev() {
                let (low, high) = (self.knots[i - p + l], self.knots[i + l + 1 - r]);
                let f = (argument - low) / (high - low);
                d[l] = (d[l - 1].0 * (1.0 - f) + d[l].0 * f, d[l - 1].1 * (1.0 - f) + d[l].1 * f);
            }
        }
        let (q, w) = d[p];
        (q / w, w)
    }

    fn check(&self) -> Result<(), String> {
        let (p, n, k) = (self.degree, self.controls.len(), self.knots.len());
        if !(1..=HIGHEST_DEGREE).contains(&p) {
            return Err(format!("a spline of degree {p}; degrees 1 to {HIGHEST_DEGREE} can be engraved"));
        }
        if n < p + 1 {
            return Err(format!(
                "a spline of degree {p} with {n} control points; it needs {} or more",
                p + 1
            ));
        }
        if k != n + p + 1 {
            return Err(format!(
                "a spline with {k} knots; {n} control points of degree {p} need {}",
                n + p + 1
            ));
        }
        if self.knots.windows(2).any(|w| !w[0].is_finite() || !w[1].is_finite() || w[1] < w[0]) {
            return Err("a spline whose knots decrease or are not finite".to_owned());
        }
        if self.knots[n] <= self.knots[p] {
            return Err("a spline whose knots are all equal".to_owned());
        }
        if self.controls.iter().any(|(_, w)| !w.is_finite() || *w < 1e-9) {
            return Err("a spline with a weight that is not positive".to_owned());
        }
        Ok(())
    }
}

/// A polynomial cubic where the weights allow it, a rational curve otherwise.
fn bezier_piece(controls: Vec<(Vec2, f64)>) -> Option<Piece> {
    let even = controls.iter().all(|(_, w)| (w - controls[0].1).abs() < 1e-12 * w.abs());
    match controls[..] {
        [(a, _), (b, _)] => Some(Piece::Line { from: a, to: b }),
        [(a, _), (b, _), (c, _)] if even => Some(Piece::quadratic(a, b, c)),
        [(a, _), (b, _), (c, _), (d, _)] if even => Some(Piece::Cubic([a, b, c, d])),
        _ => RationalBezier::new(controls).map(Piece::Rational),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// De Boor's recursion straight from the definition: an oracle that shares no code with the blossom.
    fn basis(knots: &[f64], i: usize, p: usize, u: f64) -> f64 {
        if p == 0 {
            return f64::from(u8::from(knots[i] <= u && u < knots[i + 1]));
        }
        let part = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        part(u - knots[i], knots[i + p] - knots[i]) * basis(knots, i, p - 1, u)
            + part(knots[i + p + 1] - u, knots[i + p + 1] - knots[i + 1]) * basis(knots, i + 1, p - 1, u)
    }

    fn agrees(curve: &PlanarNurbs) {
        let p = curve.degree;
        let pieces = curve.pieces().unwrap();
        let mut spans: Vec<f64> = curve.knots[p..=curve.controls.len()].to_vec();
        spans.dedup();
        assert_eq!(pieces.len(), spans.len() - 1);
        for (piece, span) in pieces.iter().zip(spans.windows(2)) {
            for k in 0..10 {
                let t = f64::from(k) / 10.0;
                let u = span[0] + (span[1] - span[0]) * t;
                let (mut sum, mut weight) = (Vec2::zeros(), 0.0);
                for (i, (point, w)) in curve.controls.iter().enumerate() {
                    let b = basis(&curve.knots, i, p, u) * w;
                    sum += point * b;
                    weight += b;
                }
                assert!((piece.point(t) - sum / weight).norm() < 1e-10, "degree {p}, u = {u}");
            }
        }
    }

    fn points(n: usize) -> Vec<(Vec2, f64)> {
        (0..n)
            .map(|i| {
                let a = i as f64;
                (Vec2::new(a, (a * 1.7).sin() * 3.0), 1.0 + 0.5 * (a * 0.9).cos())
            })
            .collect()
    }

    #[test]
    fn bezier_pieces_follow_the_definition() {
        // Degree 1 with weights is the same line at another parameter: not compared point by point.
        for degree in 2..=5 {
            agrees(&PlanarNurbs::open_uniform(degree, points(9)));
        }
    }

    #[test]
    fn unclamped_and_repeated_knots_follow_the_definition() {
        agrees(&PlanarNurbs { degree: 3, knots: (0..12).map(f64::from).collect(), controls: points(8) });
        let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 3.5, 4.0, 4.0, 4.0, 4.0];
        agrees(&PlanarNurbs { degree: 3, knots, controls: points(9) });
        let knots = vec![0.0, 0.5, 1.0, 1.0, 1.0, 2.0, 3.0, 4.0, 4.0];
        agrees(&PlanarNurbs { degree: 2, knots, controls: points(6) });
    }

    #[test]
    fn bad_splines_are_refused_in_words() {
        let mut curve = PlanarNurbs::open_uniform(3, points(3));
        assert!(curve.pieces().unwrap_err().contains("needs 4 or more"));
        curve = PlanarNurbs::open_uniform(3, points(6));
        curve.knots.pop();
        assert!(curve.pieces().unwrap_err().contains("need 10"));
        curve = PlanarNurbs::open_uniform(3, points(6));
        curve.knots[5] = 0.1;
        assert!(curve.pieces().unwrap_err().contains("decrease"));
    }
}
