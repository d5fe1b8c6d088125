//! Polylines that stay within a tolerance of the exact curves, and the boxes that need them.

use super::stroke::with_height;
use super::{Bounds, Height, Piece, Stroke, Vec2, Vec3};

/// The most chords of one piece: at 0.2 µm a circle of 10 m radius needs fewer.
const MOST_CHORDS: f64 = 50_000.0;

impl Piece {
    /// Calls `each` with the parameter and point of every vertex after the start, so that no chord is further from
    /// the curve than `tolerance` \[mm\], > 0.
    ///
    /// Arcs and cubics by the bound `|P''| h² / 8` on the chord's deviation, rational pieces by halving.
    pub fn flatten(&self, tolerance: f64, each: &mut impl FnMut(f64, Vec2)) {
        self.flatten_at(&Height::level(0.0), tolerance, each);
    }

    /// As [`flatten`](Self::flatten), and no chord is further from the tip's path at these heights.
    fn flatten_at(&self, height: &Height, tolerance: f64, each: &mut impl FnMut(f64, Vec2)) {
        let bend = height.second_derivative_bound();
        let bound = match self {
            Self::Line { to, .. } if bend == 0.0 => return each(1.0, *to),
            Self::Line { .. } => 0.0,
            Self::Arc(arc) => arc.second_derivative_bound(),
            Self::Cubic([a, b, c, d]) => 6.0 * (a - b * 2.0 + c).norm().max((b - c * 2.0 + d).norm()),
            Self::Rational(curve) => {
                let halvings = curve.controls().len().ilog2() + 1;
                let parts = 1 << halvings;
                for k in 0..parts {
                    let (from, to) = (f64::from(k) / f64::from(parts), f64::from(k + 1) / f64::from(parts));
                    self.halve((from, self.point(from)), (to, self.point(to)), tolerance, 14, each);
                }
                return;
            }
        };
        let bound = if bend > 0.0 { bound.hypot(bend) } else { bound };
        let chords = (bound / (8.0 * tolerance)).sqrt().ceil().clamp(1.0, MOST_CHORDS) as u32;
        for k in 1..=chords {
            let t = f64::from(k) / f64::from(chords);
            each(t, self.point(t));
        }
    }

    fn halve(
        &self,
        from: (f64, Vec2),
        to: (f64, Vec2),
        tolerance: f64,
        depth: u32,
        each: &mut impl FnMut(f64, Vec2),
    ) {
        let middle = (from.0 + to.0) * 0.5;
        let p = self.point(middle);
        // The chord's deviation falls to a quarter with each halving; quarters catch a curve that crosses its chord.
        let worst = [0.25, 0.75]
            .map(|f| self.point(from.0 + (to.0 - from.0) * f))
            .into_iter()
            .chain([p])
            .map(|q| distance_to_segment(q, from.1, to.1))
            .fold(0.0, f64::max);
        if depth == 0 || worst < 0.8 * tolerance {
            return each(to.0, to.1);
        }
        self.halve(from, (middle, p), tolerance, depth - 1, each);
        self.halve((middle, p), to, tolerance, depth - 1, each);
    }

    /// The box around the piece \[mm\]: exact but for rational pieces, where it is within 1 µm.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let ends = Bounds { min: self.start().inf(&self.end()), max: self.start().sup(&self.end()) };
        let inner: Vec<Vec2> = match self {
            Self::Rational(_) => {
                let mut points = Vec::new();
                self.flatten(1e-3, &mut |_, p| points.push(p));
                points
            }
            Self::Line { .. } | Self::Arc(_) | Self::Cubic(_) => {
                self.extremes().into_iter().map(|t| self.point(t)).collect()
            }
        };
        Bounds::around(inner).map_or(ends, |b| ends.union(&b))
    }
}

impl Stroke {
    /// The stroke as a polyline \[mm\] no further than `tolerance` \[mm\] from it, its start included.
    #[must_use]
    pub fn flattened(&self, tolerance: f64) -> Vec<Vec2> {
        let mut points = vec![self.start()];
        for piece in self.pieces() {
            piece.flatten(tolerance, &mut |_, p| points.push(p));
        }
        points
    }

    /// The tip's path as a polyline \[mm\] no further than `tolerance` \[mm\] from it, its start included.
    #[must_use]
    pub fn flattened_tips(&self, tolerance: f64) -> Vec<Vec3> {
        let mut points = vec![self.tip(0.0)];
        for (k, piece) in self.pieces().iter().enumerate() {
            let height = self.height(k);
            piece.flatten_at(&height, tolerance, &mut |t, p| points.push(with_height(p, height.at(t))));
        }
        points
    }
}

/// The distance of a point from a segment \[mm\].
fn distance_to_segment(p: Vec2, a: Vec2, b: Vec2) -> f64 {
    let along = b - a;
    let squared = along.norm_squared();
    let t = if squared > 0.0 { ((p - a).dot(&along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (p - a - along * t).norm()
}

#[cfg(test)]
mod tests {
    use super::super::{EllipticalArc, PlanarNurbs};
    use super::*;

    fn worst(piece: &Piece, tolerance: f64) -> f64 {
        let mut last = (0.0, piece.start());
        let mut worst = 0.0f64;
        piece.flatten(tolerance, &mut |t, p| {
            for k in 1..20 {
                let inner = piece.point(last.0 + (t - last.0) * f64::from(k) / 20.0);
                worst = worst.max(distance_to_segment(inner, last.1, p));
            }
            last = (t, p);
        });
        worst
    }

    #[test]
    fn chords_stay_within_the_tolerance() {
        let arc = Piece::Arc(EllipticalArc::circular(Vec2::zeros(), 40.0, 1.0, 5.0));
        let cubic = Piece::Cubic([
            Vec2::zeros(),
            Vec2::new(80.0, 10.0),
            Vec2::new(-50.0, 10.0),
            Vec2::new(30.0, 0.0),
        ]);
        let controls = (0..7)
            .map(|i| (Vec2::new(f64::from(i) * 5.0, f64::from(i * i % 5) * 9.0), 1.0 + f64::from(i % 3)))
            .collect();
        let mut pieces = PlanarNurbs::open_uniform(4, controls).pieces().unwrap();
        pieces.extend([arc, cubic]);
        for piece in &pieces {
            for tolerance in [1e-1, 1e-2, 2e-4] {
                assert!(worst(piece, tolerance) <= tolerance, "{piece:?} at {tolerance}");
            }
        }
    }
}
