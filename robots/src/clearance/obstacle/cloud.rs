//! A cloud of points, such as a camera or a scanner sees: each stands for a ball.
//!
//! In: points in the world and the radius of the balls. Out: the nearest of them to a capsule or a ball, exactly, by a tree of
//! boxes over blocks of eight. Points are kept in single precision; the radius grows by what that may shift them, so no
//! point reaches beyond what is kept.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::bounds::Bounds;
use super::error::ObstacleError;
use super::tree::Tree;
use crate::clearance::gap::Gap;
use crate::models::Capsule;

/// Points in a block.
const BLOCK: usize = 8;

/// The coordinates of a block's points; those that the last block lacks are those of its first.
type Block = [[f32; BLOCK]; 3];

/// Points, each the centre of a ball of one radius, in the world. It is built once and does not move.
#[derive(Clone, PartialEq)]
pub struct Cloud {
    blocks: Vec<Block>,
    tree: Tree,
    points: usize,
    radius: f64,
}

impl core::fmt::Debug for Cloud {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Cloud")
            .field("points", &self.points)
            .field("radius", &self.radius)
            .finish_non_exhaustive()
    }
}

impl Cloud {
    /// The most points that a cloud may have.
    pub const MOST_POINTS: usize = 1 << 22;

    /// A cloud of `points` \[m\] in the world, each the centre of a ball of `radius` \[m\], finite, > 0: more than
    /// half the distance of neighbours on a surface, and the error of their measurement.
    ///
    /// # Errors
    /// [`ObstacleError::EmptyCloud`], [`ObstacleError::TooManyPoints`], [`ObstacleError::BadPoint`],
    /// [`ObstacleError::BadRadius`].
    pub fn new(points: &[Vector3<f64>], radius: f64) -> Result<Self, ObstacleError> {
        check(points, radius)?;
        if points.len() > Self::MOST_POINTS {
            return Err(ObstacleError::TooManyPoints { points: points.len(), most: Self::MOST_POINTS });
        }
        #[expect(clippy::cast_possible_truncation, reason = "the radius grows by what is lost")]
        let kept: Vec<[f32; 3]> = points.iter().map(|p| [p.x as f32, p.y as f32, p.z as f32]).collect();
        let shifts = points.iter().zip(&kept).map(|(p, near)| (p - wide(near)).norm());
        let shift = shifts.fold(0.0, f64::max);
        let boxes: Vec<_> = kept.iter().map(|p| Bounds { low: wide(p), high: wide(p) }).collect();
        let (tree, order) = Tree::over(&boxes, BLOCK);
        let block = |indices: &[u32]| -> Block {
            let of = |place: usize| kept[indices[if place < indices.len() { place } else { 0 }] as usize];
            core::array::from_fn(|axis| core::array::from_fn(|place| of(place)[axis]))
        };
        let blocks = order.chunks(BLOCK).map(block).collect();
        Ok(Self { blocks, tree, points: points.len(), radius: radius + shift })
    }

    /// As [`new`](Self::new), with one point for all that lie in a cell of `cell` \[m\], finite, > 0: their mean. The
    /// [`radius`](Self::radius) grows by the distance of the farthest point from its mean, so that nothing is lost.
    ///
    /// # Errors
    /// As of [`new`](Self::new), of the points that are left, and [`ObstacleError::BadCell`].
    pub fn thinned(points: &[Vector3<f64>], radius: f64, cell: f64) -> Result<Self, ObstacleError> {
        check(points, radius)?;
        if !(cell.is_finite() && cell > 0.0) {
            return Err(ObstacleError::BadCell { cell });
        }
        let mut cells: BTreeMap<[i64; 3], Vec<&Vector3<f64>>> = BTreeMap::new();
        for point in points {
            #[expect(clippy::cast_possible_truncation, reason = "what is beyond comes into the last cell")]
            let key = [point.x, point.y, point.z].map(|x| (x / cell).floor() as i64);
            cells.entry(key).or_default().push(point);
        }
        let mut grown: f64 = 0.0;
        let means = cells.values().map(|points| {
            let mean = points.iter().copied().sum::<Vector3<f64>>() / points.len() as f64;
            grown = points.iter().fold(grown, |far, point| far.max((*point - mean).norm()));
            mean
        });
        let means: Vec<_> = means.collect();
        Self::new(&means, radius + grown)
    }

