//! Two-variable linear programmes: which accelerations `u` and squares `x` of the speed the limits of a cell allow.

use super::LinearLimit;

/// `low <= u + slope x <= high`.
#[derive(Clone, Copy, Debug)]
struct Row {
    slope: f64,
    low: f64,
    high: f64,
}

/// The values between two ends, both included.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Interval {
    pub least: f64,
    pub most: f64,
}

/// The limits of one cell.
#[derive(Clone, Debug, Default)]
pub(super) struct Cell {
    rows: Vec<Row>,
    /// Least and largest `x`, by the limits in which `u` does not occur.
    x: Interval,
}

/// The tightest limits of `u` at one `x`.
struct Edges {
    lower: Row,
    upper: Row,
    least: f64,
    most: f64,
}

impl LinearLimit {
    /// The same of `x` at the start of a cell `width` wide, where it is one at a `share` of it: there `x` is
    /// `x + 2 share width u`.
    fn at_start(self, share: f64, width: f64) -> Self {
        LinearLimit { a: self.a + 2.0 * share * width * self.b, ..self }
    }
}

/// Limits, each times its factor.
fn sum<const N: usize>(limits: &[LinearLimit; N], factors: [f64; N]) -> LinearLimit {
    let sum = |f: fn(&LinearLimit) -> f64| limits.iter().zip(factors).map(|(limit, k)| k * f(limit)).sum();
    LinearLimit {
        a: sum(|limit| limit.a),
        b: sum(|limit| limit.b),
        low: sum(|limit| limit.low),
        high: sum(|limit| limit.high),
    }
}

/// The limits at the control points of a parabola on a cell `width` wide, of one that holds at its start, middle and end,
/// as limits of `u` and of `x` at the start.
pub(super) fn parabola(at: [LinearLimit; 3], width: f64) -> [LinearLimit; 3] {
    let [start, middle, end] = at;
    let at = [start, middle.at_start(0.5, width), end.at_start(1.0, width)];
    [at[0], sum(&at, [-0.5, 2.0, -0.5]), at[2]]
}

/// The same of a cubic, of a limit that holds at the start, a third, two thirds and the end of the cell.
pub(super) fn cubic(at: [LinearLimit; 4], width: f64) -> [LinearLimit; 4] {
    let [start, third, two_thirds, end] = at;
    let at = [
        start,
        third.at_start(1.0 / 3.0, width),
        two_thirds.at_start(2.0 / 3.0, width),
        end.at_start(1.0, width),
    ];
    let inner = [-5.0, 18.0, -9.0, 2.0].map(|k| k / 6.0);
    let [p, q, r, s] = inner;
    [at[0], sum(&at, inner), sum(&at, [s, r, q, p]), at[3]]
}

impl Cell {
    /// No limits but `0 <= x <= most`.
    pub fn clear(&mut self, most: f64) {
        self.rows.clear();
        self.x = Interval { least: 0.0, most };
    }

    /// Adds a limit.
    pub fn push(&mut self, limit: LinearLimit) {
        let LinearLimit { a, b, low, high } = limit;
        let per = 1.0 / a;
        let (low_u, high_u) = if a > 0.0 { (low * per, high * per) } else { (high * per, low * per) };
        let row = Row { slope: b * per, low: low_u, high: high_u };
        if row.slope.is_finite() && !(low_u.is_nan() || high_u.is_nan()) {
            self.rows.push(row);
        } else if b != 0.0 {
            // `u` does not occur in it.
            let p = low / b;
            let q = high / b;
            self.x.least = self.x.least.max(p.min(q));
            self.x.most = self.x.most.min(p.max(q));
        } else if low > 0.0 || high < 0.0 {
            self.x.most = f64::NEG_INFINITY;
        }
    }

    fn edges(&self, x: f64) -> Edges {
        let none = Row { slope: 0.0, low: f64::NEG_INFINITY, high: f64::INFINITY };
        let mut edges = Edges { lower: none, upper: none, least: f64::NEG_INFINITY, most: f64::INFINITY };
        for row in &self.rows {
            let by = row.slope * x;
            let least = row.low - by;
            let most = row.high - by;
            if least > edges.least {
                edges.least = least;
                edges.lower = *row;
            }
            if most < edges.most {
                edges.most = most;
                edges.upper = *row;
            }
        }
        edges
    }

    /// The largest `u` at an `x` for which there is one.
    pub fn most(&self, x: f64) -> f64 {
        let Edges { lower, upper, least, most } = self.edges(x);
        // Limits that contradict each other do so by rounding, magnified where `u` hardly occurs: that one is the steeper.
        if least > most && upper.slope.abs() > lower.slope.abs() { least } else { most }
    }

    /// The least and the largest `x` for which there is a `u`; none if there is no such `x`.
    pub fn range(&self) -> Option<Interval> {
        if self.x.least > self.x.most {
            return None;
        }
        let most = self.feasible(self.x.most, -1.0)?;
        let least = self.feasible(self.x.least, 1.0)?;
        (least <= most).then_some(Interval { least, most })
    }

    /// The first `x` from `from` on, in the `direction` 1 or -1, for which there is a `u`: Newton's iteration on the gap
    /// between the tightest limits, which is convex and made of straight pieces.
    fn feasible(&self, from: f64, direction: f64) -> Option<f64> {
        let mut x = from;
        // Every step leaves a pair of limits for good; the count only guards against rounding.
        for _ in 0..=2 * self.rows.len() {
            let Edges { lower, upper, least, most } = self.edges(x);
            if least <= most {
                break;
            }
            let closing = lower.slope - upper.slope;
            if closing * direction <= 0.0 {
                return None;
            }
            let next = (lower.low - upper.high) / closing;
            let progress = (next - x) * direction > 0.0;
            // Without it, the gap is rounding.
            if !progress {
                break;
            }
            x = next;
        }
        (x >= self.x.least && x <= self.x.most).then_some(x)
    }
}
