//! The plate as a height map, carved by the tool along the executed tip points.
//!
//! A cell keeps the lowest height that the tool's envelope had over it: for a tip at depth `z` and a cell at distance
//! `d` from the path the height is `z + profile(d)`. Points closer together than a few cells are merged, so that
//! carving costs a fraction of a microsecond for each step of 2 ms.

use crate::placement::Plate;

/// The tip of the tool in plate coordinates \[mm\]; z = 0 is the surface, z < 0 is in the material.
pub type Tip = nalgebra::Vector3<f64>;

/// The shape of the tool's end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cutter {
    /// A pointed tool with this full angle \[rad\], 0..π.
    Vee {
        /// Full angle of the tip \[rad\].
        angle: f64,
    },
    /// A ball of this radius \[mm\], > 0.
    Ball {
        /// Radius \[mm\].
        radius: f64,
    },
}

impl Default for Cutter {
    /// A V of 90 degrees.
    fn default() -> Self {
        Self::Vee { angle: std::f64::consts::FRAC_PI_2 }
    }
}

impl Cutter {
    /// Half the width that a tip `depth` \[mm\] below the surface cuts \[mm\].
    #[must_use]
    pub fn half_width(&self, depth: f64) -> f64 {
        let depth = depth.max(0.0);
        match *self {
            Self::Vee { angle } => depth * (angle / 2.0).tan(),
            Self::Ball { radius } if depth >= radius => radius,
            Self::Ball { radius } => (depth * (2.0 * radius - depth)).sqrt(),
        }
    }
}

/// The surface of the plate in square cells.
#[derive(Clone, Debug)]
pub struct HeightMap {
    columns: usize,
    rows: usize,
    cell: f64,
    heights: Vec<f32>,
    cutter: Cutter,
    /// Where the segment that is being merged began.
    anchor: Option<Tip>,
    latest: Option<Tip>,
}

/// Segments are cut when they are this many cells long.
const MERGED_CELLS: f64 = 3.0;

/// The most cells of a map: 96 MB.
const MOST_CELLS: f64 = 24e6;

impl HeightMap {
    /// A flat plate with cells of about `cell` \[mm\]; larger ones where the plate would need too many.
    #[must_use]
    pub fn new(plate: &Plate, cell: f64, cutter: Cutter) -> Self {
        let cell = cell.max((plate.width * plate.height / MOST_CELLS).sqrt());
        let columns = (plate.width / cell).ceil().max(1.0) as usize;
        let rows = (plate.height / cell).ceil().max(1.0) as usize;
        let heights = vec![0.0; columns * rows];
        Self { columns, rows, cell, heights, cutter, anchor: None, latest: None }
    }

