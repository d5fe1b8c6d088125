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
    /// From when on it is known \[s\].
    pub(crate) begins: f64,
}

impl Speed {
    /// The mean of a motion over `window` \[s\], >= 0.
    pub(crate) fn of(plan: &TimeOptimal, window: f64) -> Self {
        let mut knots: Vec<Knot> = Vec::with_capacity(plan.pieces().len());
        for (time, at) in plan.pieces() {
            let sum = knots.last().map_or(0.0, |before| before.sum_after(time - before.time));
            knots.push(Knot { time, at, sum });
        }
        Speed { knots, window, stretch: 1.0, begins: 0.0 }
    }

    /// Of robots that stay where they are.
    pub(crate) const fn still() -> Self {
        Speed { knots: Vec::new(), window: 0.0, stretch: 1.0, begins: 0.0 }
    }

    /// The same; of robots that stay where they are, to be averaged over `window` \[s\], >= 0, with what they do next.
    pub(crate) fn with_window_if_still(&self, window: f64) -> Self {
        let mut speed = self.clone();
        if speed.knots.is_empty() {
            speed.window = window;
        }
        speed
    }

    /// The same, slower by a factor >= 1.
    pub(crate) fn slower(mut self, factor: f64) -> Self {
        self.stretch *= factor;
        self
    }

    /// The same without a stretch: its knots are slower instead.
    fn unstretched(&self) -> Self {
        let k = self.stretch;
        let slower = |knot: &Knot| {
            let ProfilePoint { s, v, a } = knot.at;
            Knot { time: knot.time * k, at: ProfilePoint { s, v: v / k, a: a / (k * k) }, sum: knot.sum * k }
        };
        let knots = self.knots.iter().map(slower).collect();
        Speed { knots, window: self.window * k, stretch: 1.0, begins: self.begins }
    }

    /// Without the mean: the motion that is averaged, by time \[s\].
    pub(crate) fn sharp(&self) -> Self {
        Speed { window: 0.0, ..self.unstretched() }
    }

    /// How much later the motion that is averaged has its effect \[s\].
    pub(crate) fn lag(&self) -> f64 {
        self.window * self.stretch
    }

    /// The time \[s\], or when what is averaged goes on that rests then; behind its end the duration.
    pub(crate) fn behind_rest(&self, time: f64) -> f64 {
        let next = self.knots.partition_point(|knot| knot.time * self.stretch <= time);
        match (next.checked_sub(1).map(|last| self.knots[last].at), self.knots.get(next)) {
            (Some(at), Some(next)) if at.v == 0.0 && at.a == 0.0 => next.time * self.stretch,
            (_, Some(_)) => time,
            (_, None) => self.duration(),
        }
    }

    /// What is left of it from a time \[s\] on, where the parameter `first` is 0 then.
    pub(crate) fn since(&self, time: f64, first: f64) -> Self {
        let whole = self.unstretched();
        let needed = whole.knots.partition_point(|knot| knot.time <= time - whole.window).max(1) - 1;
        let mut knots: Vec<Knot> = Vec::new();
        for Knot { time, at, .. } in whole.knots.iter().skip(needed) {
            let sum = knots.last().map_or(0.0, |before| before.sum_after(time - before.time));
            knots.push(Knot { time: *time, at: ProfilePoint { s: at.s - first, ..*at }, sum });
        }
        Speed { knots, begins: time, ..whole }
    }

    /// This motion until a time \[s\], and from there on `parts`, one behind the other, between which it rests for at least `rest` \[s\]. The first one
    /// begins as fast as this motion is then without the mean.
    pub(crate) fn onward(&self, time: f64, parts: &[TimeOptimal], rest: f64) -> Self {
        let mut speed = self.unstretched();
        let (at, sum) = speed.motion(time);
        speed.knots.retain(|knot| knot.time < time);
        let mut last = Knot { time, at: ProfilePoint { a: 0.0, ..at }, sum };
        if at.v == 0.0 {
            speed.knots.push(last);
            last = Knot { time: time + rest, sum: last.sum_after(rest), ..last };
        }
        for part in parts {
            let (begins, from) = (last.time, last.at.s);
            for (after, at) in part.pieces() {
                let time = begins + after;
                let sum = last.sum_after(time - last.time);
                last = Knot { time, at: ProfilePoint { s: from + at.s, ..at }, sum };
                speed.knots.push(last);
            }
            // What is averaged rests until its mean does.
            let rest = rest + speed.window;
            last = Knot { time: last.time + rest, sum: last.sum_after(rest), ..last };
        }
        speed
    }

    /// How long it lasts \[s\]: when it ends.
    pub(crate) fn duration(&self) -> f64 {
        (self.last().time + self.window) * self.stretch
    }

    /// The times between which its acceleration is constant or, with a window, linear, from where it begins to its end, rising \[s\].
    pub(crate) fn breaks(&self) -> Vec<f64> {
        let ends = |after: f64| self.knots.iter().map(move |knot| (knot.time + after) * self.stretch);
        let mut times: Vec<f64> = ends(0.0).collect();
        if self.window > 0.0 {
            times.extend(ends(self.window));
            times.sort_by(f64::total_cmp);
        }
        if self.begins > 0.0 {
            times.retain(|time| *time > self.begins);
            times.insert(0, self.begins);
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
        let h = t - knot.time;
        if h < 0.0 {
            return (ProfilePoint { s: knot.at.s, v: 0.0, a: 0.0 }, knot.sum + h * knot.at.s);
        }
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
