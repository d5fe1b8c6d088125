//! Balls that cover a link, in a tree: each node's ball holds those below it.
//!
//! In: the capsules of a link. Out: a [`BallTree`], whose leaves cover the capsules, standing out by at most [`EXCESS`]. A node that is
//! clear of something needs no look at what is below it.

use std::collections::HashMap;

use mrroc_robots::clearance::Capsule;
use nalgebra::Vector3;

/// By how much the balls of a capsule may stand out of it \[m\].
pub(crate) const EXCESS: f64 = 0.003;

/// From so many capsules on that stand still together, those balls are left out that lie in others ..
const MANY: usize = 1000;
/// .. which may be so much larger for it \[m\].
const LARGER: f64 = 0.003;

/// The most balls along one capsule: a long thin one is covered less tightly.
const MOST: usize = 64;

/// A ball in the frame of its link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ball {
    /// Centre \[m\].
    pub(crate) centre: Vector3<f64>,
    /// Radius \[m\], > 0.
    pub(crate) radius: f64,
}

/// A node: its ball, and where its second child stands; the first one is the next node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) centre: [f32; 3],
    pub(crate) radius: f32,
    /// 0 for a leaf.
    pub(crate) second: u32,
}

/// Balls around the capsules of one link.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BallTree {
    pub(crate) nodes: Vec<Node>,
    /// The node that holds each of the capsules, and nothing else.
    pub(crate) roots: Vec<u32>,
}

/// How many balls cover a capsule.
pub(crate) fn count(capsule: &Capsule) -> usize {
    let length = (capsule.ends[1] - capsule.ends[0]).norm();
    let half = ((capsule.radius + EXCESS).powi(2) - capsule.radius.powi(2)).sqrt();
    // Centres from end to end, neighbours at most twice `half` apart; that is finite for capsules that are valid.
    ((length / (2.0 * half)).ceil() as usize + 1).clamp(1, MOST)
}

/// The balls that cover a capsule, so many.
pub(crate) fn covering(capsule: &Capsule, count: usize) -> impl Iterator<Item = Ball> {
    let [a, b] = capsule.ends;
    let spans = count.saturating_sub(1).max(1) as f64;
    // Midway between two centres the balls must still reach the capsule's surface.
    let half = if count > 1 { 0.5 * (b - a).norm() / spans } else { 0.0 };
    let centre = move |k: usize| if count > 1 { a + (b - a) * (k as f64 / spans) } else { 0.5 * (a + b) };
    let half = if count > 1 { half } else { 0.5 * (b - a).norm() };
    let radius = if count > 1 { capsule.radius.hypot(half) } else { capsule.radius + half };
    (0..count).map(move |k| Ball { centre: centre(k), radius })
}

/// A ball that holds all of them, of which there is at least one.
pub(crate) fn around(balls: &[Ball]) -> Ball {
    let mut lower = Vector3::repeat(f64::INFINITY);
    let mut upper = Vector3::repeat(f64::NEG_INFINITY);
    for ball in balls {
        lower = lower.zip_map(&ball.centre, |a, b| a.min(b - ball.radius));
        upper = upper.zip_map(&ball.centre, |a, b| a.max(b + ball.radius));
    }
    let centre = 0.5 * (lower + upper);
    let radius = balls.iter().map(|ball| (ball.centre - centre).norm() + ball.radius).fold(0.0, f64::max);
    Ball { centre, radius }
}

impl BallTree {
    /// Of the capsules of a link, in its frame.
    pub(crate) fn of(capsules: &[Capsule]) -> Self {
        let mut tree = BallTree { nodes: Vec::new(), roots: vec![0; capsules.len()] };
        let mut groups: Vec<(usize, Vec<Ball>)> =
            capsules.iter().map(|capsule| covering(capsule, count(capsule)).collect()).enumerate().collect();
        tree.add_groups(&mut groups);
        tree
    }

