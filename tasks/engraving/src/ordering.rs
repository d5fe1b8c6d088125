//! The order of strokes: always the nearest next one, in either direction, so that the tool travels less.
//!
//! Greedy nearest neighbour over a grid of stroke ends; the same drawing gives the same order.

use crate::drawing::{Closure, Drawing, Stroke, Vec2};
use std::collections::HashMap;

/// Orders and turns the strokes, beginning with the one nearest to `from` \[mm\].
#[must_use]
pub fn nearest_first(drawing: Drawing, from: Vec2) -> Drawing {
    let Some(bounds) = drawing.bounds() else { return drawing };
    let mut grid = Grid::new(&drawing.strokes, bounds.size().amax());
    let mut waiting: Vec<Option<Stroke>> = drawing.strokes.into_iter().map(Some).collect();
    let mut strokes = Vec::with_capacity(waiting.len());
    let mut tool = from;
    while let Some(End { stroke, sense, .. }) = grid.nearest(tool) {
        grid.remove(stroke);
        if let Some(next) = waiting[stroke].take() {
            let next = match sense {
                Sense::Forward => next,
                Sense::Backward => next.reversed(),
            };
            tool = next.end();
            strokes.push(next);
        }
    }
    Drawing { strokes }
}

/// The length of the travel moves between strokes \[mm\], from `from` on.
#[must_use]
pub fn travel_length(drawing: &Drawing, from: Vec2) -> f64 {
    let mut tool = from;
    let mut sum = 0.0;
    for stroke in &drawing.strokes {
        sum += (stroke.start() - tool).norm();
        tool = stroke.end();
    }
    sum
}

#[derive(Clone, Copy, Debug)]
enum Sense {
    Forward,
    Backward,
}

/// An end at which a stroke may begin.
#[derive(Clone, Copy, Debug)]
struct End {
    position: Vec2,
    stroke: usize,
    sense: Sense,
}

/// Stroke ends in square cells.
struct Grid {
    cell: f64,
    cells: HashMap<(i64, i64), Vec<End>>,
    homes: Vec<Vec<(i64, i64)>>,
    rings: i64,
    left: usize,
}

impl Grid {
    fn new(strokes: &[Stroke], extent: f64) -> Self {
        let across = (strokes.len() as f64).sqrt().ceil().max(1.0);
        let cell = (extent / across).max(1e-3);
        let mut grid = Self {
            cell,
            cells: HashMap::new(),
            homes: Vec::new(),
            rings: across as i64 + 2,
            left: strokes.len(),
        };
        for (stroke, geometry) in strokes.iter().enumerate() {
            let mut homes = Vec::new();
            grid.add(End { position: geometry.start(), stroke, sense: Sense::Forward }, &mut homes);
            if geometry.closure() == Closure::Open {
                grid.add(End { position: geometry.end(), stroke, sense: Sense::Backward }, &mut homes);
            }
            grid.homes.push(homes);
        }
        grid
    }

    fn home(&self, p: Vec2) -> (i64, i64) {
        ((p.x / self.cell).floor() as i64, (p.y / self.cell).floor() as i64)
    }

    fn add(&mut self, end: End, homes: &mut Vec<(i64, i64)>) {
        let home = self.home(end.position);
        self.cells.entry(home).or_default().push(end);
        homes.push(home);
    }

    fn remove(&mut self, stroke: usize) {
        self.left -= 1;
        for home in std::mem::take(&mut self.homes[stroke]) {
            if let Some(ends) = self.cells.get_mut(&home) {
                ends.retain(|end| end.stroke != stroke);
                if ends.is_empty() {
                    self.cells.remove(&home);
                }
            }
        }
    }

    /// The nearest end; of equals the stroke that stands first.
    fn nearest(&self, to: Vec2) -> Option<End> {
        if self.left == 0 {
            return None;
        }
        let key = |end: &End| ((end.position - to).norm_squared(), end.stroke);
        let better = |a: End, b: End| if key(&b) < key(&a) { b } else { a };
        let (cx, cy) = self.home(to);
        let mut best: Option<End> = None;
        for ring in 0..=self.rings {
            for (x, y) in border(cx, cy, ring) {
                for end in self.cells.get(&(x, y)).into_iter().flatten() {
                    best = Some(best.map_or(*end, |b| better(b, *end)));
                }
            }
            // Nothing outside this ring is nearer than its inner edge.
            if best.is_some_and(|b| (b.position - to).norm() <= ring as f64 * self.cell) {
                return best;
            }
        }
        self.cells.values().flatten().copied().reduce(better)
    }
}

/// The cells at Chebyshev distance `ring`.
fn border(cx: i64, cy: i64, ring: i64) -> impl Iterator<Item = (i64, i64)> {
    (-ring..=ring).flat_map(move |dx| {
        let whole = dx.abs() == ring;
        let step = if whole || ring == 0 { 1 } else { 2 * ring };
        (-ring..=ring).step_by(step as usize).map(move |dy| (cx + dx, cy + dy))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::Piece;

    fn lines(ends: &[[f64; 4]]) -> Drawing {
        let stroke = |[a, b, c, d]: &[f64; 4]| {
            Stroke::new(vec![Piece::Line { from: Vec2::new(*a, *b), to: Vec2::new(*c, *d) }]).unwrap()
        };
        Drawing { strokes: ends.iter().map(stroke).collect() }
    }

    #[test]
    fn strokes_are_turned_and_taken_in_turn() {
        let drawing = lines(&[[90.0, 0.0, 80.0, 0.0], [10.0, 0.0, 1.0, 0.0], [30.0, 0.0, 79.0, 0.0]]);
        let ordered = nearest_first(drawing, Vec2::zeros());
        let starts: Vec<f64> = ordered.strokes.iter().map(|s| s.start().x).collect();
        assert_eq!(starts, [1.0, 30.0, 80.0]);
        assert!((travel_length(&ordered, Vec2::zeros()) - 22.0).abs() < 1e-12);
    }

    #[test]
    fn the_grid_finds_what_a_full_search_finds() {
        let mut seed = 7u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as f64 / f64::from(1u32 << 31) * 100.0
        };
        let drawing = lines(&(0..300).map(|_| [random(), random(), random(), random()]).collect::<Vec<_>>());
        let mut left = drawing.strokes.clone();
        let mut tool = Vec2::zeros();
        for stroke in nearest_first(drawing, tool).strokes {
            let nearest = left
                .iter()
                .flat_map(|s| [s.start(), s.end()])
                .map(|p| (p - tool).norm())
                .fold(f64::MAX, f64::min);
            assert!(((stroke.start() - tool).norm() - nearest).abs() < 1e-12);
            left.retain(|s| *s != stroke && s.reversed() != stroke);
            tool = stroke.end();
        }
        assert!(left.is_empty());
    }
}
