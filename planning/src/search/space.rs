//! What a search finds its way in: the joints of all robots, or what else has positions between which motions are clear or not.

use super::{Points, UPRIGHT, between, distance};
use crate::check::Checker;
use crate::edge::Edges;

/// Positions, and straight motions between them.
pub(crate) trait Space {
    /// How many checks of eight postures have been spent, and others of no more effort.
    fn spent(&mut self) -> &mut u64;

    /// The longest step of a tree, if that is shorter than where nothing is kept: then positions are moved to where it is kept.
    fn longest_step(&self) -> Option<f32> {
        None
    }

    /// Moves a position to the nearest where all is kept that must be; whether there is one.
    fn project(&mut self, _q: &mut [f32]) -> bool {
        true
    }

    /// Whether the straight motion from one position to another is clear. The first is one that a motion has come to, or a start or a goal.
    fn is_clear(&mut self, from: &[f32], to: &[f32]) -> bool;

    /// Puts points between two so that all is kept that must be, if the legs between them are clear; whether they are.
    fn bend(&mut self, _points: &mut Points) -> bool {
        false
    }
}

/// The joints of all robots.
pub(crate) struct Joints<'a> {
    pub(crate) checker: &'a mut Checker,
    pub(crate) edges: &'a mut Edges,
}

impl Space for Joints<'_> {
    fn spent(&mut self) -> &mut u64 {
        &mut self.checker.batches
    }

    fn longest_step(&self) -> Option<f32> {
        (!self.checker.uprights.is_empty()).then_some(UPRIGHT)
    }

    fn project(&mut self, q: &mut [f32]) -> bool {
        self.checker.uprights.project(&self.checker.arms, q)
    }

    fn is_clear(&mut self, from: &[f32], to: &[f32]) -> bool {
        self.edges.is_clear(self.checker, from, to)
    }

    fn bend(&mut self, points: &mut Points) -> bool {
        let [from, to] = points.as_slice() else { return false };
        let legs = (distance(from, to) / UPRIGHT).ceil();
        if self.checker.uprights.is_empty() || legs < 2.0 {
            return false;
        }
        let mut middle: Points = (1..legs as usize).map(|k| between(from, to, k as f32 / legs)).collect();
        if !middle.iter_mut().all(|q| self.project(q)) {
            return false;
        }
        points.splice(1..1, middle);
        points.windows(2).all(|pair| self.is_clear(&pair[0], &pair[1]))
    }
}
