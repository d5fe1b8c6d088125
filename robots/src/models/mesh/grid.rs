//! Levels of a solid on a grid, between which they are interpolated: what a search looks at, before a bound is proven.

use nalgebra::Vector3;

use super::solid::Solid;

/// Most nodes of a grid.
const NODES: f64 = 50_000.0;

/// Levels at the nodes of a grid around a solid, above `most` cut off.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    least: Vector3<f64>,
    /// Distance of two nodes \[m\].
    spacing: f64,
    counts: [usize; 3],
    levels: Vec<f32>,
    most: f64,
}

impl Grid {
    /// A grid over these bounds \[m\], no finer than `spacing` \[m\].
    pub(super) fn of(solid: &Solid, [least, most]: [Vector3<f64>; 2], spacing: f64) -> Self {
        let edges = most - least;
        // One more node on each side.
        let nodes = |edge: f64, step: f64| (edge / step).ceil() + 3.0;
        let mut step = spacing;
        while edges.map(|edge| nodes(edge, step)).product() > NODES {
            step *= 1.1;
        }
        let counts = [0, 1, 2].map(|axis| nodes(edges[axis], step) as usize);
        let least = least - Vector3::repeat(step);
        // Beyond the bounds a level is above 0; one cut off here is above what the search asks for.
        let cut = 2.0 * step;
        let mut levels = Vec::with_capacity(counts.iter().product());
        for z in 0..counts[2] {
            for y in 0..counts[1] {
                for x in 0..counts[0] {
                    let node = least + Vector3::new(x as f64, y as f64, z as f64) * step;
                    levels.push(solid.level_below(&node, cut).unwrap_or(cut) as f32);
                }
            }
        }
        Self { least, spacing: step, counts, levels, most: cut }
    }

    /// Distance of two nodes \[m\].
    pub(super) fn spacing(&self) -> f64 {
        self.spacing
    }

    /// The level at a point, about.
    pub(super) fn level(&self, point: &Vector3<f64>) -> f64 {
        let place = (point - self.least) / self.spacing;
        let mut cell = [0; 3];
        let mut part = [0.0; 3];
        for axis in 0..3 {
            let last = self.counts[axis] - 1;
            if !(place[axis] >= 0.0 && place[axis] <= last as f64) {
                return self.most;
            }
            cell[axis] = (place[axis] as usize).min(last - 1);
            part[axis] = place[axis] - cell[axis] as f64;
        }
        let at = |x: usize, y: usize, z: usize| {
            f64::from(self.levels[(z * self.counts[1] + y) * self.counts[0] + x])
        };
        let [x, y, z] = cell;
        let along = |y: usize, z: usize| at(x, y, z) * (1.0 - part[0]) + at(x + 1, y, z) * part[0];
        let across = |z: usize| along(y, z) * (1.0 - part[1]) + along(y + 1, z) * part[1];
        across(z) * (1.0 - part[2]) + across(z + 1) * part[2]
    }
}
