//! Strokes and drawings: connected chains of pieces, and lists of such chains.

use super::{Affine, Piece, Vec2};

/// Whether a stroke ends where it began.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closure {
    /// Two ends.
    Open,
    /// The end is the start.
    Closed,
}

/// An axis-parallel box \[mm\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower left corner \[mm\].
    pub min: Vec2,
    /// Upper right corner \[mm\].
    pub max: Vec2,
}

impl Bounds {
    /// The box around points; `None` for none.
    #[must_use]
    pub fn around(points: impl IntoIterator<Item = Vec2>) -> Option<Self> {
        points.into_iter().fold(None, |so_far: Option<Self>, p| {
            Some(match so_far {
                None => Self { min: p, max: p },
                Some(b) => Self { min: b.min.inf(&p), max: b.max.sup(&p) },
            })
        })
    }

    /// The box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }

    /// Width and height \[mm\].
    #[must_use]
    pub fn size(&self) -> Vec2 {
        self.max - self.min
    }

    /// The middle \[mm\].
    #[must_use]
    pub fn centre(&self) -> Vec2 {
        (self.min + self.max) * 0.5
    }
}

/// A connected chain of curve pieces that the tool follows without lifting: never empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    pieces: Vec<Piece>,
    closure: Closure,
}

/// Ends closer than this are the same point \[mm\].
pub const TOUCHING: f64 = 1e-4;

/// Pieces shorter than this are dropped \[mm\]: rounding in the file, not a feature.
const SHORTEST_PIECE: f64 = 1e-6;

impl Stroke {
    /// A stroke over pieces that follow one another; `None` if nothing of measurable length is among them.
    ///
    /// The stroke is closed if its end lies within 0.1 µm of its start.
    #[must_use]
    pub fn new(mut pieces: Vec<Piece>) -> Option<Self> {
        pieces.retain(|piece| match piece {
            Piece::Line { from, to } => (to - from).norm() > SHORTEST_PIECE,
            Piece::Arc(_) | Piece::Cubic(_) | Piece::Rational(_) => piece.length() > SHORTEST_PIECE,
        });
        let closed = (pieces.first()?.start() - pieces.last()?.end()).norm() < TOUCHING;
        Some(Self { pieces, closure: if closed { Closure::Closed } else { Closure::Open } })
    }

    /// The pieces in order.
    #[must_use]
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The pieces, given away.
    #[must_use]
    pub fn into_pieces(self) -> Vec<Piece> {
        self.pieces
    }

    /// Whether the end is the start.
    #[must_use]
    pub fn closure(&self) -> Closure {
        self.closure
    }

    /// The piece and its parameter for a stroke parameter: `k + t` is parameter `t` of piece `k`.
    #[must_use]
    pub fn locate(&self, parameter: f64) -> (&Piece, f64) {
        let last = self.pieces.len() - 1;
        let k = (parameter.max(0.0).floor() as usize).min(last);
        (&self.pieces[k], (parameter - k as f64).clamp(0.0, 1.0))
    }

    /// The point at the stroke parameter in 0..=number of pieces \[mm\].
    #[must_use]
    pub fn point(&self, parameter: f64) -> Vec2 {
        let (piece, t) = self.locate(parameter);
        piece.point(t)
    }

    /// The derivative by the stroke parameter \[mm\]; at a join that of the later piece.
    #[must_use]
    pub fn derivative(&self, parameter: f64) -> Vec2 {
        let (piece, t) = self.locate(parameter);
        piece.derivative(t)
    }

    /// The start \[mm\].
    #[must_use]
    pub fn start(&self) -> Vec2 {
        self.point(0.0)
    }

    /// The end \[mm\].
    #[must_use]
    pub fn end(&self) -> Vec2 {
        self.point(self.pieces.len() as f64)
    }

    /// The arc length \[mm\].
    #[must_use]
    pub fn length(&self) -> f64 {
        self.pieces.iter().map(Piece::length).sum()
    }

    /// The box around the stroke \[mm\].
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let mut bounds = Bounds { min: self.start(), max: self.start() };
        for piece in &self.pieces {
            bounds = bounds.union(&piece.bounds());
        }
        bounds
    }

    /// The same stroke travelled the other way.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self { pieces: self.pieces.iter().rev().map(Piece::reversed).collect(), closure: self.closure }
    }

    /// The stroke's image.
    #[must_use]
    pub fn transformed(&self, map: &Affine) -> Self {
        Self {
            pieces: self.pieces.iter().map(|piece| piece.transformed(map)).collect(),
            closure: self.closure,
        }
    }
}

/// What is to be engraved, in millimetres with y up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// The strokes in the order of cutting.
    pub strokes: Vec<Stroke>,
}

impl Drawing {
    /// The box around everything \[mm\]; `None` for an empty drawing.
    #[must_use]
    pub fn bounds(&self) -> Option<Bounds> {
        self.strokes.iter().map(Stroke::bounds).reduce(|a, b| a.union(&b))
    }

    /// The sum of the strokes' lengths \[mm\], without travel between them.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.strokes.iter().map(Stroke::length).sum()
    }

    /// The number of curve pieces.
    #[must_use]
    pub fn piece_count(&self) -> usize {
        self.strokes.iter().map(|stroke| stroke.pieces.len()).sum()
    }

    /// The drawing's image.
    #[must_use]
    pub fn transformed(&self, map: &Affine) -> Self {
        Self { strokes: self.strokes.iter().map(|stroke| stroke.transformed(map)).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::super::EllipticalArc;
    use super::*;

    #[test]
    fn bounds_of_a_turned_ellipse_are_exact() {
        let map = Affine::rotation(0.7);
        let arc =
            EllipticalArc { v: Vec2::new(0.0, 1.0), ..EllipticalArc::circular(Vec2::zeros(), 3.0, 0.0, 6.3) };
        let stroke = Stroke::new(vec![Piece::Arc(arc).transformed(&map)]).unwrap();
        // Half width of an ellipse turned by α: sqrt(a² cos²α + b² sin²α).
        let (sin, cos) = 0.7f64.sin_cos();
        let expected = (9.0 * cos * cos + sin * sin).sqrt();
        assert!((stroke.bounds().max.x - expected).abs() < 1e-12);
    }

    #[test]
    fn a_stroke_of_nothing_is_none() {
        let p = Vec2::new(1.0, 2.0);
        assert!(Stroke::new(vec![Piece::Line { from: p, to: p }]).is_none());
        assert!(Stroke::new(vec![]).is_none());
    }

    #[test]
    fn a_reversed_stroke_ends_where_it_began() {
        let line = |a: f64, b: f64| Piece::Line { from: Vec2::new(a, 0.0), to: Vec2::new(b, b) };
        let stroke = Stroke::new(vec![
            line(0.0, 1.0),
            Piece::quadratic(Vec2::new(1.0, 1.0), Vec2::new(2.0, 5.0), Vec2::new(3.0, 1.0)),
        ])
        .unwrap();
        let back = stroke.reversed();
        assert_eq!(back.start(), stroke.end());
        assert_eq!(back.end(), stroke.start());
        assert!((back.length() - stroke.length()).abs() < 1e-12);
    }
}
