//! What is known of the panels between posts, once the spacing of the posts is learned.
//!
//! In: touches and moves of the ball. Out: for each panel whether it is wall, open or not known.

use crate::map::Map;
use crate::walls::Place;

/// A panel: whether it is upright, its line, its number along the line.
pub type Which = (bool, usize, usize);

/// What is known of a panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Panel {
    /// Neither touched nor passed.
    Unknown,
    /// Touched.
    Wall,
    /// The ball has passed it.
    Open,
}

/// So many touches of a panel as of a wall outweigh one move that went through it: an effector that is off by some millimetres may
/// have passed beside it.
const OUTWEIGH: u32 = 3;

/// The panels of a frame.
#[derive(Clone, Debug)]
pub struct Panels {
    /// Distance of posts \[m\].
    pub spacing: f64,
    /// Panels along x ..
    pub columns: usize,
    /// .. and along y.
    pub rows: usize,
    level: Vec<Panel>,
    upright: Vec<Panel>,
    /// How many touches were of a panel, level and upright.
    touches: [Vec<u32>; 2],
    /// How many touches before a panel tell not what was touched, level and upright.
    dear: [Vec<f64>; 2],
    /// Whether a body met a post where it tried a panel, level and upright.
    posts: [Vec<bool>; 2],
}

impl Panels {
    /// From what a map holds, with posts so far apart \[m\].
    #[must_use]
    pub fn of(map: &Map, spacing: f64) -> Self {
        let [width, height] = map.knowledge().size;
        let (columns, rows) = ((width / spacing).round() as usize, (height / spacing).round() as usize);
        let mut panels = Self {
            spacing,
            columns,
            rows,
            level: vec![Panel::Unknown; columns * (rows + 1)],
            upright: vec![Panel::Unknown; (columns + 1) * rows],
            touches: [vec![0; columns * (rows + 1)], vec![0; (columns + 1) * rows]],
            dear: [vec![0.0; columns * (rows + 1)], vec![0.0; (columns + 1) * rows]],
            posts: [vec![false; columns * (rows + 1)], vec![false; (columns + 1) * rows]],
        };
        for x in 0..columns {
            panels.level[x] = Panel::Wall;
            panels.level[rows * columns + x] = Panel::Wall;
        }
        for y in 0..rows {
            panels.upright[y * (columns + 1)] = Panel::Wall;
            panels.upright[y * (columns + 1) + columns] = Panel::Wall;
        }
        panels.touched(map);
        panels.passed(map);
        panels
    }

    fn touched(&mut self, map: &Map) {
        let known = map.knowledge();
        let (s, off) = (self.spacing, known.radius + 0.5 * known.thickness);
        let tolerance = 0.06 * s;
        for contact in map.contacts() {
            let ball = contact.ball;
            // How far it is from the nearest line, and from the nearest post along that line.
            let near = |v: f64| v - (v / s).round() * s;
            let (x, y) = (near(ball.x), near(ball.y));
            // A post alone would be touched from nearer.
            let half = 0.5 * known.thickness;
            let is_beside =
                (x.abs() - half).max(0.0).hypot((y.abs() - half).max(0.0)) > known.radius + 0.4 * tolerance;
            let is_seen = contact.moving == Place::zeros();
            let fits = |d: f64, moving: f64, into: f64| {
                let ahead = if is_seen { into != 0.0 } else { d * moving < 0.0 };
                is_beside && (d.abs() - off).abs() < tolerance && ahead
            };
            let upright = fits(x, contact.moving.x, contact.into.x);
            let level = fits(y, contact.moving.y, contact.into.y);
            let (cx, cy) = ((ball.x / s).max(0.0) as usize, (ball.y / s).max(0.0) as usize);
            let (kx, ky) = ((ball.x / s).round() as usize, (ball.y / s).round() as usize);
            match (upright, level) {
                (true, false) if kx <= self.columns && cy < self.rows => {
                    let index = self.index(true, kx, cy);
                    self.upright[index] = Panel::Wall;
                    self.touches[1][index] += 1;
                }
                (false, true) if ky <= self.rows && cx < self.columns => {
                    let index = self.index(false, ky, cx);
                    self.level[index] = Panel::Wall;
                    self.touches[0][index] += 1;
                }
                // Of what was seen near a post, it is not sure on which side of it.
                _ if is_seen => {}
                _ => {
                    // Whatever is ahead there is rather not tried again.
                    let ahead = ball + contact.moving.normalize() * (3.0 * off);
                    // Not straight before its middle: a body that met a corner there, see `Map::meet`.
                    let aside = (contact.at - ball - contact.into * known.radius).norm();
                    for (upright, line, cell) in self.crossings(&ball, &ahead) {
                        let index = self.index(upright, line, cell);
                        self.posts[usize::from(upright)][index] |= aside > 1e-9;
                        let dear = if upright { &mut self.dear[1] } else { &mut self.dear[0] };
                        dear[index] += 1.0;
                    }
                }
            }
        }
    }

    fn passed(&mut self, map: &Map) {
        let mut passes = self.touches.clone().map(|of| vec![0; of.len()]);
        for [from, to] in map.moves() {
            for (upright, line, cell) in self.crossings(from, to) {
                let index = self.index(upright, line, cell);
                let passes = &mut passes[usize::from(upright)][index];
                *passes += 1;
                if OUTWEIGH * *passes > self.touches[usize::from(upright)][index] {
                    if upright { self.upright[index] = Panel::Open } else { self.level[index] = Panel::Open }
                }
            }
        }
    }

    fn index(&self, upright: bool, line: usize, cell: usize) -> usize {
        if upright { cell * (self.columns + 1) + line } else { line * self.columns + cell }
    }

    /// The panels that a straight line crosses.
    pub fn crossings(&self, from: &Place, to: &Place) -> Vec<Which> {
        let s = self.spacing;
        let mut all = vec![];
        let mut along = |upright: bool, a: f64, b: f64, c: f64, d: f64, lines: usize, cells: usize| {
            let (low, high) = (a.min(b) / s, a.max(b) / s);
            let mut line = low.floor() + 1.0;
            while line <= high {
                let at = c + (d - c) * ((line * s - a) / (b - a));
                let cell = (at / s).floor();
                if line >= 0.0 && line <= lines as f64 && cell >= 0.0 && cell < cells as f64 {
                    all.push((upright, line as usize, cell as usize));
                }
                line += 1.0;
            }
        };
        along(true, from.x, to.x, from.y, to.y, self.columns, self.rows);
        along(false, from.y, to.y, from.x, to.x, self.rows, self.columns);
        all
    }

    /// A panel: whether it is upright, its line, its cell along the line.
    #[must_use]
    pub fn get(&self, (upright, line, cell): Which) -> Panel {
        let index = self.index(upright, line, cell);
        if upright { self.upright[index] } else { self.level[index] }
    }

    /// How many touches before a panel do not tell what was touched there.
    #[must_use]
    pub fn doubts(&self, (upright, line, cell): Which) -> f64 {
        self.dear[usize::from(upright)][self.index(upright, line, cell)]
    }

    /// Whether a body that tried a panel met a post instead.
    #[must_use]
    pub fn is_beside_a_post(&self, (upright, line, cell): Which) -> bool {
        self.posts[usize::from(upright)][self.index(upright, line, cell)]
    }

    /// The room of a place, by its column and row; the nearest one if it is outside.
    #[must_use]
    pub fn room(&self, at: &Place) -> (usize, usize) {
        let of = |v: f64, count: usize| ((v / self.spacing).max(0.0) as usize).min(count - 1);
        (of(at.x, self.columns), of(at.y, self.rows))
    }
}
