//! A height field: columns side by side, solid below their tops.
//!
//! In: the height of each cell of a grid. Out: the nearest column to a capsule or a ball, by a pyramid: each level has the
//! greatest height of two by two cells of the level below, so its columns hold those below, and what is farther from one
//! than what was found is left out. The distance is that of the columns, exactly: of a surface that lies below the tops of its
//! cells it is a lower bound, too small by the most that the surface lies below a top.

use mrroc::pose::Pose;
use nalgebra::Vector3;

use super::bounds::Bounds;
use super::error::ObstacleError;
use super::place::{gap_in, is_finite, seen_from};
use crate::clearance::gap::Gap;
use crate::models::Capsule;

/// The greatest heights of blocks of cells, row by row.
#[derive(Clone, Debug, PartialEq)]
struct Level {
    columns: usize,
    rows: usize,
    heights: Vec<f64>,
}

impl Level {
    /// The level of which each cell holds two by two of this one.
    fn above(&self) -> Level {
        let (columns, rows) = (self.columns.div_ceil(2), self.rows.div_ceil(2));
        let mut heights = vec![f64::NEG_INFINITY; columns * rows];
        for (index, height) in self.heights.iter().enumerate() {
            let (row, column) = (index / self.columns, index % self.columns);
            let highest = &mut heights[row / 2 * columns + column / 2];
            *highest = highest.max(*height);
        }
        Level { columns, rows, heights }
    }
}

/// A cell of a level of the pyramid.
#[derive(Clone, Copy)]
struct Cell {
    level: usize,
    column: usize,
    row: usize,
}

/// Columns side by side in a frame O: x along the rows of the grid, y across them, z up. Each is solid from its height down
/// without end; beside the grid there is nothing.
#[derive(Clone, PartialEq)]
pub struct HeightField {
    place: Pose,
    cell: f64,
    /// The cells as they were given, and above them ever coarser levels up to a single cell.
    levels: Vec<Level>,
}

impl core::fmt::Debug for HeightField {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let mut shown = f.debug_struct("HeightField");
        shown.field("X_WO", &self.place).field("cell", &self.cell);
        shown.field("columns", &self.columns()).field("rows", &self.rows()).finish_non_exhaustive()
    }
}

impl HeightField {
    /// The most cells that a height field may have.
    pub const MOST_CELLS: usize = 1 << 22;

    /// A height field whose frame O is at a corner of the grid, `X_WO` in the world, with cells of `cell` by `cell` \[m\],
    /// finite, > 0. Of `heights` \[m\] in O, finite, the first `columns` are the row along x at y = 0; each is the
    /// highest point in its cell.
    ///
    /// # Errors
    /// [`ObstacleError::BadPose`], [`ObstacleError::BadCell`], [`ObstacleError::BadGrid`], [`ObstacleError::BadHeight`].
    #[allow(non_snake_case)]
    pub fn new(X_WO: Pose, cell: f64, columns: usize, heights: Vec<f64>) -> Result<Self, ObstacleError> {
        if !is_finite(&X_WO) {
            return Err(ObstacleError::BadPose);
        }
        if !(cell.is_finite() && cell > 0.0) {
            return Err(ObstacleError::BadCell { cell });
        }
        let count = heights.len();
        if count == 0 || count > Self::MOST_CELLS || columns == 0 || !count.is_multiple_of(columns) {
            return Err(ObstacleError::BadGrid { heights: count, columns, most: Self::MOST_CELLS });
        }
        if let Some(index) = heights.iter().position(|height| !height.is_finite()) {
            let (row, column) = (index / columns, index % columns);
            return Err(ObstacleError::BadHeight { column, row, height: heights[index] });
        }
        let mut last = Level { columns, rows: count / columns, heights };
        let mut levels = Vec::new();
        while last.heights.len() > 1 {
            let above = last.above();
            levels.push(core::mem::replace(&mut last, above));
        }
        levels.push(last);
        Ok(Self { place: X_WO, cell, levels })
    }

    /// The corner of the grid, with x along its rows and z up: `X_WO`.
    #[must_use]
    pub const fn place(&self) -> &Pose {
        &self.place
    }

    /// The edge of a cell \[m\].
    #[must_use]
    pub const fn cell(&self) -> f64 {
        self.cell
    }

