//! The walls of a maze as boxes.

use nalgebra::Vector2;

use crate::layout::Layout;

/// A place in the maze's frame \[m\]: from its lower left post, x to the right, y up.
pub type Place = Vector2<f64>;

/// An upright box, seen from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// Its lower left corner \[m\].
    pub lower: Place,
    /// Its upper right corner \[m\].
    pub upper: Place,
}

impl Wall {
    /// The nearest place of the box, edges and inside included.
    #[must_use]
    pub fn nearest(&self, to: &Place) -> Place {
        Place::new(to.x.clamp(self.lower.x, self.upper.x), to.y.clamp(self.lower.y, self.upper.y))
    }

    /// How far a place is from it \[m\]; 0 within it.
    #[must_use]
    pub fn distance(&self, to: &Place) -> f64 {
        (to - self.nearest(to)).norm()
    }
}

/// All walls of a maze, and which of them are near a place.
#[derive(Clone, Debug)]
pub struct Walls {
    boxes: Vec<Wall>,
    pitch: f64,
    columns: usize,
    rows: usize,
    /// Those within a pitch of each cell, and one cell around the maze.
    near: Vec<Vec<u32>>,
}

impl Walls {
    /// The walls of a maze whose posts are `pitch` apart, `thickness` thick \[m\]; walls in one line are one box. A post without walls is
    /// a box, too, except within the goal.
    #[must_use]
    pub fn of(maze: &Layout, pitch: f64, thickness: f64) -> Self {
        let half = Place::new(0.5 * thickness, 0.5 * thickness);
        let post = |x: usize, y: usize| Place::new(x as f64, y as f64) * pitch;
        let mut boxes = Vec::new();
        let mut lay = |from: Place, to: Place| boxes.push(Wall { lower: from - half, upper: to + half });
        let (columns, rows) = (maze.columns(), maze.rows());
        for y in 0..=rows {
            let mut from = None;
            for x in 0..=columns {
                match (maze.has_level(x, y), from) {
                    (true, None) => from = Some(x),
                    (false, Some(first)) => {
                        lay(post(first, y), post(x, y));
                        from = None;
                    }
                    (true, Some(_)) | (false, None) => {}
                }
            }
        }
        for x in 0..=columns {
            let mut from = None;
            for y in 0..=rows {
                match (maze.has_upright(x, y), from) {
                    (true, None) => from = Some(y),
                    (false, Some(first)) => {
                        lay(post(x, first), post(x, y));
                        from = None;
                    }
                    (true, Some(_)) | (false, None) => {}
                }
            }
        }
        let goal = maze.goal();
        for x in 0..=columns {
            for y in 0..=rows {
                let within = (goal.lower.0 + 1..=goal.upper.0).contains(&x)
                    && (goal.lower.1 + 1..=goal.upper.1).contains(&y);
                if maze.walls_at(x, y) == 0 && !within {
                    lay(post(x, y), post(x, y));
                }
            }
        }
        Self::indexed(boxes, pitch, [columns, rows])
    }

    /// Walls that are given as boxes, in a maze of this size \[m\]. They are looked up by squares of side `pitch` \[m\], > 0: choose about
    /// the width of a passage.
    #[must_use]
    pub fn of_boxes(boxes: Vec<Wall>, pitch: f64, size: [f64; 2]) -> Self {
        Self::indexed(boxes, pitch, size.map(|side| (side / pitch).ceil().clamp(1.0, 1e4) as usize))
    }

    fn indexed(boxes: Vec<Wall>, pitch: f64, [columns, rows]: [usize; 2]) -> Self {
        let mut near = vec![Vec::new(); (columns + 2) * (rows + 2)];
        for (number, wall) in boxes.iter().enumerate() {
            // Cell 0 is outside of the maze, to its left.
            let cells = |lower: f64, upper: f64, last: usize| {
                let first = (lower / pitch).floor().max(0.0) as usize;
                let end = ((upper / pitch).floor() as usize + 2).min(last + 1);
                first..=end
            };
            for x in cells(wall.lower.x, wall.upper.x, columns) {
                for y in cells(wall.lower.y, wall.upper.y, rows) {
                    near[y * (columns + 2) + x].push(number as u32);
                }
            }
        }
        Self { boxes, pitch, columns, rows, near }
    }

    /// All of them.
    #[must_use]
    pub fn boxes(&self) -> &[Wall] {
        &self.boxes
    }

    /// Posts are so far apart \[m\].
    #[must_use]
    pub const fn pitch(&self) -> f64 {
        self.pitch
    }

    /// The cell of the index of a place.
    pub(crate) fn cell(&self, at: &Place) -> (usize, usize) {
        let cell =
            |v: f64, last: usize| ((v / self.pitch).floor() + 1.0).clamp(0.0, last as f64 + 1.0) as usize;
        (cell(at.x, self.columns), cell(at.y, self.rows))
    }

    pub(crate) fn of_cell(&self, (x, y): (usize, usize)) -> &[u32] {
        &self.near[y * (self.columns + 2) + x]
    }

    /// The walls that may be within half a pitch of a place.
    pub fn near(&self, at: &Place) -> impl Iterator<Item = &Wall> {
        self.of_cell(self.cell(at)).iter().map(|number| &self.boxes[*number as usize])
    }

    /// How far the nearest wall is \[m\], at most half a pitch.
    #[must_use]
    pub fn clearance(&self, at: &Place) -> f64 {
        self.near(at).map(|wall| wall.distance(at)).fold(0.5 * self.pitch, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_in_one_line_are_one_box_and_the_index_finds_the_nearest() {
        let maze = Layout::random(16, 3);
        let walls = Walls::of(&maze, 0.025, 0.002);
        // The frame is four of them.
        let frame = walls.boxes().iter().filter(|wall| (wall.upper - wall.lower).max() > 0.4).count();
        assert_eq!(frame, 4);
        let mut chance = mrroc::random::Random::seeded(1);
        for _ in 0..2000 {
            let at = Place::new(0.2 + chance.within(0.215), 0.2 + chance.within(0.215));
            let all = walls.boxes().iter().map(|wall| wall.distance(&at)).fold(0.0125, f64::min);
            assert!((walls.clearance(&at) - all).abs() < 1e-15, "{at}");
        }
    }
}
