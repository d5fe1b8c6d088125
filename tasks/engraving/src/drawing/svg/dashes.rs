//! Dashed outlines: `stroke-dasharray`, `stroke-dashoffset` and `pathLength`, as SVG 2 has them.
//!
//! In: subpaths in the element's own units, and a pattern of lengths. Out: the dashes as chains of exact pieces. The pattern
//! begins anew with each subpath, and dashes do not join across its start.

use crate::drawing::{Piece, Vec2};
use std::str::FromStr;
use svgtypes::Length;

/// The lengths of a `stroke-dasharray`; none for `none`.
///
/// # Errors
/// What is wrong with the text.
pub fn lengths(text: &str) -> Result<Vec<Length>, String> {
    if text == "none" {
        return Ok(Vec::new());
    }
    let words = text.split(|c: char| c == ',' || c.is_ascii_whitespace()).filter(|word| !word.is_empty());
    let lengths: Result<Vec<_>, _> = words.map(Length::from_str).collect();
    let lengths = lengths.map_err(|error| error.to_string())?;
    if lengths.iter().any(|length| length.number < 0.0) {
        return Err("a length is negative".to_owned());
    }
    if lengths.is_empty() { Err("there is no length".to_owned()) } else { Ok(lengths) }
}

/// A `stroke-dashoffset`.
///
/// # Errors
/// What is wrong with the text.
pub fn offset(text: &str) -> Result<Length, String> {
    Length::from_str(text).map_err(|error| error.to_string())
}

/// A pattern of dashes and gaps, in the units of the outline.
pub struct Pattern {
    /// Dash, gap, dash, gap ..: an even number, each >= 0, the sum > 0.
    lengths: Vec<f64>,
    /// How far into the pattern a subpath begins, from 0 to less than the sum.
    offset: f64,
}

impl Pattern {
    /// Of these lengths, all >= 0, an odd list twice; `None` if it draws a whole line.
    #[must_use]
    pub fn new(mut lengths: Vec<f64>, offset: f64) -> Option<Pattern> {
        if lengths.len() % 2 == 1 {
            lengths.extend_from_within(..);
        }
        let sum: f64 = lengths.iter().sum();
        let is_pattern = sum > 0.0 && sum.is_finite() && offset.is_finite();
        is_pattern.then(|| Pattern { offset: offset.rem_euclid(sum).min(sum), lengths })
    }

    /// How many pieces at most its dashes make of an outline of `pieces` pieces and this length.
    #[must_use]
    pub fn count(&self, pieces: usize, length: f64) -> f64 {
        let sum: f64 = self.lengths.iter().sum();
        pieces as f64 + (length / sum + 2.0) * (self.lengths.len() / 2) as f64
    }

    /// Whether any dash has no length.
    #[must_use]
    pub fn has_dots(&self) -> bool {
        self.lengths.iter().step_by(2).any(|&dash| dash == 0.0)
    }

    /// Where a subpath begins: the place in the pattern, and how much of that dash or gap is left.
    fn start(&self) -> (usize, f64) {
        let mut into = self.offset;
        for (place, &length) in self.lengths.iter().enumerate() {
            if into < length {
                return (place, length - into);
            }
            into -= length;
        }
        (0, self.lengths[0])
    }

    /// The dashes of a subpath.
    #[must_use]
    pub fn cut(&self, chain: &[Piece]) -> Vec<Vec<Piece>> {
        let (mut place, mut left) = self.start();
        let (mut dashes, mut dash) = (Vec::new(), Vec::new());
        for piece in chain {
            let mut from = 0.0;
            let mut rest = piece.length();
            while left < rest {
                let to = if left > 0.0 { parameter_after(piece, from, left) } else { from };
                if place % 2 == 0 {
                    if to > from {
                        dash.push(piece.part(from, to));
                    }
                    if !dash.is_empty() {
                        dashes.push(std::mem::take(&mut dash));
                    }
                }
                rest -= left;
                from = to;
                place = (place + 1) % self.lengths.len();
                left = self.lengths[place];
            }
            left -= rest;
            if place % 2 == 0 && from < 1.0 {
                dash.push(if from > 0.0 { piece.part(from, 1.0) } else { piece.clone() });
            }
        }
        if !dash.is_empty() {
            dashes.push(dash);
        }
        dashes
    }
}

