//! Strokes and drawings: connected chains of pieces, and lists of such chains.

use super::{Affine, Bounds, Height, Manner, Piece, Vec2, Vec3};

/// Whether a stroke ends where it began.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closure {
    /// Two ends.
    Open,
    /// The end is the start.
    Closed,
}

/// A connected chain of curve pieces that the tool follows without lifting: never empty.
///
/// Over its parameter `k + t`, which is `t` in 0..=1 of piece `k`, it has a place over the plate and a height. A stroke
/// whose file says no heights is level at height 0, until [`sunk`](Stroke::sunk) to the depth of the run.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    pieces: Vec<Piece>,
    /// One for each piece; none where the file says no heights.
    heights: Vec<Height>,
    closure: Closure,
    /// What the file says of its cutting.
    manner: Manner,
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
        let closure = if closed { Closure::Closed } else { Closure::Open };
        Some(Self { pieces, heights: Vec::new(), closure, manner: Manner::default() })
    }

    /// A stroke over pieces with their heights; `None` if nothing of measurable length is among them. A piece may be a
    /// line of no length over which the tip goes down or up.
    #[must_use]
    pub fn with_heights(mut pieces: Vec<(Piece, Height)>, manner: Manner) -> Option<Self> {
        pieces.retain(|(piece, height)| {
            let (low, high) = height.range();
            high - low > SHORTEST_PIECE || piece.length() > SHORTEST_PIECE
        });
        let (pieces, heights): (Vec<_>, Vec<_>) = pieces.into_iter().unzip();
        if pieces.is_empty() {
            return None;
        }
        let mut stroke = Self { pieces, heights, closure: Closure::Open, manner };
        if (stroke.tip(0.0) - stroke.tip(stroke.pieces.len() as f64)).norm() < TOUCHING {
            stroke.closure = Closure::Closed;
        }
        Some(stroke)
    }

    /// The stroke, cut as its file says.
    #[must_use]
    pub fn cut_so(self, manner: Manner) -> Self {
        Self { manner, ..self }
    }

    /// What the file says of its cutting.
    #[must_use]
    pub fn manner(&self) -> &Manner {
        &self.manner
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

    /// The pieces' heights over the plate; `None` where the file says none.
    #[must_use]
    pub fn heights(&self) -> Option<&[Height]> {
        if self.heights.is_empty() { None } else { Some(&self.heights) }
    }

    /// The height along a piece.
    #[must_use]
    pub fn height(&self, piece: usize) -> Height {
        self.heights.get(piece).copied().unwrap_or(Height::level(0.0))
    }

    /// The lowest and the highest height \[mm\].
    #[must_use]
    pub fn height_range(&self) -> (f64, f64) {
        let ranges = (0..self.pieces.len()).map(|k| self.height(k).range());
        ranges.fold((f64::MAX, f64::MIN), |a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// Whether the end is the start.
    #[must_use]
    pub fn closure(&self) -> Closure {
        self.closure
    }

    /// The index of the piece and its parameter for a stroke parameter: `k + t` is parameter `t` of piece `k`.
    #[must_use]
    pub fn locate(&self, parameter: f64) -> (usize, f64) {
        let last = self.pieces.len() - 1;
        let k = (parameter.max(0.0).floor() as usize).min(last);
        (k, (parameter - k as f64).clamp(0.0, 1.0))
    }

    /// The place over the plate at the stroke parameter in 0..=number of pieces \[mm\].
    #[must_use]
    pub fn point(&self, parameter: f64) -> Vec2 {
        let (k, t) = self.locate(parameter);
        self.pieces[k].point(t)
    }

    /// The tool's tip at the stroke parameter: the place over the plate and the height \[mm\].
    #[must_use]
    pub fn tip(&self, parameter: f64) -> Vec3 {
        let (k, t) = self.locate(parameter);
        with_height(self.pieces[k].point(t), self.height(k).at(t))
    }

    /// First and second derivative of the tip by the stroke parameter \[mm\]; at a join those of the later piece.
    #[must_use]
    pub fn tip_derivatives(&self, parameter: f64) -> (Vec3, Vec3) {
        let (k, t) = self.locate(parameter);
        self.piece_derivatives(k, t)
    }

    fn piece_derivatives(&self, k: usize, t: f64) -> (Vec3, Vec3) {
        let (d, dd) = self.pieces[k].derivatives(t);
        let (rise, bend) = self.height(k).derivatives(t);
        (with_height(d, rise), with_height(dd, bend))
    }

    /// The unit tangent of the tip's path on a piece; where the derivative vanishes, its limit from inside.
    #[must_use]
    pub fn tip_tangent(&self, k: usize, t: f64) -> Vec3 {
        let tip = |t: f64| with_height(self.pieces[k].point(t), self.height(k).at(t));
        let mut step = 1e-6;
        let mut d = self.piece_derivatives(k, t).0;
        let inward = if t < 0.5 { 1.0 } else { -1.0 };
        while d.norm() < 1e-9 && step < 0.3 {
            d = (tip(t + inward * step) - tip(t)) * inward;
            step *= 10.0;
        }
        let norm = d.norm();
        if norm > 0.0 { d / norm } else { Vec3::new(1.0, 0.0, 0.0) }
    }

    /// The start over the plate \[mm\].
    #[must_use]
    pub fn start(&self) -> Vec2 {
        self.point(0.0)
    }

    /// The end over the plate \[mm\].
    #[must_use]
    pub fn end(&self) -> Vec2 {
        self.point(self.pieces.len() as f64)
    }

    /// The tip at the end \[mm\].
    #[must_use]
    pub fn end_tip(&self) -> Vec3 {
        self.tip(self.pieces.len() as f64)
    }

    /// The length of the tip's path \[mm\].
    #[must_use]
    pub fn length(&self) -> f64 {
        let one = |(k, piece): (usize, &Piece)| match self.heights.get(k) {
            None => piece.length(),
            Some(height) => piece.length_at(height),
        };
        self.pieces.iter().enumerate().map(one).sum()
    }

    /// The box around the stroke, seen from above \[mm\].
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let mut bounds = Bounds { min: self.start(), max: self.start() };
        for piece in &self.pieces {
            bounds = bounds.union(&piece.bounds());
        }
        bounds
    }

    /// The same stroke travelled in the other direction.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self {
            pieces: self.pieces.iter().rev().map(Piece::reversed).collect(),
            heights: self.heights.iter().rev().map(Height::reversed).collect(),
            closure: self.closure,
            manner: self.manner,
        }
    }

    /// The stroke's image; heights and manner stay as they are.
    #[must_use]
    pub fn transformed(&self, map: &Affine) -> Self {
        Self {
            pieces: self.pieces.iter().map(|piece| piece.transformed(map)).collect(),
            heights: self.heights.clone(),
            closure: self.closure,
            manner: self.manner,
        }
    }

    /// The stroke at this depth \[mm\] where its file says no heights; else as it is.
    #[must_use]
    pub fn sunk(self, depth: f64) -> Self {
        if self.heights.is_empty() { self.flattened_to(depth) } else { self }
    }

    /// The stroke at this depth \[mm\], whatever its file says. What only goes down, a hole, goes down so deep.
    #[must_use]
    pub fn flattened_to(mut self, depth: f64) -> Self {
        let bottom = Height::level(-depth);
        let level: Vec<Piece> =
            self.pieces.iter().filter(|piece| piece.length() > SHORTEST_PIECE).cloned().collect();
        if level.is_empty() {
            self.pieces.truncate(1);
            self.heights = vec![Height::Linear { from: 0.0, to: -depth }];
        } else {
            self.heights = vec![bottom; level.len()];
            self.pieces = level;
        }
        let closed = (self.tip(0.0) - self.end_tip()).norm() < TOUCHING;
        self.closure = if closed { Closure::Closed } else { Closure::Open };
        self
    }
}

/// A place over the plate and a height.
pub(super) fn with_height(place: Vec2, height: f64) -> Vec3 {
    Vec3::new(place.x, place.y, height)
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