    /// How many cells it has along x.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.levels[0].columns
    }

    /// How many cells it has along y.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.levels[0].rows
    }

    /// The heights \[m\] in O, row by row.
    #[must_use]
    pub fn heights(&self) -> &[f64] {
        &self.levels[0].heights
    }

    /// Memory that it takes \[bytes\].
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|level| size_of_val(&*level.heights)).sum()
    }

    /// Whether a ball of `radius` \[m\], >= 0, around `centre` \[m\] in the world touches no column.
    #[must_use]
    pub fn is_clear(&self, centre: &Vector3<f64>, radius: f64) -> bool {
        let centre = seen_from(&self.place, centre);
        // On the level on which the ball lies in at most two cells along each axis.
        let mut level = 0;
        let mut edge = self.cell;
        while edge < 2.0 * radius && level + 1 < self.levels.len() {
            level += 1;
            edge *= 2.0;
        }
        let Level { columns, rows, .. } = &self.levels[level];
        let reached = |middle: f64, count: usize| {
            // A cast brings what is below 0 to 0.
            let [first, last] = [middle - radius, middle + radius].map(|x| (x / edge).floor() as usize);
            first.min(count - 1)..=last.min(count - 1)
        };
        let squared = radius * radius;
        let mut cells = reached(centre.y, *rows)
            .flat_map(|row| reached(centre.x, *columns).map(move |column| Cell { level, column, row }));
        !cells.any(|cell| self.is_within(cell, &centre, squared))
    }

    /// Whether a column below this cell is within a squared distance \[m²\] of a point.
    fn is_within(&self, cell: Cell, point: &Vector3<f64>, squared: f64) -> bool {
        if self.column(cell).distance_squared(point) > squared {
            return false;
        }
        cell.level == 0 || self.below(cell).any(|cell| self.is_within(cell, point, squared))
    }

    /// The distance of `centre` \[m\] in the world from the nearest column, 0 inside one; `most` \[m\] if none is nearer.
    #[must_use]
    pub fn distance(&self, centre: &Vector3<f64>, most: f64) -> f64 {
        let centre = seen_from(&self.place, centre);
        let mut best = (most * most, None);
        self.search(self.top(), &[centre, centre], &mut best);
        best.1.map_or(most, |[p, q]: [Vector3<f64>; 2]| (p - q).norm())
    }

    /// The gap to a capsule, whose point comes first. If its segment meets a column, the distance is the negative radius.
    #[must_use]
    pub fn gap(&self, capsule: &Capsule) -> Gap {
        // None is found only for a capsule that is not finite: it counts as meeting the field.
        let meets = || Gap { distance: -capsule.radius, points: [capsule.ends[0]; 2] };
        self.gap_below(capsule, f64::INFINITY).unwrap_or_else(meets)
    }

    /// The gap to a capsule, whose point comes first, if its distance is less than `most` \[m\].
    pub(super) fn gap_below(&self, capsule: &Capsule, most: f64) -> Option<Gap> {
        let reach = most + capsule.radius;
        if reach < 0.0 {
            return None;
        }
        let mut best = (reach * reach, None);
        self.search(self.top(), &capsule.ends.map(|end| seen_from(&self.place, &end)), &mut best);
        best.1.map(|points| gap_in(&self.place, points, capsule.radius))
    }

    /// Whether all columns are farther away from a capsule than `margin` \[m\].
    pub(super) fn capsule_clear(&self, capsule: &Capsule, margin: f64) -> bool {
        let segment = capsule.ends.map(|end| seen_from(&self.place, &end));
        let reach = capsule.radius + margin;
        !self.is_near(self.top(), &segment, reach * reach)
    }

    /// Whether a column below this cell is within a squared distance \[m²\] of a segment.
    fn is_near(&self, cell: Cell, segment: &[Vector3<f64>; 2], squared: f64) -> bool {
        let column = self.column(cell);
        if column.distance_squared(&column.nearest_of(segment)) > squared {
            return false;
        }
        cell.level == 0 || self.below(cell).any(|cell| self.is_near(cell, segment, squared))
    }

    /// Brings the nearest points of a segment and of the columns below a cell to `best`, if they are nearer.
    fn search(&self, cell: Cell, segment: &[Vector3<f64>; 2], best: &mut (f64, Option<[Vector3<f64>; 2]>)) {
        if cell.level == 0 {
            let column = self.column(cell);
            let p = column.nearest_of(segment);
            let q = column.onto(&p);
            let squared = (p - q).norm_squared();
            if squared < best.0 {
                *best = (squared, Some([p, q]));
            }
            return;
        }
        let mut found = [(f64::INFINITY, cell); 4];
        let mut count = 0;
        for below in self.below(cell) {
            let column = self.column(below);
            found[count] = (column.distance_squared(&column.nearest_of(segment)), below);
            count += 1;
        }
        let found = &mut found[..count];
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        for (squared, below) in found {
            if *squared < best.0 {
                self.search(*below, segment, best);
            }
        }
    }

    /// The one cell of the coarsest level.
    fn top(&self) -> Cell {
        Cell { level: self.levels.len() - 1, column: 0, row: 0 }
    }

    /// The cells that make up one of a coarser level.
    fn below(&self, cell: Cell) -> impl Iterator<Item = Cell> + use<> {
        let level = cell.level - 1;
        let Level { columns, rows, .. } = self.levels[level];
        let pair = |first: usize, count: usize| 2 * first..(2 * first + 2).min(count);
        pair(cell.row, rows)
            .flat_map(move |row| pair(cell.column, columns).map(move |column| Cell { level, column, row }))
    }

    /// All that is solid in a cell, and with a coarser cell what lies between its columns.
    fn column(&self, cell: Cell) -> Bounds {
        let size = 1 << cell.level;
        let edges = |first: usize, count: usize| {
            [first * size, ((first + 1) * size).min(count)].map(|index| index as f64 * self.cell)
        };
        let ([x, far_x], [y, far_y]) = (edges(cell.column, self.columns()), edges(cell.row, self.rows()));
        let level = &self.levels[cell.level];
        let height = level.heights[cell.row * level.columns + cell.column];
        Bounds { low: Vector3::new(x, y, f64::NEG_INFINITY), high: Vector3::new(far_x, far_y, height) }
    }

    /// The box around it in the world, infinite where it has no end.
    pub(super) fn bounds(&self) -> Bounds {
        let lowest = self.heights().iter().copied().fold(f64::INFINITY, f64::min);
        let mut all = self.column(self.top());
        all.low.z = lowest;
        let mut all = all.moved(&self.place);
        let down = self.place.rotation * -Vector3::z();
        for axis in 0..3 {
            // What round-off makes of 0 points nowhere.
            if down[axis] > 1e-12 {
                all.high[axis] = f64::INFINITY;
            } else if down[axis] < -1e-12 {
                all.low[axis] = f64::NEG_INFINITY;
            }
        }
        all
    }
}
