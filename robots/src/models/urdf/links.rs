//! The links of a chain as a tree of bodies.

use mrroc::pose::Pose;
use nalgebra::Vector3;

use super::chain::Segment;
use super::serial::Serial;
use crate::dynamics::{self, Tree};

impl<const N: usize> Serial<N> {
    /// The links between base and tip, those of mimic joints too.
    pub(super) fn links(&self) -> Option<Tree<N>> {
        // The first segment has the base in it.
        let base =
            self.segments.first().map_or_else(Pose::identity, |first| first.X_before * self.X_BJ.inverse());
        let segments = self.segments.iter().zip(&self.drives.bodies).enumerate();
        let segments = segments.map(|(i, (segment, body))| dynamics::Segment {
            name: self.name_of(i, segment),
            parent: i.checked_sub(1),
            X_PJ: if i == 0 { self.X_BJ } else { segment.X_before },
            kind: segment.kind,
            axis: Vector3::z(),
            coordinate: segment.leader,
            multiplier: segment.multiplier,
            offset: segment.offset,
            body: body.load(),
        });
        Tree::new(base, segments.collect(), self.X_tip).ok()
    }

    /// The name of its coordinate, for the first segment that moves as that does; else one made of it.
    fn name_of(&self, i: usize, segment: &Segment) -> String {
        let name = self.movers.get(segment.leader).map_or("joint", |mover| mover.name.as_str());
        let leads =
            |one: &Segment| one.leader == segment.leader && one.multiplier == 1.0 && one.offset == 0.0;
        let is_taken = self.segments.iter().take(i).any(leads);
        if leads(segment) && !is_taken { name.to_owned() } else { format!("{name}_follower_{}", i + 1) }
    }
}
