//! How far a path is passed at a time: the fastest motion within limits, made smooth where robots limit jerk.
//!
//! In: the pieces of constant acceleration of a time-optimal motion. Out: a [`Speed`], the mean of that motion over a window of time
//! `w`. Its acceleration rises and falls within `w` where the other one jumps, so its jerk is at most `2 A / w`; it lasts `w` longer, on the same
//! path.

use mrroc_generators::profile::ProfilePoint;
use mrroc_generators::timing::TimeOptimal;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Knot {
    pub(crate) time: f64,
    pub(crate) at: ProfilePoint,
    /// The integral of `s` from the start.
    pub(crate) sum: f64,
}

/// The parameter of a path over time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Speed {
    pub(crate) knots: Vec<Knot>,
    pub(crate) window: f64,
    /// How many times slower it is passed.
    pub(crate) stretch: f64,
}

impl Speed {
    /// The mean of a motion over `window` \[s\], >= 0.
    pub(crate) fn of(plan: &TimeOptimal, window: f64) -> Self {
        let mut knots: Vec<Knot> = Vec::with_capacity(plan.pieces().len());
        for (time, at) in plan.pieces() {
            let sum = knots.last().map_or(0.0, |before| before.sum_after(time - before.time));
            knots.push(Knot { time, at, sum });
        }
        Speed { knots, window, stretch: 1.0 }
    }

    /// Of robots that stay where they are.
    pub(crate) const fn still() -> Self {
        Speed { knots: Vec::new(), window: 0.0, stretch: 1.0 }
    }

    /// The same, slower by a factor >= 1.
    pub(crate) fn slower(mut self, factor: f64) -> Self {
        self.stretch *= factor;
        self
    }

    /// How long it lasts \[s\].
    pub(crate) fn duration(&self) -> f64 {
        (self.last().time + self.window) * self.stretch
    }

    /// The times between which its acceleration is constant or, with a window, linear, from 0 to its end, rising \[s\].
    pub(crate) fn breaks(&self) -> Vec<f64> {
        let ends = |after: f64| self.knots.iter().map(move |knot| (knot.time + after) * self.stretch);
        let mut times: Vec<f64> = ends(0.0).collect();
        if self.window > 0.0 {
            times.extend(ends(self.window));
            times.sort_by(f64::total_cmp);
        }
        times
    }

    /// The largest speed between two times \[s\] that are in one piece between [`breaks`](Self::breaks).
    pub(crate) fn most_in_piece(&self, from: f64, to: f64) -> f64 {
        let ends = [self.at(from), self.at(to)];
        // A linear acceleration lifts the speed above the larger of both ends by at most this.
        let rise = if self.window > 0.0 { (ends[1].a - ends[0].a).abs() * (to - from) / 8.0 } else { 0.0 };
        ends[0].v.max(ends[1].v) + rise
    }

    /// The largest speed between two times \[s\], with the `breaks` of this speed.
    pub(crate) fn most_between(&self, breaks: &[f64], from: f64, to: f64) -> f64 {
        let [first, last] = [breaks.partition_point(|t| *t <= from), breaks.partition_point(|t| *t < to)];
        let inner = breaks.get(first..last).unwrap_or_default().iter().copied();
        let mut before = from;
        let pieces =
            inner.chain([to]).map(|time| self.most_in_piece(core::mem::replace(&mut before, time), time));
        pieces.fold(0.0, f64::max)
    }

    fn last(&self) -> Knot {
        self.knots.last().copied().unwrap_or(Knot {
            time: 0.0,
            at: ProfilePoint { s: 0.0, v: 0.0, a: 0.0 },
            sum: 0.0,
        })
    }

    /// The parameter, from 0, its speed and its acceleration at a time \[s\].
    pub(crate) fn at(&self, time: f64) -> ProfilePoint {
        let t = time / self.stretch;
        let (now, sum) = self.motion(t);
        let point = if self.window > 0.0 {
            let w = self.window;
            let (then, before) = self.motion(t - w);
            ProfilePoint { s: (sum - before) / w, v: (now.s - then.s) / w, a: (now.v - then.v) / w }
        } else {
            now
        };
        ProfilePoint { s: point.s, v: point.v / self.stretch, a: point.a / (self.stretch * self.stretch) }
    }

    /// The motion that is averaged, and the integral of its position; at rest before its start, and behind its end.
    fn motion(&self, t: f64) -> (ProfilePoint, f64) {
        let piece = self.knots.partition_point(|knot| knot.time <= t).max(1) - 1;
        let knot = self.knots.get(piece).copied().unwrap_or_else(|| self.last());
        let h = (t - knot.time).max(0.0);
        (knot.at(h), knot.sum_after(h))
    }
}

impl Knot {
    /// The motion a time `h` later, >= 0, within its piece.
    fn at(&self, h: f64) -> ProfilePoint {
        let ProfilePoint { s, v, a } = self.at;
        ProfilePoint { s: s + h * (v + 0.5 * h * a), v: v + h * a, a }
    }

    fn sum_after(&self, h: f64) -> f64 {
        self.sum + h * (self.at.s + h * (0.5 * self.at.v + h * self.at.a / 6.0))
    }
}