/// The parameter of a piece that lies `length` behind the parameter `from`, where the piece is longer than that.
fn parameter_after(piece: &Piece, from: f64, length: f64) -> f64 {
    if let Piece::Line { from: a, to: b } = piece {
        return (from + length / (b - a).norm()).min(1.0);
    }
    let (mut low, mut high) = (from, 1.0);
    let speed = |t: f64| Vec2::norm(&piece.derivative(t));
    let mut t = from + length / speed(from);
    for _ in 0..60 {
        if t <= low || t >= high || t.is_nan() {
            t = 0.5 * (low + high);
        }
        let missing = length - piece.part(from, t).length();
        if missing.abs() <= 1e-12 * length.max(1e-3) || high - low < 1e-15 {
            break;
        }
        if missing > 0.0 {
            low = t;
        } else {
            high = t;
        }
        // Newton's step, where it stays between the bounds.
        t += missing / speed(t);
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::EllipticalArc;

    fn length(dashes: &[Vec<Piece>]) -> f64 {
        dashes.iter().flatten().map(Piece::length).sum()
    }

    /// Of a length `L` and a pattern of period `p` whose dashes have `d`: `d` for each whole period, and what is left.
    #[test]
    fn the_dashes_of_any_piece_have_the_lengths_of_the_pattern() {
        let line = Piece::Line { from: Vec2::new(1.0, 2.0), to: Vec2::new(31.0, 42.0) };
        let arc = Piece::Arc(EllipticalArc::circular(Vec2::new(3.0, 4.0), 10.0, 0.5, -3.0));
        let ellipse = Piece::Arc(EllipticalArc {
            centre: Vec2::zeros(),
            u: Vec2::new(20.0, 0.0),
            v: Vec2::new(0.0, 5.0),
            start_angle: 0.0,
            sweep: 6.0,
        });
        let at = |x: f64, y: f64| Vec2::new(x, y);
        let cubic = Piece::Cubic([at(0.0, 0.0), at(40.0, 0.0), at(-10.0, 30.0), at(30.0, 30.0)]);
        // It stands still at its start.
        let cusp = Piece::Cubic([at(0.0, 0.0), at(0.0, 0.0), at(10.0, 30.0), at(30.0, 30.0)]);
        for piece in [line, arc, ellipse, cubic, cusp] {
            let whole = piece.length();
            for (lengths, offset) in [
                (vec![3.0, 2.0], 0.0),
                (vec![3.0, 2.0], 4.0),
                (vec![3.0, 2.0], -1.0),
                (vec![1.0, 0.5, 2.0], 0.25),
            ] {
                let pattern = Pattern::new(lengths.clone(), offset).expect("a pattern");
                let dashes = pattern.cut(std::slice::from_ref(&piece));
                // How much of the first x of the endless pattern is dash.
                let doubled = if lengths.len() == 3 { lengths.repeat(2) } else { lengths };
                let period: f64 = doubled.iter().sum();
                let drawn = |x: f64| {
                    let (periods, mut left) = ((x / period).floor(), x.rem_euclid(period));
                    let dash: f64 = doubled.iter().step_by(2).sum();
                    let mut sum = periods * dash;
                    for (i, length) in doubled.iter().enumerate() {
                        sum += if i % 2 == 0 { left.clamp(0.0, *length) } else { 0.0 };
                        left -= length;
                    }
                    sum
                };
                let expected = drawn(whole + offset) - drawn(offset);
                assert!(
                    (length(&dashes) - expected).abs() < 1e-6 * whole, // what a length is good to
                    "{piece:?}: {} {expected}",
                    length(&dashes)
                );
                let longest = dashes.iter().map(|dash| dash.iter().map(Piece::length).sum::<f64>());
                assert!(longest.fold(0.0, f64::max) <= 3.0 + 1e-6);
            }
        }
    }

    #[test]
    fn a_dash_goes_round_corners_and_a_list_of_nothing_is_a_whole_line() {
        let corner: Vec<Piece> = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)]
            .windows(2)
            .map(|w| Piece::Line { from: Vec2::new(w[0].0, w[0].1), to: Vec2::new(w[1].0, w[1].1) })
            .collect();
        let dashes = Pattern::new(vec![4.0], 0.0).expect("dashes and gaps of 4").cut(&corner);
        // 0 to 4, 8 to 12 round the corner, 16 to 20.
        assert_eq!(dashes.iter().map(Vec::len).collect::<Vec<_>>(), [1, 2, 1]);
        assert!((dashes[1][0].start() - Vec2::new(8.0, 0.0)).norm() < 1e-12);
        assert!((dashes[1][1].end() - Vec2::new(10.0, 2.0)).norm() < 1e-12);
        for lengths in [vec![], vec![0.0, 0.0], vec![f64::INFINITY, 1.0]] {
            assert!(Pattern::new(lengths, 0.0).is_none());
        }
        // A gap that ends where a piece ends; a dash of no length.
        let dashes = Pattern::new(vec![0.0, 5.0, 5.0, 10.0], 0.0).expect("a pattern").cut(&corner);
        assert!((length(&dashes) - 5.0).abs() < 1e-12 && dashes.len() == 1, "{dashes:?}");
    }
}
