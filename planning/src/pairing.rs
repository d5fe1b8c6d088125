//! Pairs of limbs that are kept apart, and of limbs and obstacles.
//!
//! In: arms, and the pairs of capsules that a clearance checks. Out: those of the capsules of two limbs as one [`Pairing`]. Where only some of them
//! are checked, it knows below which nodes of both trees there are any.

use std::sync::Arc;

use mrroc_robots::clearance::{CheckedPair, Partner};

use crate::arm::Arm;
use crate::balls::BallTree;

/// What is kept apart from a limb.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Against {
    /// An obstacle.
    Obstacle(usize),
    /// A limb of an arm.
    Limb(usize, usize),
}

/// A limb, what is kept apart from it, and by how much.
#[derive(Clone, Debug)]
pub(crate) struct Pairing {
    pub(crate) arm: usize,
    pub(crate) limb: usize,
    pub(crate) against: Against,
    /// \[m\], >= 0.
    pub(crate) margin: f32,
    /// From which joint on their travel counts.
    pub(crate) since: usize,
    /// Which of their capsules are compared; `None`: all.
    parts: Option<Arc<Parts>>,
}

impl Pairing {
    /// The arm that the other side belongs to; of an obstacle the same.
    pub(crate) fn other(&self) -> usize {
        match self.against {
            Against::Obstacle(_) => self.arm,
            Against::Limb(arm, _) => arm,
        }
    }

    /// Whether anything is compared below two nodes; against an obstacle the second one is 0.
    #[inline]
    pub(crate) fn has(&self, one: u32, other: u32) -> bool {
        self.parts.as_deref().is_none_or(|parts| parts.has(one, other))
    }
}

/// Below which nodes of two trees there are capsules that are compared: a bit for each pair of [`units`](BallTree::units).
#[derive(Debug)]
struct Parts {
    /// The unit of each node of both trees.
    units: [Arc<[u32]>; 2],
    /// Words of a row, which is a unit of the first tree.
    width: usize,
    words: Vec<u64>,
}

impl Parts {
    /// None below any nodes of two trees with such units.
    fn none(units: [Arc<[u32]>; 2]) -> Self {
        let [height, width] = units.each_ref().map(|units| units.last().map_or(0, |last| *last as usize + 1));
        let width = width.div_ceil(64);
        Parts { units, width, words: vec![0; height * width] }
    }

    fn place(&self, one: u32, other: u32) -> (usize, u32) {
        let [unit, beside] = [self.units[0][one as usize], self.units[1][other as usize]];
        (unit as usize * self.width + beside as usize / 64, beside % 64)
    }

    fn has(&self, one: u32, other: u32) -> bool {
        let (word, bit) = self.place(one, other);
        self.words[word] >> bit & 1 == 1
    }

    /// Adds a pair.
    fn add(&mut self, one: u32, other: u32) {
        let (word, bit) = self.place(one, other);
        self.words[word] |= 1 << bit;
    }

    /// Finds the nodes above the pairs that were added.
    fn rise(&mut self, one: &BallTree, other: Option<&BallTree>) {
        // Nodes stand before what is below them.
        for (node, children) in one.inner() {
            let row = self.units[0][node] as usize * self.width;
            for child in children {
                let below = self.units[0][child] as usize * self.width;
                for word in 0..self.width {
                    let more = self.words[below + word];
                    self.words[row + word] |= more;
                }
            }
        }
        let Some(other) = other else { return };
        for row in self.words.chunks_mut(self.width) {
            for (node, children) in other.inner() {
                let units = &self.units[1];
                for below in children.map(|child| units[child] as usize) {
                    let more = row[below / 64] >> (below % 64) & 1;
                    row[units[node] as usize / 64] |= more << (units[node] % 64);
                }
            }
        }
    }
}

/// A pairing that pairs are added to.
struct Growing {
    pairing: Pairing,
    parts: Parts,
    count: usize,
}