    /// Of capsules that stand still together, in the world: no [`roots`](Self::roots).
    pub(crate) fn standing(capsules: &[Capsule]) -> Self {
        let mut balls: Vec<Ball> =
            capsules.iter().flat_map(|capsule| covering(capsule, count(capsule))).collect();
        if capsules.len() >= MANY {
            balls = thinned(balls);
        }
        let mut tree = BallTree::default();
        tree.spread(&mut balls);
        tree
    }

    /// The number of each node among those that stand above capsules: a node has the number of the one before it where both are of one capsule.
    pub(crate) fn units(&self) -> Vec<u32> {
        let mut roots = vec![false; self.nodes.len()];
        self.roots.iter().for_each(|root| roots[*root as usize] = true);
        let mut units = Vec::with_capacity(self.nodes.len());
        // What stands behind a root, up to the next node that is above or at another one, is below it.
        let mut end = 0;
        let mut unit = 0;
        for (i, is_root) in roots.iter().enumerate() {
            if i >= end {
                unit += u32::from(i > 0);
                if *is_root {
                    end = self.end(i);
                }
            }
            units.push(unit);
        }
        units
    }

    /// The first node that is not below this one.
    fn end(&self, node: usize) -> usize {
        match self.nodes[node].second {
            0 => node + 1,
            second => self.end(second as usize),
        }
    }

    /// Nodes that have others below them, from the last to the first, and their children.
    pub(crate) fn inner(&self) -> impl Iterator<Item = (usize, [usize; 2])> {
        let nodes = self.nodes.iter().enumerate().rev().filter(|(_, node)| node.second != 0);
        nodes.map(|(i, node)| (i, [i + 1, node.second as usize]))
    }

    /// Adds balls that are near one another below one node.
    fn spread(&mut self, balls: &mut [Ball]) {
        let node = self.push(balls);
        if balls.len() > 1 {
            let centres: Vec<Vector3<f64>> = balls.iter().map(|ball| ball.centre).collect();
            let axis = longest(&centres);
            balls.sort_by(|a, b| a.centre[axis].total_cmp(&b.centre[axis]));
            let (first, second) = balls.split_at_mut(balls.len() / 2);
            self.spread(first);
            self.nodes[node].second = self.nodes.len() as u32;
            self.spread(second);
        }
    }

    fn push(&mut self, balls: &[Ball]) -> usize {
        let ball = around(balls);
        let centre = [0, 1, 2].map(|i| ball.centre[i] as f32);
        // Rounded to single precision, and still around them.
        let radius = (ball.radius + 1e-6 * (1.0 + ball.centre.norm())) as f32;
        self.nodes.push(Node { centre, radius, second: 0 });
        self.nodes.len() - 1
    }

    fn add_groups(&mut self, groups: &mut [(usize, Vec<Ball>)]) {
        match groups {
            [] => {}
            [(capsule, balls)] => {
                self.roots[*capsule] = self.nodes.len() as u32;
                self.add(balls);
            }
            _ => {
                let all: Vec<Ball> = groups.iter().flat_map(|(_, balls)| balls).copied().collect();
                let node = self.push(&all);
                let centres: Vec<Vector3<f64>> =
                    groups.iter().map(|(_, balls)| around(balls).centre).collect();
                let axis = longest(&centres);
                groups.sort_by(|(i, a), (j, b)| {
                    let order = around(a).centre[axis].total_cmp(&around(b).centre[axis]);
                    order.then(i.cmp(j))
                });
                let (first, second) = groups.split_at_mut(groups.len() / 2);
                self.add_groups(first);
                self.nodes[node].second = self.nodes.len() as u32;
                self.add_groups(second);
            }
        }
    }

    fn add(&mut self, balls: &[Ball]) {
        let node = self.push(balls);
        if balls.len() > 1 {
            let (first, second) = balls.split_at(balls.len() / 2);
            self.add(first);
            self.nodes[node].second = self.nodes.len() as u32;
            self.add(second);
        }
    }
}

