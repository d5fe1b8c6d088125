//! A tree of positions, with the nearest one to any position.

use crate::lanes::{LANES, Lanes};

/// Positions that are reached from a root, or from several.
#[derive(Clone)]
pub(crate) struct Tree {
    joints: usize,
    /// Eight positions at a time, joint by joint; places that are not taken are far away.
    blocks: Vec<Lanes>,
    parents: Vec<u32>,
    /// How far a sample may be from each node to be tried from there.
    domains: Vec<f32>,
}

/// The domain of a node after the first motion from it that was not clear, and the least one [rad or m]. They are those of VAMP.
const FIRST: f32 = 4.0;
const LEAST: f32 = 1.0;

/// By which share a domain changes with each motion that is tried.
const CHANGE: f32 = 1e-4;

/// The parent of a root.
const NONE: u32 = u32::MAX;

impl Tree {
    pub(crate) fn new(joints: usize) -> Self {
        Tree { joints, blocks: Vec::new(), parents: Vec::new(), domains: Vec::new() }
    }

    pub(crate) fn len(&self) -> usize {
        self.parents.len()
    }

    /// Adds a position; its number.
    pub(crate) fn add(&mut self, q: &[f32], parent: Option<usize>) -> usize {
        let node = self.len();
        let lane = node % LANES;
        if lane == 0 {
            self.blocks.resize(self.blocks.len() + self.joints, Lanes::splat(1e18));
        }
        let block = self.blocks.len() - self.joints;
        for (lanes, q) in self.blocks[block..].iter_mut().zip(q) {
            lanes.set(lane, *q);
        }
        self.parents.push(parent.map_or(NONE, |parent| parent as u32));
        self.domains.push(f32::INFINITY);
        node
    }

    /// How far a sample may be from a node to be tried from there [rad or m].
    pub(crate) fn domain(&self, node: usize) -> f32 {
        self.domains[node]
    }

    /// Widens the domain of a node from which a motion was clear, and narrows that of one from which it was not.
    pub(crate) fn tried(&mut self, node: usize, is_clear: bool) {
        let domain = &mut self.domains[node];
        *domain = match (is_clear, domain.is_finite()) {
            (true, _) => *domain * (1.0 + CHANGE),
            (false, true) => (*domain * (1.0 - CHANGE)).max(LEAST),
            (false, false) => FIRST,
        };
    }

    pub(crate) fn position(&self, node: usize, q: &mut [f32]) {
        let block = node / LANES * self.joints;
        for (q, lanes) in q.iter_mut().zip(&self.blocks[block..block + self.joints]) {
            *q = lanes.lane(node % LANES);
        }
    }

    /// The nearest node, and the square of its distance.
    pub(crate) fn nearest(&self, q: &[f32]) -> (usize, f32) {
        let mut best = (0, f32::INFINITY);
        for (b, block) in self.blocks.chunks_exact(self.joints).enumerate() {
            let mut squared = Lanes::default();
            for (lanes, q) in block.iter().zip(q) {
                let off = *lanes - Lanes::splat(*q);
                squared = squared + off * off;
            }
            for (lane, squared) in squared.array().into_iter().enumerate() {
                if squared < best.1 {
                    best = (b * LANES + lane, squared);
                }
            }
        }
        best
    }

    /// The node that a node was reached from; none of a root.
    pub(crate) fn parent(&self, node: usize) -> Option<usize> {
        let parent = self.parents[node];
        (parent != NONE).then_some(parent as usize)
    }

    /// The positions from a node to its root.
    pub(crate) fn to_root(&self, node: usize) -> Vec<Vec<f32>> {
        let mut path = Vec::new();
        let mut at = node as u32;
        while at != NONE {
            let mut q = vec![0.0; self.joints];
            self.position(at as usize, &mut q);
            path.push(q);
            at = self.parents[at as usize];
        }
        path
    }
}
