//! Whether a straight motion of all joints is clear, between its samples too.
//!
//! A motion is cut into intervals; one is clear if everything within half of it, to either side of its middle, is proven clear in
//! one check. Where that proves nothing although the middle is clear, the interval is cut in two. It ends because what is clear by more than
//! nothing is proven on intervals that are short enough; shorter than [`SHORTEST`] it counts as too near.

use crate::check::Checker;
use crate::lanes::{LANES, Lanes, Mask};

/// Half of the shortest interval [rad or m].
const SHORTEST: f32 = 2e-4;

/// Room for checks of edges, so that none allocates.
#[derive(Clone, Default)]
pub(crate) struct Edges {
    open: Vec<(f32, f32)>,
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
        self.open.clear();
        let first = 0.5 / LANES as f32;
        // From both ends inwards: what stands in the way stands there most often in the middle, and all eight are checked at once.
        self.open.extend((0..LANES).map(|i| (first * (2 * i + 1) as f32, first)));
        while !self.open.is_empty() {
            let taken = self.open.len().min(LANES);
            let batch: [(f32, f32); LANES] =
                core::array::from_fn(|lane| self.open[self.open.len() - 1 - lane.min(taken - 1)]);
            self.open.truncate(self.open.len() - taken);
            for j in 0..n {
                let along = to[j] - from[j];
                let more = off.get(j).copied().unwrap_or(0.0);
                self.q[j] = Lanes::new(batch.map(|(middle, _)| from[j] + along * middle));
                self.half[j] = Lanes::new(batch.map(|(_, half)| along.abs() * half * (1.0 + 1e-5) + more));
            }
            let wanted = ((1u16 << taken) - 1) as Mask;
            let verdict = checker.check(&self.q, Some(&self.half), wanted);
            if verdict.clear != wanted || !possible(checker, &self.q, taken) {
                return false;
            }
            for (lane, &(middle, half)) in batch.iter().enumerate().take(taken) {
                if verdict.proven >> lane & 1 == 0 {
                    if half < shortest {
                        return false;
                    }
                    self.open.extend([-0.5, 0.5].map(|side| (middle + side * half, 0.5 * half)));
                }
            }
        }
        true
    }
}

/// Whether joints that share limits allow the first postures.
fn possible(checker: &Checker, q: &[Lanes], count: usize) -> bool {
    let coupled = checker.arms.iter().any(|arm| arm.part.shape.is_coupled());
    !coupled
        || (0..count).all(|lane| {
            let at: Vec<f64> = q.iter().map(|q| f64::from(q.lane(lane))).collect();
            checker.is_possible(&at)
        })
}
