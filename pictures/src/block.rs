//! A body that robots handle, drawn as a block.
//!
//! In: its edges, and its pose whenever a robot is observed. Out: at most [`CAPACITY`] poses, evenly spaced; the block's
//! six faces, at rest or animated, seen through.

use std::fmt;

use mrroc::pose::Pose;
use nalgebra::Vector3;

use crate::playback::Playback;
use crate::projection::Projection;
use crate::svg::palette::{BLOCK, RULE};
use crate::svg::{Look, Svg};

/// The most poses kept.
const CAPACITY: usize = 4000;

/// Time between poses to begin with \[s\].
const FIRST_GAP: f64 = 2e-3;

/// The corners of the faces, by the bits of their places along x, y, z.
pub(crate) const FACES: [[usize; 4]; 6] =
    [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];

/// A block and its path.
pub(crate) struct Block {
    /// Along x, y, z of its frame, which lies in its middle \[m\].
    edges: [f64; 3],
    /// Where it is now, `X_WB`.
    now: Box<dyn FnMut() -> Pose>,
    times: Vec<f64>,
    poses: Vec<Pose>,
    gap: f64,
}

impl fmt::Debug for Block {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Block").field("edges", &self.edges).field("poses", &self.poses.len()).finish()
    }
}

impl Block {
    pub fn new(edges: [f64; 3], now: Box<dyn FnMut() -> Pose>) -> Block {
        Block { edges, now, times: Vec::new(), poses: Vec::new(), gap: FIRST_GAP }
    }

    /// A robot was observed at `time` \[s\].
    pub fn observe(&mut self, time: f64) {
        // Half a gap less, so that rounding does not cost a pose.
        if self.times.last().is_some_and(|last| time < last + self.gap - 0.5 * FIRST_GAP) {
            return;
        }
        self.times.push(time);
        self.poses.push((self.now)());
        if self.times.len() > CAPACITY {
            let every_other = |i: &mut usize| {
                *i += 1;
                *i % 2 == 1
            };
            let mut time = 0;
            self.times.retain(|_| every_other(&mut time));
            let mut pose = 0;
            self.poses.retain(|_| every_other(&mut pose));
            self.gap *= 2.0;
        }
    }

    /// The pose seen last before `time` \[s\], or first.
    fn at(&self, time: f64) -> Option<&Pose> {
        let after = self.times.partition_point(|t| *t <= time);
        self.poses.get(after.saturating_sub(1))
    }

    fn corners(&self, pose: &Pose) -> [Vector3<f64>; 8] {
        std::array::from_fn(|i| {
            let side = |axis: usize| if i >> axis & 1 == 0 { -0.5 } else { 0.5 };
            let corner = Vector3::from_fn(|axis, _| side(axis) * self.edges[axis]);
            (pose * nalgebra::Point3::from(corner)).coords
        })
    }

    /// The corners of all poses kept \[m\], those that are numbers.
    pub fn points(&self) -> impl Iterator<Item = Vector3<f64>> + '_ {
        let corners = self.poses.iter().flat_map(|pose| self.corners(pose));
        corners.filter(|corner| corner.iter().all(|x| x.is_finite()))
    }

    /// The block at a time \[s\], or animated where a clock is given.
    pub fn draw(&self, svg: &mut Svg, on: &Projection, time: f64, playback: Option<&Playback>) {
        let Some(first) = self.at(time) else { return };
        let corners = |pose: &Pose, face: &[usize; 4]| {
            let corners = self.corners(pose);
            face.map(|corner| on.at(corners[corner]))
        };
        // What never moves is less to look at.
        let look = match self.moved() {
            true => Look::filled(BLOCK).fill_opacity(0.3).stroke(BLOCK),
            false => Look::filled(RULE).fill_opacity(0.15).stroke(RULE),
        };
        svg.group(look.class("block").width(1.0).round(), |svg| {
            for face in &FACES {
                let Some(playback) = playback else {
                    svg.polygon(&corners(first, face), Look::new());
                    continue;
                };
                let points = svg.points(&corners(first, face)).to_string();
                svg.containing("polygon", format_args!(" points=\"{points}\""), |svg| {
                    let poses = playback.times().filter_map(|time| self.at(time));
                    let points: Vec<String> =
                        poses.map(|pose| svg.points(&corners(pose, face)).to_string()).collect();
                    playback.animate(svg, "points", points);
                });
            }
        });
    }

    /// Whether it moved at all.
    pub fn moved(&self) -> bool {
        self.poses.windows(2).any(|w| w[0] != w[1])
    }

    /// When it was seen first and last \[s\].
    pub fn run(&self) -> Option<(f64, f64)> {
        Some((*self.times.first()?, *self.times.last()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_has_its_corners_where_its_edges_say_and_its_memory_is_bounded() {
        let mut x = 0.0;
        let mut block = Block::new(
            [0.4, 0.2, 0.1],
            Box::new(move || {
                x += 1.0;
                Pose::translation(x, 0.0, 0.0)
            }),
        );
        for i in 0..20_000 {
            block.observe(f64::from(i) * 2e-3);
        }
        assert!(block.poses.len() <= CAPACITY && block.poses.len() > CAPACITY / 2);
        let corners = block.corners(&Pose::translation(1.0, 2.0, 3.0));
        assert!((corners[0] - Vector3::new(0.8, 1.9, 2.95)).norm() < 1e-12);
        assert!((corners[7] - Vector3::new(1.2, 2.1, 3.05)).norm() < 1e-12);
        assert_eq!(block.at(-1.0), Some(&Pose::translation(1.0, 0.0, 0.0)));
    }
}
