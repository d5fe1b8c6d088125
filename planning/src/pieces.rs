//! Pieces of a path from which stops are proven, at speeds that are tried one after the other.
//!
//! In: a cell of the grid of a path, and whether the stops from a piece of it are clear at a speed. Out: whether those of the whole cell are. A piece
//! that is too long to prove that is cut in halves. What is proven at a speed is so at every lower one, and the piece that failed
//! last is tried first: most speeds that are not clear are found by it alone.

/// A piece.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Its first and its last parameter.
    ends: [f64; 2],
    /// How often the cell was cut in halves to get it.
    halvings: u32,
    /// The largest speed from which its stops are known to be clear \[1/s\].
    proven: f64,
}

/// The pieces of a cell, the one that failed last before the others.
#[derive(Clone, Debug)]
pub(crate) struct Pieces(Vec<Piece>);

impl Pieces {
    /// One piece, from a parameter to another.
    pub(crate) fn new(ends: [f64; 2]) -> Self {
        Pieces(vec![Piece { ends, halvings: 0, proven: 0.0 }])
    }

    /// The largest speed from which the stops of all are known to be clear \[1/s\].
    pub(crate) fn proven(&self) -> f64 {
        self.0.iter().map(|piece| piece.proven).fold(f64::INFINITY, f64::min)
    }

    /// Whether the stops of all are clear from a speed \[1/s\], by what `is_clear` says of a piece; pieces are cut in halves so often.
    pub(crate) fn are_clear(
        &mut self,
        speed: f64,
        halvings: u32,
        mut is_clear: impl FnMut([f64; 2]) -> bool,
    ) -> bool {
        let mut at = 0;
        while let Some(piece) = self.0.get_mut(at) {
            if piece.proven >= speed {
                at += 1;
            } else if is_clear(piece.ends) {
                piece.proven = speed;
                at += 1;
            } else if piece.halvings < halvings {
                let [from, to] = piece.ends;
                let middle = 0.5 * (from + to);
                piece.halvings += 1;
                piece.ends = [from, middle];
                let second = Piece { ends: [middle, to], ..*piece };
                self.0.insert(at + 1, second);
            } else {
                self.0[..=at].rotate_right(1);
                return false;
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_speed_that_is_clear_everywhere_is_found_with_few_tries_of_what_fails() {
        // At 0.3 no speed above 2 is clear, nor any piece longer than 0.1.
        let (mut tries, mut failed) = (0, 0);
        let mut pieces = Pieces::new([0.0, 1.0]);
        let mut clear_at = |speed: f64| {
            pieces.are_clear(speed, 4, |[from, to]| {
                let is_clear = to - from < 0.1 && (speed <= 2.0 || !(from..to).contains(&0.3));
                tries += 1;
                failed += u32::from(!is_clear);
                is_clear
            })
        };
        let [mut slow, mut fast] = [0.0, 8.0];
        assert!(!clear_at(fast));
        for _ in 0..10 {
            let middle = 0.5 * (slow + fast);
            if clear_at(middle) { slow = middle } else { fast = middle }
        }
        assert!((slow - 2.0_f64).abs() < 0.01 && pieces.proven() == slow, "{slow} {pieces:?}");
        // It is cut once; after that each speed that is not clear takes one try.
        assert!(failed < 40, "{failed} of {tries}");
    }
}
