//! Capsules that stand still to one another, in a tree of boxes: what is far from a box is far from all below it.
//!
//! In: the capsules of a rigid part, in its frame. Out: nodes, each a box and a ball around what is below it; a leaf is one capsule. The two halves of a
//! node are divided at the median along the longest edge of the box around their centres.

use nalgebra::Vector3;

use crate::models::Capsule;

/// By how much a ball is larger than it need be \[m\]: more than rounding moves what is in it.
pub(super) const ROUNDING: f64 = 1e-9;

/// A node of a tree, in the frame of its part.
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// The centre of its box and of its ball.
    pub(super) centre: Vector3<f64>,
    /// Half the edges of its box, along the axes of the frame \[m\]. What is below it is in what lies within `round` \[m\] of the box ..
    pub(super) half: Vector3<f64>,
    pub(super) round: f64,
    /// .. and within a ball of this radius \[m\].
    pub(super) radius: f64,
    /// How many nodes behind this one the second child is, 0 for a leaf; the first one is the next node.
    pub(super) second: u32,
    /// The capsule of a leaf, by its number; of a node the one of its first leaf.
    pub(super) link: u32,
}

impl Node {
    pub(super) const fn is_leaf(&self) -> bool {
        self.second == 0
    }

    /// The places of the children of a node at a place.
    pub(super) const fn children(&self, at: usize) -> [usize; 2] {
        [at + 1, at + self.second as usize]
    }
}

/// Adds the tree over some capsules, at least one, each with its number.
pub(super) fn add(nodes: &mut Vec<Node>, capsules: &mut [(u32, Capsule)]) {
    let at = nodes.len();
    nodes.push(around(capsules));
    if capsules.len() > 1 {
        let middle = |(_, capsule): &(u32, Capsule)| capsule.ends[0] + capsule.ends[1];
        let corner = |pick: fn(f64, f64) -> f64| {
            capsules.iter().map(middle).reduce(|a, b| a.zip_map(&b, pick)).unwrap_or_default()
        };
        let axis = (corner(f64::max) - corner(f64::min)).imax();
        capsules.sort_by(|a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
        let (first, second) = capsules.split_at_mut(capsules.len() / 2);
        add(nodes, first);
        nodes[at].second = u32::try_from(nodes.len() - at).expect("a part has fewer than 2^31 capsules");
        nodes[at].link = nodes[at + 1].link;
        add(nodes, second);
    }
}

/// A leaf around some capsules.
fn around(capsules: &[(u32, Capsule)]) -> Node {
    let round = capsules.iter().map(|(_, capsule)| capsule.radius).fold(f64::INFINITY, f64::min);
    let ends = || capsules.iter().flat_map(|(_, c)| c.ends.iter().map(|end| (*end, c.radius)));
    let corner = |sign: f64| {
        let corners = ends().map(|(end, radius)| (sign * end).add_scalar(radius - round));
        sign * corners.reduce(|a, b| a.sup(&b)).unwrap_or_default()
    };
    let (low, high) = (corner(-1.0), corner(1.0));
    let centre = 0.5 * (low + high);
    let radius = ends().map(|(end, radius)| (end - centre).norm() + radius).fold(0.0, f64::max);
    Node {
        centre,
        half: 0.5 * (high - low),
        round: round + ROUNDING,
        radius: radius + ROUNDING,
        second: 0,
        link: capsules[0].0,
    }
}
