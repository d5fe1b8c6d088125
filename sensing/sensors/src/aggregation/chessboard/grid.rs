//! A grid of corners, from one saddle to the next along the edges between them.

use std::collections::BTreeMap;

use nalgebra::Vector2;

use super::grey::Smooth;
use super::saddles::{Saddle, apart, saddles};
use super::{Board, NoBoard};

/// How far an edge's direction may be from where the next corner is, and from that corner's edge \[rad\].
const TURN: f64 = 0.45;
/// How far a corner may be from where its neighbours foretell it, as a share of their distance.
const MISSED: f64 = 0.3;
/// So many of the sharpest saddles are tried as a beginning.
const SEEDS: usize = 200;

/// A place in a grid.
type Cell = [i32; 2];
/// Steps from a cell to its neighbours: along the first edge, along the second, and back.
const STEPS: [Cell; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

/// The corners of a board \[pixel\], in its order.
pub(super) fn seen(board: &Board, image: &Smooth) -> Result<Vec<Vector2<f64>>, NoBoard> {
    let saddles = saddles(image);
    let mut used = vec![false; saddles.len()];
    let mut largest: Option<Grid> = None;
    for seed in 0..saddles.len().min(SEEDS) {
        if used[seed] {
            continue;
        }
        let grid = Grid::grown(&saddles, seed);
        grid.0.values().for_each(|index| used[*index] = true);
        if let Some(corners) = grid.corners_of(board, &saddles) {
            return Ok(corners);
        }
        if largest.as_ref().is_none_or(|other| other.0.len() < grid.0.len()) {
            largest = Some(grid);
        }
    }
    let Some(grid) = largest.filter(|grid| grid.0.len() >= 6) else { return Err(NoBoard::Nothing) };
    let mut sides = grid.sides();
    sides.sort_unstable();
    let wanted = board.corners[0] * board.corners[1];
    Err(NoBoard::Other { found: grid.0.len(), across: sides[1], down: sides[0], wanted })
}

/// Saddles by their cells.
struct Grid(BTreeMap<Cell, usize>);

impl Grid {
    /// All corners that hang together with a first one.
    fn grown(saddles: &[Saddle], seed: usize) -> Self {
        let mut grid = Self(BTreeMap::from([([0, 0], seed)]));
        let mut rim = vec![[0, 0]];
        while let Some(cell) = rim.pop() {
            for towards in STEPS {
                let next = step(cell, towards);
                if grid.0.contains_key(&next) {
                    continue;
                }
                if let Some(index) = grid.neighbour(saddles, seed, cell, towards) {
                    grid.0.insert(next, index);
                    rim.insert(0, next);
                    // Others that had no neighbour may have one now.
                    rim.extend(
                        STEPS
                            .map(|towards| step(next, towards))
                            .into_iter()
                            .filter(|at| grid.0.contains_key(at)),
                    );
                }
            }
        }
        grid
    }

    /// The saddle beyond a corner, one step on.
    fn neighbour(&self, saddles: &[Saddle], seed: usize, cell: Cell, towards: Cell) -> Option<usize> {
        let here = &saddles[self.0[&cell]];
        let at = |cell: Cell| self.0.get(&cell).map(|index| saddles[*index].at);
        let step_from = |from: Cell, to: Cell| Some(at(to)? - at(from)?);
        // As far as on the other side, or as beside here.
        let across = [[towards[1], towards[0]], [-towards[1], -towards[0]]];
        let beside = across.iter().find_map(|by| {
            let side = step(cell, *by);
            step_from(side, step(side, towards))
        });
        let back = step_from(step(cell, [-towards[0], -towards[1]]), cell);
        let foretold = match (back, beside) {
            (Some(back), Some(beside)) => Some(0.5 * (back + beside)),
            (back, beside) => back.or(beside),
        };
        // Along which kind of edge it goes there: the kinds alternate from corner to corner.
        let along = usize::from(towards[0] == 0);
        let odd = (cell[0] + cell[1]).rem_euclid(2) as usize;
        let [own, other] = [along ^ odd, along ^ odd ^ 1];
        let fits = |next: &Saddle| {
            let angle = (next.at - here.at).y.atan2((next.at - here.at).x);
            apart(here.edges[own], angle).abs() < TURN
                && apart(next.edges[other], angle).abs() < TURN
                && apart(next.edges[own], here.edges[other]).abs() < TURN
        };
        let direction = || {
            // The seed's edges say which direction is which.
            let edge = saddles[seed].edges[along];
            let mut ahead = Vector2::new(edge.cos(), edge.sin());
            if towards[0] + towards[1] < 0 {
                ahead = -ahead;
            }
            ahead
        };
        let free = saddles.iter().enumerate().filter(|(index, _)| !self.0.values().any(|used| used == index));
        let off = |next: &Saddle| match foretold {
            Some(by) => {
                let off = (next.at - here.at - by).norm();
                (off < MISSED * by.norm()).then_some(off)
            }
            None => {
                let to = next.at - here.at;
                (to.dot(&direction()) > 0.0).then(|| to.norm())
            }
        };
        let near = free.filter_map(|(index, next)| Some((off(next)?, index)).filter(|_| fits(next)));
        near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, index)| index)
    }

    /// How many cells it has along both directions.
    fn sides(&self) -> [usize; 2] {
        [0, 1].map(|axis| {
            let along = || self.0.keys().map(|cell| cell[axis]);
            let (least, most) = (along().min().unwrap_or(0), along().max().unwrap_or(-1));
            (most - least + 1) as usize
        })
    }

    /// The corners of a board in its order, if they all are here, in one place alone.
    fn corners_of(&self, board: &Board, saddles: &[Saddle]) -> Option<Vec<Vector2<f64>>> {
        let wanted = board.corners.map(|n| n as i32);
        let mut found = Vec::new();
        for turned in [false, true] {
            let sides = if turned { [wanted[1], wanted[0]] } else { wanted };
            if turned && wanted[0] == wanted[1] {
                break;
            }
            for first in self.0.keys() {
                let all =
                    (0..sides[0]).all(|i| (0..sides[1]).all(|j| self.0.contains_key(&step(*first, [i, j]))));
                if all {
                    found.push((*first, turned));
                }
            }
        }
        let [(first, turned)] = found[..] else { return None };
        let [across, down] = wanted;
        let cell = |i: i32, j: i32| step(first, if turned { [j, i] } else { [i, j] });
        let at = |i: i32, j: i32| saddles[self.0[&cell(i, j)]].at;
        // From the image's u to its v as from the board's x to its y: a row is turned round otherwise.
        let (along, aside) = (at(across - 1, 0) - at(0, 0), at(0, down - 1) - at(0, 0));
        let mirrored = along.perp(&aside) < 0.0;
        let mirror = |i: i32, j: i32| if mirrored { (across - 1 - i, j) } else { (i, j) };
        let round = |i: i32, j: i32, about: bool| {
            let (i, j) = if about { (across - 1 - i, down - 1 - j) } else { (i, j) };
            mirror(i, j)
        };
        // The quarter towards the board's own corner: dark if, going round from the first edge on, bright comes after it.
        let dark_end = |about: bool| {
            let of = |i, j| {
                let (i, j) = round(i, j, about);
                (saddles[self.0[&cell(i, j)]], at(i, j))
            };
            let ((saddle, here), (_, right), (_, below)) = (of(0, 0), of(1, 0), of(0, 1));
            // In the quarter between the directions back, its first side in turn is that opposite to `right`.
            let back = here - right;
            let to_first = apart(saddle.edges[0], back.y.atan2(back.x)).abs();
            let down = here - below;
            let to_other = apart(saddle.edges[0], down.y.atan2(down.x)).abs();
            // Behind an edge of the first kind it is bright.
            to_first > to_other
        };
        let about = if board.has_ends() {
            !dark_end(false)
        } else {
            let from = |about| {
                let (i, j) = round(0, 0, about);
                at(i, j).norm_squared()
            };
            from(true) < from(false)
        };
        let corners = (0..down).flat_map(|j| (0..across).map(move |i| (i, j)));
        Some(corners.map(|(i, j)| round(i, j, about)).map(|(i, j)| at(i, j)).collect())
    }
}

fn step(from: Cell, by: Cell) -> Cell {
    [from[0] + by[0], from[1] + by[1]]
}
