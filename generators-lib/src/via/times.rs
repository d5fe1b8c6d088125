//! The motion over path time, of whatever the legs are.

use super::Blend;

/// Where the rate changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knot {
    /// Middle of its blend \[s\].
    pub time: f64,
    /// The leg it is on, or begins, and how far along, 0..=1.
    pub place: (usize, f64),
    /// Legs before and behind, and their rates [1/s].
    pub before: (usize, f64),
    pub after: (usize, f64),
    pub blend: Blend,
}

/// Where a motion is: at a share of a leg, and from there by shares of the legs before and behind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ViaPoint {
    pub place: (usize, f64),
    pub before: (usize, f64),
    pub after: (usize, f64),
}

/// All rates and their changes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Times {
    pub knots: Vec<Knot>,
}

impl Times {
    pub fn duration(&self) -> f64 {
        self.knots.last().map_or(0.0, |knot| knot.time + 0.5 * knot.blend.duration())
    }

    /// Where the motion is at path time `t` \[s\].
    pub fn at(&self, t: f64) -> ViaPoint {
        // The last knot whose blend has begun; until the next one begins, the motion goes on from it.
        let begun = self.knots.partition_point(|knot| knot.time - 0.5 * knot.blend.duration() <= t);
        let knot = &self.knots[begun.max(1) - 1];
        let x = (t - knot.time).max(-0.5 * knot.blend.duration());
        let (advance, _, _) = knot.blend.at(x);
        let before = knot.before;
        let after = knot.after;
        ViaPoint {
            place: knot.place,
            before: (before.0, before.1 * (x - advance)),
            after: (after.0, after.1 * advance),
        }
    }
}
