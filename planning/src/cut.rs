//! Parts of paths, and paths made of parts: what a new path has of the one before it.

use crate::check::Checker;
use crate::edge::{Edges, single};
use crate::path::{Path, Piece, ROUNDING, along, distance, is_clear, part};

/// The difference of two directions that makes a corner.
const CORNER: f64 = 1e-6;

impl Path {
    /// Where the path from a parameter on has its first corner, which only robots that rest there can pass; its end where there is none.
    pub(crate) fn corner_from(&self, u: f64) -> f64 {
        let inner = self.knots[1..].iter().copied().take(self.pieces.len().saturating_sub(1));
        let turns = |knot: &f64| {
            let [before, behind] = [knot.next_down(), *knot].map(|u| self.at(u).first);
            distance(&before, &behind) > CORNER
        };
        inner.filter(|knot| *knot >= u).find(turns).unwrap_or(self.length())
    }

    /// The path up to a parameter.
    pub(crate) fn until(&self, end: f64) -> Self {
        let mut path = Path { knots: vec![0.0], pieces: Vec::new() };
        for (ends, piece) in self.knots.windows(2).zip(&self.pieces) {
            let width = end.min(ends[1]) - ends[0];
            if width <= ROUNDING {
                break;
            }
            let share = width / (ends[1] - ends[0]);
            let piece = match piece {
                Piece::Curve(points) if share < 1.0 => {
                    Piece::Curve(points.iter().map(|points| part(points, [0.0, share])).collect())
                }
                whole => whole.clone(),
            };
            path.push(width, piece);
        }
        path
    }

    /// The path from the piece at a parameter on, and the parameter at which that piece begins, which is 0 then.
    pub(crate) fn since(&self, u: f64) -> (Self, f64) {
        let piece = self.piece_at(u);
        let first = self.knots[piece];
        let knots = self.knots[piece..].iter().map(|knot| knot - first).collect();
        (Path { knots, pieces: self.pieces[piece..].to_vec() }, first)
    }

    /// Goes on along another path, which begins where this one ends.
    pub(crate) fn append(&mut self, other: &Path) {
        for (ends, piece) in other.knots.windows(2).zip(&other.pieces) {
            self.push(ends[1] - ends[0], piece.clone());
        }
    }

    /// The same with all joints that much farther [rad or m].
    pub(crate) fn moved(mut self, by: &[f64]) -> Self {
        for piece in &mut self.pieces {
            match piece {
                Piece::Leg { from, .. } => from.iter_mut().zip(by).for_each(|(q, by)| *q += by),
                Piece::Curve(points) => {
                    points.iter_mut().zip(by).for_each(|(q, by)| q.iter_mut().for_each(|q| *q += by));
                }
            }
        }
        self
    }

    /// Whether the path is clear from one parameter to another.
    pub(crate) fn is_clear(&self, checker: &mut Checker, edges: &mut Edges, [from, to]: [f64; 2]) -> bool {
        self.knots.windows(2).zip(&self.pieces).all(|(ends, piece)| {
            let [a, b] = [from, to].map(|u| u.clamp(ends[0], ends[1]) - ends[0]);
            if b - a <= ROUNDING {
                return true;
            }
            match piece {
                Piece::Leg { from, along: e } => {
                    edges.is_clear(checker, &single(&along(from, e, a)), &single(&along(from, e, b)))
                }
                Piece::Curve(points) => {
                    let width = ends[1] - ends[0];
                    let part: Vec<_> = points.iter().map(|p| part(p, [a / width, b / width])).collect();
                    is_clear(checker, edges, &part)
                }
            }
        })
    }
}