/// The pairs of capsules, as pairs of limbs.
pub(crate) fn pairings(arms: &[Arm], pairs: impl Iterator<Item = CheckedPair>) -> Vec<Pairing> {
    // The limb of each link, and its node.
    let places = |arm: &Arm| {
        let mut places = vec![None; arm.part.links.len()];
        for (i, limb) in arm.limbs.iter().enumerate() {
            for (link, root) in limb.links.iter().zip(&limb.tree.roots) {
                places[*link] = Some((i, *root));
            }
        }
        places
    };
    let places: Vec<Vec<Option<(usize, u32)>>> = arms.iter().map(places).collect();
    let tree = |arm: usize, limb: usize| &arms[arm].limbs[limb].tree;
    let tree_of = |against: Against| match against {
        Against::Obstacle(_) => None,
        Against::Limb(arm, limb) => Some(tree(arm, limb)),
    };
    let units_of = |arm: &Arm| arm.limbs.iter().map(|limb| limb.tree.units().into()).collect();
    let units: Vec<Vec<Arc<[u32]>>> = arms.iter().map(units_of).collect();
    // An obstacle is one.
    let single: Arc<[u32]> = Arc::new([0]);
    let mut found: Vec<Growing> = Vec::new();
    let mut last = 0;
    for pair in pairs {
        let arm = pair.robot;
        let Some((limb, root)) = places[arm][pair.link] else { continue };
        let (against, other_root, since) = match pair.partner {
            Partner::Obstacle(body) => (Against::Obstacle(body), 0, 0),
            Partner::Link(other_arm, link) => {
                let Some((other, root)) = places[other_arm][link] else { continue };
                let since = if other_arm == arm { arms[arm].apart(limb, other, pair.since) } else { 0 };
                (Against::Limb(other_arm, other), root, since)
            }
        };
        let margin = pair.margin as f32;
        let same = |Growing { pairing: of, .. }: &Growing| {
            (of.arm, of.limb, of.against, of.margin, of.since) == (arm, limb, against, margin, since)
        };
        // Most pairs are of the same limbs as the one before.
        if !found.get(last).is_some_and(same) {
            last = found.iter().position(same).unwrap_or(found.len());
        }
        if last == found.len() {
            let pairing = Pairing { arm, limb, against, margin, since, parts: None };
            let beside = match against {
                Against::Obstacle(_) => &single,
                Against::Limb(arm, limb) => &units[arm][limb],
            };
            let parts = Parts::none([&units[arm][limb], beside].map(Arc::clone));
            found.push(Growing { pairing, parts, count: 0 });
        }
        found[last].parts.add(root, other_root);
        found[last].count += 1;
    }
    let whole = |Growing { mut pairing, mut parts, count }: Growing| {
        let (one, other) = (tree(pairing.arm, pairing.limb), tree_of(pairing.against));
        if count < one.roots.len() * other.map_or(1, |other| other.roots.len()) {
            parts.rise(one, other);
            pairing.parts = Some(Arc::new(parts));
        }
        pairing
    };
    let mut pairings: Vec<Pairing> = found.into_iter().map(whole).collect();
    // Links far from the base meet something first.
    pairings.sort_by_key(|pairing| core::cmp::Reverse(pairing.limb));
    pairings
}

#[cfg(test)]
mod tests {
    use mrroc_robots::clearance::Capsule;
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn nodes_have_pairs_if_and_only_if_there_are_pairs_of_capsules_below_or_above_them() {
        let tree = |length: f64, count: usize| {
            let capsule = |i: usize| {
                let at = Vector3::new(0.1 * i as f64, 0.02 * (i * i % 7) as f64, 0.0);
                Capsule::new(at, at + Vector3::z() * length, 0.02)
            };
            BallTree::of(&(0..count).map(capsule).collect::<Vec<_>>())
        };
        let trees = [tree(0.2, 13), tree(0.0, 6)];
        let pairs = [(0, 0), (3, 5), (12, 1), (12, 2)];
        let mut parts = Parts::none(trees.each_ref().map(|tree| tree.units().into()));
        pairs.iter().for_each(|(a, b)| parts.add(trees[0].roots[*a], trees[1].roots[*b]));
        parts.rise(&trees[0], Some(&trees[1]));
        // The nodes from a node on that are below it.
        let below = |tree: &BallTree, node: usize| {
            let mut last = node;
            while tree.nodes[last].second != 0 {
                last = tree.nodes[last].second as usize;
            }
            node..=last
        };
        let is_related = |tree: &BallTree, capsule: usize, node: usize| {
            let root = tree.roots[capsule] as usize;
            below(tree, node).contains(&root) || below(tree, root).contains(&node)
        };
        for a in 0..trees[0].nodes.len() {
            for b in 0..trees[1].nodes.len() {
                let expected = pairs.iter().any(|(capsule, other)| {
                    is_related(&trees[0], *capsule, a) && is_related(&trees[1], *other, b)
                });
                assert_eq!(parts.has(a as u32, b as u32), expected, "nodes {a} and {b}");
            }
        }
    }
}