    /// Size of a cell \[mm\].
    #[must_use]
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// Number of columns and rows.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.columns, self.rows)
    }

    /// The height of a cell \[mm\], <= 0; 0 outside the plate. Row 0 is the lowest.
    #[must_use]
    pub fn height(&self, column: isize, row: isize) -> f32 {
        let inside =
            column >= 0 && row >= 0 && (column as usize) < self.columns && (row as usize) < self.rows;
        if inside { self.heights[row as usize * self.columns + column as usize] } else { 0.0 }
    }

    /// The deepest cell \[mm\], <= 0.
    #[must_use]
    pub fn deepest(&self) -> f32 {
        self.heights.iter().fold(0.0, |a, b| a.min(*b))
    }

    /// The tool's tip has moved here in a straight line from where it was.
    pub fn move_to(&mut self, tip: Tip) {
        let (Some(anchor), Some(latest)) = (self.anchor, self.latest) else {
            (self.anchor, self.latest) = (Some(tip), Some(tip));
            return;
        };
        if anchor.z >= 0.0 && latest.z >= 0.0 && tip.z >= 0.0 {
            (self.anchor, self.latest) = (Some(tip), Some(tip));
            return;
        }
        self.latest = Some(tip);
        let merged = MERGED_CELLS * self.cell;
        if (tip - anchor).norm_squared() >= merged * merged {
            self.cut(anchor, tip);
            self.anchor = Some(tip);
        }
    }

    /// Cuts what is still merged: call it after the last point.
    pub fn finish(&mut self) {
        if let (Some(anchor), Some(latest)) = (self.anchor, self.latest) {
            self.cut(anchor, latest);
        }
        (self.anchor, self.latest) = (None, None);
    }

    /// Lowers all cells under the tool between two tips.
    fn cut(&mut self, a: Tip, b: Tip) {
        let reach = self.cutter.half_width(-a.z.min(b.z));
        if reach <= 0.0 && a.z.min(b.z) >= 0.0 {
            return;
        }
        let range = |low: f64, high: f64, count: usize| {
            let first = ((low - reach) / self.cell).floor().max(0.0) as usize;
            let last = ((high + reach) / self.cell).ceil().max(0.0) as usize;
            first.min(count)..last.min(count)
        };
        let columns = range(a.x.min(b.x), a.x.max(b.x), self.columns);
        let rows = range(a.y.min(b.y), a.y.max(b.y), self.rows);
        let along = b - a;
        let squared = along.x * along.x + along.y * along.y;
        // Straight down or up the lower end cuts most, wherever the nearest place of the path is: that is a matter of
        // micrometres.
        let steep = along.z * along.z > 100.0 * squared;
        let inverse = if squared > 0.0 && !steep { 1.0 / squared } else { 0.0 };
        let lower = if steep && along.z < 0.0 { 1.0 } else { 0.0 };
        let (ax, ay, az) = (a.x as f32, a.y as f32, a.z as f32);
        let (dx, dy, dz) = (along.x as f32, along.y as f32, along.z as f32);
        let (inverse, cell) = (inverse as f32, self.cell as f32);
        for row in rows {
            let y = (row as f32 + 0.5) * cell - ay;
            let line = &mut self.heights[row * self.columns..][columns.clone()];
            let first = columns.start as f32 + 0.5;
            // The tip's depth and the cell's distance from the path, cell by cell.
            let tip = |i: usize| {
                let x = (first + i as f32) * cell - ax;
                let t = ((x * dx + y * dy) * inverse + lower).clamp(0.0, 1.0);
                let (gx, gy) = (x - dx * t, y - dy * t);
                (az + dz * t, gx * gx + gy * gy)
            };
            match self.cutter {
                Cutter::Vee { angle } => {
                    let steepness = (1.0 / (angle / 2.0).tan()) as f32;
                    for (i, height) in line.iter_mut().enumerate() {
                        let (z, squared) = tip(i);
                        *height = height.min(z + squared.sqrt() * steepness);
                    }
                }
                Cutter::Ball { radius } => {
                    let r = radius as f32;
                    for (i, height) in line.iter_mut().enumerate() {
                        let (z, squared) = tip(i);
                        if squared < r * r {
                            *height = height.min(z + r - (r * r - squared).sqrt());
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plate() -> Plate {
        Plate { width: 20.0, height: 10.0, margin: 0.0 }
    }

    #[test]
    fn a_vee_leaves_its_profile() {
        let mut map = HeightMap::new(&plate(), 0.05, Cutter::default());
        for k in 0..=3000 {
            map.move_to(Tip::new(2.0 + f64::from(k) * 0.005, 5.025, -0.5));
        }
        map.finish();
        for (off, expected) in [(0, -0.5), (2, -0.4), (8, -0.1), (12, 0.0), (-4, -0.3)] {
            let found = map.height(200, 100 + off);
            assert!((found - expected).abs() < 1e-3, "{found} for {expected}");
        }
        assert!((map.deepest() + 0.5).abs() < 1e-3);
        assert_eq!(map.height(10, 100), 0.0);
    }

    #[test]
    fn a_ball_leaves_a_round_groove_and_travel_leaves_nothing() {
        let mut map = HeightMap::new(&plate(), 0.05, Cutter::Ball { radius: 1.0 });
        map.move_to(Tip::new(1.0, 5.025, 2.0));
        map.move_to(Tip::new(19.0, 5.025, 2.0));
        assert_eq!(map.deepest(), 0.0);
        map.move_to(Tip::new(19.0, 5.025, -0.4));
        map.move_to(Tip::new(1.0, 5.025, -0.4));
        map.finish();
        // At half the groove's width: -0.4 + 1 - sqrt(1 - 0.25).
        assert!((f64::from(map.height(200, 110)) - (0.6 - 0.75f64.sqrt())).abs() < 1e-3);
        assert!((map.cutter.half_width(0.4) - 0.8).abs() < 1e-12);
    }

    #[test]
    fn a_plunge_leaves_the_shape_of_the_tool() {
        let mut map = HeightMap::new(&plate(), 0.05, Cutter::Ball { radius: 1.0 });
        // The arm shakes by a few micrometres while it goes down.
        for k in 0..=400 {
            let shake = 2e-6 * f64::from(k % 7);
            map.move_to(Tip::new(5.025 + shake, 5.025 - shake, 1.0 - f64::from(k) * 0.005));
        }
        map.finish();
        for (off, expected) in [(0, -1.0), (4, -(1.0f64 - 0.04).sqrt()), (-8, -(1.0f64 - 0.16).sqrt())] {
            for (column, row) in [(100 + off, 100), (100, 100 + off)] {
                let found = f64::from(map.height(column, row));
                assert!((found - expected).abs() < 1e-3, "{found} for {expected} at {off}");
            }
        }
    }
}