    /// How many points it keeps.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.points
    }

    /// Always false: an empty cloud is refused.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.points == 0
    }

    /// What each of its points stands for \[m\]: the radius that was given, and what rounding and thinning may have moved a point.
    #[must_use]
    pub const fn radius(&self) -> f64 {
        self.radius
    }

    /// The points that it keeps \[m\], in an order of their own.
    pub fn points(&self) -> impl Iterator<Item = Vector3<f64>> {
        let all = self.blocks.iter().flat_map(|block| (0..BLOCK).map(move |place| point(block, place)));
        all.take(self.points)
    }

    /// Memory that it takes \[bytes\].
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.blocks) + self.tree.bytes()
    }

    /// Whether a ball of `radius` \[m\], >= 0, around `centre` \[m\] touches none of its balls.
    #[must_use]
    pub fn is_clear(&self, centre: &Vector3<f64>, radius: f64) -> bool {
        let reach = radius + self.radius;
        let squared = reach * reach;
        !self.tree.any(centre, reach, &mut |block| {
            distances_squared(&self.blocks[block], centre).iter().any(|distance| *distance <= squared)
        })
    }

    /// The distance of `centre` \[m\] from the nearest of its balls, below 0 inside one; `most` \[m\] if none is nearer
    /// than that, which may be infinite and makes the search short if it is small.
    #[must_use]
    pub fn distance(&self, centre: &Vector3<f64>, most: f64) -> f64 {
        let least = self.tree.nearest(&[*centre, *centre], most + self.radius, &mut |block, least| {
            let distances = distances_squared(&self.blocks[block], centre);
            least.min(distances.into_iter().fold(f64::INFINITY, f64::min).sqrt())
        });
        (least - self.radius).min(most)
    }

    /// The gap to a capsule, whose point comes first.
    #[must_use]
    pub fn gap(&self, capsule: &Capsule) -> Gap {
        // None is found only for a capsule that is not finite.
        let any =
            || Gap::between([capsule.ends[0], point(&self.blocks[0], 0)], [capsule.radius, self.radius]);
        self.gap_below(capsule, f64::INFINITY).unwrap_or_else(any)
    }

    /// The gap to a capsule, whose point comes first, if its distance is less than `most` \[m\].
    pub(super) fn gap_below(&self, capsule: &Capsule, most: f64) -> Option<Gap> {
        let [a, b] = &capsule.ends;
        let d = b - a;
        let length = d.norm_squared();
        let mut best = None;
        self.tree.nearest(&capsule.ends, most + capsule.radius + self.radius, &mut |block, mut least| {
            for place in 0..BLOCK {
                let p = point(&self.blocks[block], place);
                let part = if length > 0.0 { (d.dot(&(p - a)) / length).clamp(0.0, 1.0) } else { 0.0 };
                let on = a + d * part;
                let distance = (on - p).norm();
                if distance < least {
                    (least, best) = (distance, Some([on, p]));
                }
            }
            least
        });
        best.map(|points| Gap::between(points, [capsule.radius, self.radius]))
    }

    /// Whether all of its balls are farther away from a capsule than `margin` \[m\].
    pub(super) fn capsule_clear(&self, capsule: &Capsule, margin: f64) -> bool {
        let reach = capsule.radius + margin + self.radius;
        let core = Capsule { radius: 0.0, ..*capsule };
        let found = self.tree.nearest(&capsule.ends, reach, &mut |block, least| {
            let mut points = (0..BLOCK).map(|place| point(&self.blocks[block], place));
            let is_near = points.any(|point| core.distance(&point) <= reach);
            if is_near { f64::NEG_INFINITY } else { least }
        });
        found > f64::NEG_INFINITY
    }

    pub(super) fn bounds(&self) -> Bounds {
        let points = self.tree.whole();
        Bounds { low: points.low.add_scalar(-self.radius), high: points.high.add_scalar(self.radius) }
    }
}

/// A point in single precision.
fn wide(p: &[f32; 3]) -> Vector3<f64> {
    Vector3::from(p.map(f64::from))
}

fn point(block: &Block, place: usize) -> Vector3<f64> {
    wide(&[block[0][place], block[1][place], block[2][place]])
}

/// The squared distances of a block's points from `centre` \[m²\].
fn distances_squared(block: &Block, centre: &Vector3<f64>) -> [f64; BLOCK] {
    let mut sum = [0.0; BLOCK];
    for (axis, coordinates) in block.iter().enumerate() {
        for (sum, x) in sum.iter_mut().zip(coordinates) {
            let apart = f64::from(*x) - centre[axis];
            *sum += apart * apart;
        }
    }
    sum
}

/// Refuses no points, points that are not finite in single precision, and a radius that makes no balls.
fn check(points: &[Vector3<f64>], radius: f64) -> Result<(), ObstacleError> {
    if points.is_empty() {
        return Err(ObstacleError::EmptyCloud);
    }
    if !(radius.is_finite() && radius > 0.0) {
        return Err(ObstacleError::BadRadius { radius });
    }
    // NaN is not below the limit either.
    let is_good = |point: &Vector3<f64>| point.iter().all(|x| x.abs() < f64::from(f32::MAX));
    match points.iter().position(|point| !is_good(point)) {
        Some(index) => Err(ObstacleError::BadPoint { index, point: points[index] }),
        None => Ok(()),
    }
}
