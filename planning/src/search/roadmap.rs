//! What earlier queries have proven, for later ones in the same world.
//!
//! In: the trees of searches and the paths that these found, whose legs are proven clear, and paths that were made shorter, of which legs are kept that
//! a check proves clear. Out: a path from a start to a goal, both of which straight motions to some of the nearest positions that are known join to the
//! rest. It is the shortest path along legs that are known.
//!
//! A leg is known with how much more than the margins it keeps. It holds for one world, and for what is kept upright there. Of more positions
//! than the roadmap may have it forgets those that it has known the longest. Literature: Kavraki and others, *Probabilistic roadmaps*
//! (IEEE Transactions on Robotics and Automation, 1996).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::tree::Tree;
use super::{Points, distance};
use crate::check::Checker;
use crate::edge::Edges;

/// How many of the nearest positions a start or a goal is tried to be joined to, and to how many of them it is.
const TRIES: usize = 12;
const JOINED: usize = 4;
/// To how many of several goals a path is looked for.
const GOALS: usize = 8;

/// Positions of all joints, and legs between them that are clear.
#[derive(Clone, Default)]
pub(crate) struct Roadmap {
    /// The most positions; 0 where nothing is remembered.
    most: usize,
    /// Whole turns of endless joints that the positions lack [rad].
    offset: Vec<f64>,
    nodes: Vec<Node>,
}

#[derive(Clone)]
struct Node {
    q: Vec<f32>,
    legs: Vec<Leg>,
}

/// A leg from a node.
#[derive(Clone, Copy)]
struct Leg {
    to: usize,
    /// How much more than the margins it keeps \[m\].
    more: f32,
}

impl Roadmap {
    /// One that knows nothing yet, for at most so many positions.
    pub(crate) fn new(most: usize) -> Self {
        Roadmap { most, ..Roadmap::default() }
    }

    /// The same that has forgotten everything, for another world.
    pub(crate) fn emptied(&self) -> Self {
        Roadmap::new(self.most)
    }

    /// Begins anew where limits that joints share count other whole turns than those of what is known.
    pub(crate) fn turn(&mut self, checker: &Checker) {
        if self.offset != checker.offset {
            let is_coupled = checker.arms.iter().any(|arm| arm.part.shape.is_coupled());
            if is_coupled {
                self.nodes.clear();
            }
            self.offset.clone_from(&checker.offset);
        }
    }

    /// A path along known legs from `start` to one of the `goals`, all of them clear, by at most about so many checks.
    pub(crate) fn route(
        &mut self,
        checker: &mut Checker,
        edges: &mut Edges,
        start: &[f32],
        goals: &[Vec<f32>],
        effort: u64,
    ) -> Option<Points> {
        let goals = &goals[..goals.len().min(GOALS)];
        if self.nodes.is_empty() || goals.len() >= self.most {
            return None;
        }
        let end = checker.batches + effort;
        self.forget(1 + goals.len());
        let from = self.place(start);
        let to: Vec<usize> = goals.iter().map(|goal| self.place(goal)).collect();
        if let Some(path) = self.shortest(checker, from, &to) {
            return Some(path);
        }
        for node in core::iter::once(from).chain(to.iter().copied()) {
            self.join(checker, edges, node, end);
        }
        self.shortest(checker, from, &to)
    }

    /// Remembers a path whose legs are clear with what is kept now.
    pub(crate) fn keep_path(&mut self, path: &[Vec<f32>], more: f32) {
        if path.len() > self.most {
            return;
        }
        self.forget(path.len());
        let nodes: Vec<usize> = path.iter().map(|q| self.place(q)).collect();
        nodes.windows(2).for_each(|leg| self.link(leg[0], leg[1], more));
    }

    /// Remembers those legs of a path that are clear with what is kept now: they need not have been checked before.
    pub(crate) fn keep_clear(&mut self, checker: &mut Checker, edges: &mut Edges, path: &[Vec<f32>]) {
        if path.len() > self.most {
            return;
        }
        for leg in path.windows(2) {
            if edges.is_clear(checker, &leg[0], &leg[1]) {
                self.keep_path(leg, checker.more);
            }
        }
    }

    /// Remembers a tree, of a large one what was reached first.
    pub(crate) fn keep_tree(&mut self, tree: &Tree, joints: usize, more: f32) {
        let kept = tree.len().min(self.most / 4);
        self.forget(kept);
        let mut places = Vec::with_capacity(kept);
        for node in 0..kept {
            let mut q = vec![0.0; joints];
            tree.position(node, &mut q);
            // What it grew from may be known. The rest was drawn.
            let Some(parent) = tree.parent(node) else {
                places.push(self.place(&q));
                continue;
            };
            self.nodes.push(Node { q, legs: Vec::new() });
            places.push(self.nodes.len() - 1);
            self.link(places[parent], places[node], more);
        }
    }

    /// The number of a position, which is known from now on.
    fn place(&mut self, q: &[f32]) -> usize {
        self.nodes.iter().rposition(|node| node.q == q).unwrap_or_else(|| {
            self.nodes.push(Node { q: q.to_vec(), legs: Vec::new() });
            self.nodes.len() - 1
        })
    }

