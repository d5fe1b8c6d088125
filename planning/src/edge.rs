//! Whether a straight motion of all joints is clear, between its samples too, and keeps upright what must be.
//!
//! A motion is cut into intervals; one is clear if everything within half of it, to either side of its middle, is proven clear in
//! one check. Where that proves nothing although the middle is clear, the interval is cut. All intervals of a motion are checked before
//! any of their parts, and only pairs that some of them do not prove are checked again. It ends because what is clear by more than
//! nothing is proven on intervals that are short enough; shorter than [`SHORTEST`] it counts as too near.

use crate::arm::Around;
use crate::check::Checker;
use crate::lanes::{LANES, Lanes, Mask};

/// Half of the shortest interval [rad or m].
const SHORTEST: f32 = 2e-4;

/// Room for checks of edges, so that none allocates.
#[derive(Clone, Default)]
pub(crate) struct Edges {
    /// Middles and halves of intervals, as shares of the motion.
    open: Vec<(f32, f32)>,
    unproven: Vec<(f32, f32)>,
    q: Vec<Lanes>,
    half: Vec<Lanes>,
}

impl Edges {
    /// Whether the joints may move straight `from` one position `to` another [rad or m].
    pub(crate) fn is_clear(&mut self, checker: &mut Checker, from: &[f32], to: &[f32]) -> bool {
        self.is_clear_around(checker, from, to, &[])
    }

    /// The same where the joints may be off the line by so much, either way [rad or m]; nothing where `off` is empty.
    pub(crate) fn is_clear_around(
        &mut self,
        checker: &mut Checker,
        from: &[f32],
        to: &[f32],
        off: &[f32],
    ) -> bool {
        let n = from.len();
        self.q.resize(n, Lanes::default());
        self.half.resize(n, Lanes::default());
        let farthest = from.iter().zip(to).map(|(a, b)| (b - a).abs()).fold(0.0, f32::max);
        let shortest = if farthest > 0.0 { SHORTEST / farthest } else { f32::INFINITY };
        let coupled = checker.arms.iter().any(|arm| arm.part.shape.is_coupled());
        checker.list_all();
        self.open.clear();
        cut(&mut self.open, (0.5, 0.5), LANES);
        loop {
            self.unproven.clear();
            for taken in self.open.chunks(LANES) {
                let batch: [(f32, f32); LANES] =
                    core::array::from_fn(|lane| taken[lane.min(taken.len() - 1)]);
                for j in 0..n {
                    let along = to[j] - from[j];
                    self.q[j] = Lanes::new(batch.map(|(middle, _)| from[j] + along * middle));
                    self.half[j] = Lanes::new(batch.map(|(_, half)| along * half * (1.0 + 1e-5)));
                    if let Some(off) = off.get(j) {
                        self.half[j] = self.half[j].abs() + Lanes::splat(*off);
                    }
                }
                let around = if off.is_empty() { Around::Line(&self.half) } else { Around::Box(&self.half) };
                let wanted = ((1u16 << taken.len()) - 1) as Mask;
                let verdict = checker.check_listed(&self.q, around, wanted);
                if verdict.clear != wanted || coupled && !possible(checker, &self.q, taken.len()) {
                    return false;
                }
                let Some(upright) = checker.uprights.check(&checker.arms, &self.q, &self.half, taken.len())
                else {
                    return false;
                };
                let is_unproven = |lane: &usize| (verdict.proven & upright) >> lane & 1 == 0;
                self.unproven.extend((0..taken.len()).filter(is_unproven).map(|lane| taken[lane]));
            }
            if self.unproven.is_empty() {
                return true;
            }
            if self.unproven.iter().any(|(_, half)| *half < shortest) {
                return false;
            }
            checker.narrow();
            self.open.clear();
            // One batch lasts as long with few lanes as with all, and halves of what is not proven are rarely proven either.
            let parts = (LANES / self.unproven.len()).max(4);
            for interval in &self.unproven {
                cut(&mut self.open, *interval, parts);
            }
        }
    }
}

/// Positions in single precision, in which motions are checked.
pub(crate) fn single(q: &[f64]) -> Vec<f32> {
    q.iter().map(|q| *q as f32).collect()
}

/// Cuts an interval into parts.
fn cut(open: &mut Vec<(f32, f32)>, (middle, half): (f32, f32), parts: usize) {
    let part = half / parts as f32;
    open.extend((0..parts).map(|i| (middle - half + part * (2 * i + 1) as f32, part)));
}

/// Whether joints that share limits allow the first postures.
fn possible(checker: &Checker, q: &[Lanes], count: usize) -> bool {
    (0..count).all(|lane| {
        let at: Vec<f64> =
            q.iter().zip(&checker.offset).map(|(q, offset)| f64::from(q.lane(lane)) + offset).collect();
        checker.is_possible(&at)
    })
}