/// Fewer balls that hold all of these: the largest first, each [`LARGER`], without those that lie in one that is kept.
fn thinned(mut balls: Vec<Ball>) -> Vec<Ball> {
    balls.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    // Those that are kept, by cells: another one that holds a ball is in its cell or next to it, or not looked for.
    let cell = |centre: &Vector3<f64>| [0, 1, 2].map(|i| (centre[i] / (2.0 * LARGER)).floor() as i64);
    let mut kept: HashMap<[i64; 3], Vec<Ball>> = HashMap::new();
    let mut left = Vec::new();
    for ball in balls {
        let at = cell(&ball.centre);
        let mut around =
            (0..27).filter_map(|k| kept.get(&[at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1]));
        let holds = |other: &Ball| (other.centre - ball.centre).norm() + ball.radius <= other.radius;
        if !around.any(|balls| balls.iter().any(holds)) {
            let larger = Ball { radius: ball.radius + LARGER, ..ball };
            kept.entry(at).or_default().push(larger);
            left.push(larger);
        }
    }
    left
}

/// The axis along which the points are spread most.
fn longest(points: &[Vector3<f64>]) -> usize {
    let lower = points.iter().fold(Vector3::repeat(f64::INFINITY), |a, b| a.inf(b));
    let upper = points.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |a, b| a.sup(b));
    (upper - lower).imax()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_point_of_a_capsule_lies_in_a_leaf_and_no_leaf_stands_out_by_more_than_the_excess(
            ends in proptest::array::uniform6(-0.4..0.4_f64), radius in 0.01..0.1_f64,
            along in 0.0..1.0_f64, direction in proptest::array::uniform3(-1.0..1.0_f64),
        ) {
            let [a, b] = [Vector3::new(ends[0], ends[1], ends[2]), Vector3::new(ends[3], ends[4], ends[5])];
            let capsule = Capsule::new(a, b, radius);
            let direction = Vector3::from(direction);
            prop_assume!(direction.norm() > 0.1);
            let point = a + (b - a) * along + direction.normalize() * radius;
            let tree = BallTree::of(&[capsule]);
            let inside = |node: &Node| {
                (point - Vector3::from(node.centre.map(f64::from))).norm() <= f64::from(node.radius)
            };
            prop_assert!(inside(&tree.nodes[0]));
            prop_assert!(tree.nodes.iter().any(|node| node.second == 0 && inside(node)));
            let stands_out = tree.nodes.iter().filter(|node| node.second == 0).any(|node| {
                f64::from(node.radius) > radius + EXCESS + 1e-5
            });
            prop_assert!(!stands_out);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn every_point_of_many_capsules_that_stand_lies_in_a_leaf(
            places in proptest::collection::vec(proptest::array::uniform3(-0.03..0.03_f64), 1200),
            which in 0..1200_usize, along in 0.0..1.0_f64, direction in proptest::array::uniform3(-1.0..1.0_f64),
        ) {
            let capsules: Vec<Capsule> = places
                .iter()
                .enumerate()
                .map(|(i, place)| {
                    let a = Vector3::from(*place);
                    Capsule::new(a, a + Vector3::new(0.01, 0.02, 0.03), 0.02 + 1e-5 * i as f64)
                })
                .collect();
            let direction = Vector3::from(direction);
            prop_assume!(direction.norm() > 0.1);
            let [a, b] = capsules[which].ends;
            let point = a + (b - a) * along + direction.normalize() * capsules[which].radius;
            let tree = BallTree::standing(&capsules);
            let inside = |node: &Node| {
                (point - Vector3::from(node.centre.map(f64::from))).norm() <= f64::from(node.radius)
            };
            prop_assert!(inside(&tree.nodes[0]));
            prop_assert!(tree.nodes.iter().any(|node| node.second == 0 && inside(node)));
            let all: usize = capsules.iter().map(count).sum();
            let leaves = tree.nodes.iter().filter(|node| node.second == 0).count();
            prop_assert!(leaves < all / 2, "{leaves} of {all}");
        }
    }
}
