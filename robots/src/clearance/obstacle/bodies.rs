//! Many capsules as one obstacle: what covers a mesh.

use nalgebra::Vector3;

use super::bounds::Bounds;
use super::error::ObstacleError;
use super::tree::Tree;
use crate::clearance::gap::Gap;
use crate::models::Capsule;

/// Capsules that stand still together, in the world. A query looks at a few of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Bodies {
    /// In the order of the tree, one in each block.
    capsules: Vec<Capsule>,
    tree: Tree,
}

impl Bodies {
    /// The most capsules that one obstacle may have.
    pub const MOST: usize = 1 << 20;

    /// One obstacle of capsules in the world, at least one and [`MOST`](Self::MOST) at most.
    ///
    /// # Errors
    /// [`ObstacleError::NoCapsules`], [`ObstacleError::TooManyCapsules`], [`ObstacleError::BadCapsule`].
    pub fn new(capsules: &[Capsule]) -> Result<Self, ObstacleError> {
        if capsules.is_empty() {
            return Err(ObstacleError::NoCapsules);
        }
        if capsules.len() > Self::MOST {
            return Err(ObstacleError::TooManyCapsules { capsules: capsules.len(), most: Self::MOST });
        }
        if let Some(index) = capsules.iter().position(|capsule| !capsule.is_valid()) {
            return Err(ObstacleError::BadCapsule { index });
        }
        let boxes: Vec<_> = capsules.iter().map(|one| Bounds::around(&one.ends, one.radius)).collect();
        let (tree, order) = Tree::over(&boxes, 1);
        Ok(Self { capsules: order.iter().map(|index| capsules[*index as usize]).collect(), tree })
    }

    /// The capsules, in an order of their own.
    #[must_use]
    pub fn capsules(&self) -> &[Capsule] {
        &self.capsules
    }

    /// Memory that they take \[bytes\].
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.capsules) + self.tree.bytes()
    }

    pub(super) fn bounds(&self) -> Bounds {
        *self.tree.whole()
    }

    /// The gap to a capsule, whose point comes first, if its distance is less than `most` \[m\].
    pub(super) fn gap_below(&self, capsule: &Capsule, most: f64) -> Option<Gap> {
        let mut best = None;
        self.tree.nearest(&capsule.ends, most + capsule.radius, &mut |block, least| {
            let gap = capsule.gap(&self.capsules[block]);
            let distance = gap.distance + capsule.radius;
            if distance < least {
                best = Some(gap);
                distance
            } else {
                least
            }
        });
        best
    }

    /// The gap to a capsule, whose point comes first.
    pub(super) fn gap(&self, capsule: &Capsule) -> Gap {
        // None is found only for a capsule that is not finite.
        self.gap_below(capsule, f64::INFINITY).unwrap_or_else(|| capsule.gap(&self.capsules[0]))
    }

    /// The distance of a point from the nearest of them, or `most` \[m\] if none is nearer.
    pub(super) fn distance(&self, point: &Vector3<f64>, most: f64) -> f64 {
        self.tree.nearest(&[*point, *point], most, &mut |block, least| {
            least.min(self.capsules[block].distance(point))
        })
    }

    /// Whether all of them are farther away from a capsule than `margin` \[m\].
    pub(super) fn capsule_clear(&self, capsule: &Capsule, margin: f64) -> bool {
        let reach = capsule.radius + margin;
        let found = self.tree.nearest(&capsule.ends, reach, &mut |block, least| {
            let is_near = capsule.gap(&self.capsules[block]).distance <= margin;
            if is_near { f64::NEG_INFINITY } else { least }
        });
        found > f64::NEG_INFINITY
    }

    pub(super) fn ball_clear(&self, centre: &Vector3<f64>, radius: f64) -> bool {
        !self.tree.any(centre, radius, &mut |block| self.capsules[block].distance(centre) <= radius)
    }
}
