//! Chains strokes whose ends touch: CAD files give a rectangle as four lines in any order and sense.

use super::stroke::TOUCHING;
use super::{Closure, Piece, Stroke, Vec2};
use std::collections::HashMap;

/// Joins open strokes end to end where their ends lie within 0.1 µm; keeps the order of first appearance.
#[must_use]
pub fn join_touching(strokes: Vec<Stroke>) -> Vec<Stroke> {
    let mut ends = Ends::default();
    for (i, stroke) in strokes.iter().enumerate() {
        if stroke.closure() == Closure::Open {
            ends.add(stroke.start(), i);
            ends.add(stroke.end(), i);
        }
    }
    let mut waiting: Vec<Option<Stroke>> = strokes.into_iter().map(Some).collect();
    let mut joined = Vec::new();
    for i in 0..waiting.len() {
        let Some(first) = waiting[i].take() else { continue };
        if first.closure() == Closure::Closed {
            joined.push(first);
            continue;
        }
        let forward = grow(first.into_pieces(), &mut waiting, &ends);
        let backward: Vec<Piece> = forward.iter().rev().map(Piece::reversed).collect();
        let both = grow(backward, &mut waiting, &ends);
        joined.extend(Stroke::new(both.iter().rev().map(Piece::reversed).collect()));
    }
    joined
}

/// Appends waiting strokes at the end of the chain until none touches it or it has closed.
fn grow(mut chain: Vec<Piece>, waiting: &mut [Option<Stroke>], ends: &Ends) -> Vec<Piece> {
    let Some(start) = chain.first().map(Piece::start) else { return chain };
    while let Some(tip) = chain.last().map(Piece::end) {
        if (tip - start).norm() < TOUCHING {
            break;
        }
        let next = ends.near(tip).find_map(|i| {
            let candidate = waiting[i].as_ref()?;
            if (candidate.start() - tip).norm() < TOUCHING {
                Some((i, false))
            } else if (candidate.end() - tip).norm() < TOUCHING {
                Some((i, true))
            } else {
                None
            }
        });
        let Some((i, backwards)) = next else { break };
        if let Some(stroke) = waiting[i].take() {
            let stroke = if backwards { stroke.reversed() } else { stroke };
            chain.extend(stroke.into_pieces());
        }
    }
    chain
}

/// Stroke ends by cells of the size of the tolerance.
#[derive(Default)]
struct Ends {
    cells: HashMap<(i64, i64), Vec<usize>>,
}

impl Ends {
    fn cell(p: Vec2) -> (i64, i64) {
        ((p.x / TOUCHING).floor() as i64, (p.y / TOUCHING).floor() as i64)
    }

    fn add(&mut self, p: Vec2, stroke: usize) {
        self.cells.entry(Self::cell(p)).or_default().push(stroke);
    }

    fn near(&self, p: Vec2) -> impl Iterator<Item = usize> {
        let (x, y) = Self::cell(p);
        (-1..=1)
            .flat_map(move |dx| (-1..=1).map(move |dy| (x.saturating_add(dx), y.saturating_add(dy))))
            .filter_map(|cell| self.cells.get(&cell))
            // A node where very many strokes meet is no chain; a bound keeps a star of a million lines quick.
            .flat_map(|list| list.iter().take(64).copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_lines_in_disorder_make_one_closed_rectangle() {
        let line = |a: [f64; 2], b: [f64; 2]| {
            Stroke::new(vec![Piece::Line { from: a.into(), to: b.into() }]).unwrap()
        };
        let joined = join_touching(vec![
            line([0.0, 0.0], [4.0, 0.0]),
            line([0.0, 3.0], [4.0, 3.0]),
            line([4.0, 3.0], [4.0, 0.0]),
            line([0.0, 0.0], [0.0, 3.0]),
            line([9.0, 9.0], [8.0, 9.0]),
        ]);
        assert_eq!(joined.len(), 2);
        assert_eq!(joined[0].closure(), Closure::Closed);
        assert_eq!(joined[0].pieces().len(), 4);
        assert!((joined[0].length() - 14.0).abs() < 1e-12);
    }
}
