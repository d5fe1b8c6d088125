//! Where a body that arms hold may move.
//!
//! In: coordinates of the body, and the [`Chain`] of its arms. Out: whether a straight motion between them is clear, with the joints of all arms on the way. It is
//! cut into steps. Between two steps the joints are off the chord by no more than their middle tells, with room for more; whether that is so is
//! proven of the path that is found.

use std::collections::BTreeMap;

use crate::chain::Chain;
use crate::check::Checker;
use crate::edge::{Edges, single};
use crate::path::{Path, bezier};
use crate::planner::reduced;
use crate::search::{Space, distance};

/// The longest step of a search, and of the body between two steps of a motion [m or rad].
const STEP: f64 = 0.3;
const LONGEST: f64 = 0.06;
/// The most that a joint moves from a step to its middle, and is off the chord there: more is a jump to another branch, or too near to a singular posture
/// [rad or m].
const JUMP: [f64; 2] = [0.15, 0.02];
/// By how much more than in its middle the joints may be off the chord of a step: a share, and as much [rad or m].
const OFF: [f64; 2] = [1.5, 1e-4];
/// The distance from a corner of the body's path at which it is rounded, and the least [m or rad].
const ROUNDED: [f64; 2] = [0.15, 0.01];
/// Joints that are nearer than this are the same [rad or m].
const SAME: f64 = 1e-6;

/// Places of the body, in its coordinates, between which it may move.
pub(crate) struct Bodies<'a> {
    pub(crate) checker: &'a mut Checker,
    edges: &'a mut Edges,
    chain: &'a Chain<'a>,
    offset: &'a [f64],
    /// The joints at places that motions have come to, by their bits.
    known: BTreeMap<Vec<u32>, Vec<f64>>,
}

impl<'a> Bodies<'a> {
    /// Without any place that is known.
    pub(crate) fn new(
        checker: &'a mut Checker,
        edges: &'a mut Edges,
        chain: &'a Chain<'a>,
        offset: &'a [f64],
    ) -> Self {
        Bodies { checker, edges, chain, offset, known: BTreeMap::new() }
    }

    /// Remembers the joints at a place.
    pub(crate) fn know(&mut self, y: &[f32], q: Vec<f64>) {
        self.known.insert(y.iter().map(|y| y.to_bits()).collect(), q);
    }

    /// The joints at a place that is known.
    pub(crate) fn known(&self, y: &[f32]) -> Option<Vec<f64>> {
        self.known.get(&y.iter().map(|y| y.to_bits()).collect::<Vec<_>>()).cloned()
    }

    /// The joints at a place, by those at the nearest one that is known.
    fn near(&self, y: &[f32]) -> Option<Vec<f64>> {
        let squared = |bits: &[u32]| -> f32 {
            bits.iter().zip(y).map(|(bits, y)| (f32::from_bits(*bits) - y).powi(2)).sum()
        };
        let nearest = self.known.iter().min_by(|a, b| squared(a.0).total_cmp(&squared(b.0)))?;
        let y: Vec<f64> = y.iter().map(|y| f64::from(*y)).collect();
        self.chain.joints_of(&y, nearest.1).ok()
    }

    /// The joints at the end of a motion of the body over a length, if it is clear.
    fn follow(&mut self, from: &[f64], length: f64, at: impl Fn(f64) -> Vec<f64>) -> Option<Vec<f64>> {
        let steps = (length / LONGEST).ceil().max(1.0);
        let mut q = from.to_vec();
        for k in 0..steps as usize {
            // It is counted before: what has no posture costs as well.
            self.checker.batches += 1;
            let middle = self.chain.joints_of(&at((k as f64 + 0.5) / steps), &q).ok()?;
            let next = self.chain.joints_of(&at((k as f64 + 1.0) / steps), &middle).ok()?;
            let mut off = Vec::with_capacity(q.len());
            for ((a, m), b) in q.iter().zip(&middle).zip(&next) {
                let bend = (m - 0.5 * (a + b)).abs();
                if (m - a).abs().max((b - m).abs()) > JUMP[0] || bend > JUMP[1] {
                    return None;
                }
                off.push(if a == b && bend == 0.0 { 0.0 } else { (OFF[0] * bend + OFF[1]) as f32 });
            }
            let [a, b] = [&q, &next].map(|q| single(&reduced(q, self.offset)));
            if !self.edges.is_clear_around(self.checker, &a, &b, &off) {
                return None;
            }
            q = next;
        }
        Some(q)
    }

    /// The path through points, with its corners rounded as far as is clear.
    pub(crate) fn rounded(&mut self, points: &[Vec<f64>]) -> Path {
        let places: Vec<&[f64]> = points.iter().map(|point| &**point).collect();
        let [largest, least] = ROUNDED;
        Path::through(&places, |_| largest, least, |i, curve, d| self.is_curve_clear(&points[i], curve, d))
    }

    fn is_curve_clear(&mut self, corner: &[f64], points: &[[f64; 6]], d: f64) -> bool {
        let at = |t: f64| -> Vec<f64> { points.iter().map(|p| bezier(p, t)[0]).collect() };
        let y: Vec<f32> = single(corner);
        let begin = self.known(&y).and_then(|q| self.chain.joints_of(&at(0.0), &q).ok());
        begin.is_some_and(|begin| self.follow(&begin, 2.0 * d, at).is_some())
    }
}

impl Space for Bodies<'_> {
    fn spent(&mut self) -> &mut u64 {
        &mut self.checker.batches
    }

    fn longest_step(&self) -> Option<f32> {
        Some(STEP as f32)
    }

    fn is_clear(&mut self, from: &[f32], to: &[f32]) -> bool {
        let (a, b) = (from, to);
        let at = |t: f64| -> Vec<f64> {
            let place = |(a, b): (&f32, &f32)| f64::from(*a) + (f64::from(*b) - f64::from(*a)) * t;
            a.iter().zip(b).map(place).collect()
        };
        // A shortcut begins between places that are known.
        let Some(q) = self.known(from).or_else(|| self.near(from)) else { return false };
        let length = f64::from(distance(from, to));
        let Some(last) = self.follow(&q, length, at) else { return false };
        match self.known(to) {
            // Arms may come there in another posture.
            Some(known) => known.iter().zip(&last).all(|(a, b)| (a - b).abs() < SAME),
            None => {
                self.know(to, last);
                true
            }
        }
    }
}