    fn link(&mut self, a: usize, b: usize, more: f32) {
        for (from, to) in [(a, b), (b, a)] {
            match self.nodes[from].legs.iter_mut().find(|leg| leg.to == to) {
                Some(leg) => leg.more = leg.more.max(more),
                None => self.nodes[from].legs.push(Leg { to, more }),
            }
        }
    }

    /// Makes room for so many positions more.
    fn forget(&mut self, more: usize) {
        let forgotten = (self.nodes.len() + more).saturating_sub(self.most).min(self.nodes.len());
        self.nodes.drain(..forgotten);
        for node in self.nodes.iter_mut().filter(|_| forgotten > 0) {
            node.legs.retain(|leg| leg.to >= forgotten);
            node.legs.iter_mut().for_each(|leg| leg.to -= forgotten);
        }
    }

    /// Joins a position to some of those that are near.
    fn join(&mut self, checker: &mut Checker, edges: &mut Edges, node: usize, end: u64) {
        let mut near: Vec<(f32, usize)> = self
            .nodes
            .iter()
            .enumerate()
            .filter(|(i, _)| *i != node)
            .map(|(i, other)| (distance(&self.nodes[node].q, &other.q), i))
            .collect();
        if near.len() > TRIES {
            near.select_nth_unstable_by(TRIES, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            near.truncate(TRIES);
        }
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut joined = 0;
        for (_, other) in near {
            if joined == JOINED || checker.batches >= end {
                return;
            }
            if edges.is_clear(checker, &self.nodes[node].q, &self.nodes[other].q) {
                self.link(node, other, checker.more);
                joined += 1;
            }
        }
    }

    /// The shortest path along legs that keep what is kept now, by Dijkstra's algorithm.
    fn shortest(&self, checker: &Checker, from: usize, to: &[usize]) -> Option<Points> {
        let mut before: Vec<Option<usize>> = vec![None; self.nodes.len()];
        let mut reached = vec![f32::INFINITY; self.nodes.len()];
        // Lengths are not negative, so their bits are in their order.
        let mut open = BinaryHeap::from([Reverse((0.0_f32.to_bits(), from))]);
        reached[from] = 0.0;
        while let Some(Reverse((bits, at))) = open.pop() {
            let length = f32::from_bits(bits);
            if length > reached[at] {
                continue;
            }
            if to.contains(&at) {
                let mut path = vec![self.nodes[at].q.clone()];
                let mut node = at;
                while let Some(last) = before[node] {
                    path.push(self.nodes[last].q.clone());
                    node = last;
                }
                path.reverse();
                return Some(path);
            }
            for leg in self.nodes[at].legs.iter().filter(|leg| leg.more >= checker.more) {
                let next = length + distance(&self.nodes[at].q, &self.nodes[leg.to].q);
                if next < reached[leg.to] && (to.contains(&leg.to) || self.is_within(checker, leg.to)) {
                    reached[leg.to] = next;
                    before[leg.to] = Some(at);
                    open.push(Reverse((next.to_bits(), leg.to)));
                }
            }
        }
        None
    }

    /// Whether a position is within the limits of the joints, with the whole turns that there are now.
    fn is_within(&self, checker: &Checker, node: usize) -> bool {
        let q: Vec<f64> = self.nodes[node].q.iter().map(|q| f64::from(*q)).collect();
        checker.is_within(&q)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn positions(at: &[f32]) -> Points {
        at.iter().map(|q| vec![*q]).collect()
    }

    #[test]
    fn what_is_known_the_longest_is_forgotten_and_legs_stay_with_their_positions() {
        let mut roadmap = Roadmap::new(4);
        roadmap.keep_path(&positions(&[0.0, 1.0, 2.0]), 0.1);
        // 1 and 2 are known, and the leg between them keeps more now.
        roadmap.keep_path(&positions(&[1.0, 2.0, 3.0]), 0.2);
        roadmap.keep_path(&positions(&[3.0, 4.0]), 0.0);
        let known: Vec<f32> = roadmap.nodes.iter().map(|node| node.q[0]).collect();
        assert!(known.len() <= 4 && known.ends_with(&[3.0, 4.0]), "{known:?}");
        for (i, node) in roadmap.nodes.iter().enumerate() {
            for leg in &node.legs {
                let back = roadmap.nodes[leg.to].legs.iter().find(|back| back.to == i).expect("both ways");
                assert_eq!((node.q[0] - roadmap.nodes[leg.to].q[0]).abs(), 1.0);
                assert_eq!(leg.more, back.more);
            }
        }
        roadmap.keep_path(&positions(&[0.0, 1.0, 2.0, 3.0, 4.0]), 0.0);
        assert!(roadmap.nodes.len() <= 4, "a path that is too long is not kept");
    }

    #[test]
    fn of_a_large_tree_what_was_reached_first_is_kept() {
        let mut tree = Tree::new(1);
        let mut last = None;
        for k in 0..100_u8 {
            last = Some(tree.add(&[f32::from(k)], last));
        }
        let mut roadmap = Roadmap::new(40);
        roadmap.keep_tree(&tree, 1, 0.0);
        let known: Vec<f32> = roadmap.nodes.iter().map(|node| node.q[0]).collect();
        assert_eq!(known, (0..10_u8).map(f32::from).collect::<Vec<_>>());
    }
}
