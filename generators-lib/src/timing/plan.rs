//! The plan: controllable sets backwards, the fastest motion forwards, and that motion over path time.

use mrroc::robot::JointVector;

use super::cell::{Cell, Interval, cubic, parabola};
use super::{LinearLimit, PathLimits, TimingError, speeds};
use crate::curve::{Parametric, SplinePoint};
use crate::profile::{Profile, ProfileError, ProfilePoint, check_stretch};

/// A place on the grid: when it is passed, where it is, how fast, and the acceleration from there on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot {
    time: f64,
    s: f64,
    v: f64,
    a: f64,
}

/// The fastest motion along a path within limits, over path time; immutable. `s` is how far the path's parameter is from
/// its start.
///
/// It begins and ends at the speeds that were asked for; in between its acceleration is constant on each cell.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeOptimal {
    knots: Vec<Knot>,
}

/// A path cut into cells, and the limits on it.
struct Problem {
    grid: Vec<f64>,
    /// Square of the speed that velocity limits allow at each point of the grid.
    most: Vec<f64>,
    /// Limits of the joints' accelerations at the start, in the middle and at the end of each cell.
    joints: Vec<[LinearLimit; 3]>,
    /// Further ones at the start, a third, two thirds and the end of each cell, all of one place behind each other.
    more: Vec<LinearLimit>,
    /// How many of both there are at one place.
    rows: [usize; 2],
}

impl TimeOptimal {
    /// Along `path` within `limits`, on a `grid` of two or more of its parameters that rise from its start to its end (see
    /// [`grid`](super::grid)), with the speeds `[start, end]` of the parameter [1/s].
    ///
    /// # Errors
    /// Limits out of range, a grid that does not suit the path, a path that is not finite; a speed that the limits do not
    /// allow.
    pub fn plan<P: Parametric>(
        path: &P,
        grid: &[f64],
        limits: &PathLimits<P::Value>,
        speeds: [f64; 2],
    ) -> Result<Self, TimingError> {
        Self::with_linear_limits(path, grid, limits, speeds, |_, _| {})
    }

    /// The same within more limits that are linear in `s''` and `s'^2`, the same number at every point, such as
    /// [`torque_limits`](super::torque_limits): `more` adds those at a point of the path.
    ///
    /// # Errors
    /// As [`plan`](Self::plan); a place that no motion within the limits passes.
    pub fn with_linear_limits<P: Parametric>(
        path: &P,
        grid: &[f64],
        limits: &PathLimits<P::Value>,
        speeds: [f64; 2],
        more: impl FnMut(&SplinePoint<P::Value>, &mut Vec<LinearLimit>),
    ) -> Result<Self, TimingError> {
        let problem = Problem::new(path, grid, limits, more)?;
        let sets = problem.controllable(speeds[1])?;
        problem.fastest(&sets, speeds[0])
    }

    /// The places where its acceleration changes, in order: time \[s\], how far the parameter is from its start, its speed, and its
    /// acceleration from there on. The last one is its end.
    pub fn pieces(&self) -> impl ExactSizeIterator<Item = (f64, ProfilePoint)> {
        self.knots.iter().map(|knot| (knot.time, ProfilePoint { s: knot.s, v: knot.v, a: knot.a }))
    }

    fn last(&self) -> &Knot {
        &self.knots[self.knots.len() - 1]
    }
}

impl Problem {
    fn new<P: Parametric>(
        path: &P,
        grid: &[f64],
        limits: &PathLimits<P::Value>,
        mut more: impl FnMut(&SplinePoint<P::Value>, &mut Vec<LinearLimit>),
    ) -> Result<Self, TimingError> {
        limits.validate()?;
        let (start, end) = path.range();
        let rises = grid.windows(2).all(|pair| pair[0] < pair[1]);
        if grid.len() < 2 || !rises || grid[0] != start || grid[grid.len() - 1] != end {
            return Err(TimingError::Grid(start, end));
        }
        let cells: Vec<_> = grid
            .windows(2)
            .map(|pair| {
                // The end belongs to this cell, not to the next one.
                [pair[0], pair[0] + 0.5 * (pair[1] - pair[0]), pair[1].next_down()].map(|u| path.at(u))
            })
            .collect();
        let most = speeds::most(&cells, limits);
        if let Some(i) = most.iter().position(|most| !(*most > 0.0 && most.is_finite())) {
            return Err(TimingError::NotFinite(grid[i]));
        }
        let finite =
            |limit: &LinearLimit| (limit.a + limit.b).is_finite() && (limit.low + limit.high).is_finite();
        let acceleration = |point: &SplinePoint<P::Value>, j: usize| {
            let high = limits.acceleration[j];
            LinearLimit { a: point.first[j], b: point.second[j], low: -high, high }
        };
        let mut joints = Vec::with_capacity(cells.len() * P::Value::LEN);
        for (cell, at) in cells.iter().zip(grid) {
            joints.extend((0..P::Value::LEN).map(|j| [0, 1, 2].map(|k| acceleration(&cell[k], j))));
            let rows = &joints[joints.len() - P::Value::LEN..];
            let values = cell.iter().all(|point| point.value.is_finite());
            if !(values && rows.iter().flatten().all(finite)) {
                return Err(TimingError::NotFinite(*at));
            }
        }
        let mut further = Vec::new();
        let mut expected = 0;
        for (i, (cell, ends)) in cells.iter().zip(grid.windows(2)).enumerate() {
            let at = |share: f64| path.at(ends[0] + share * (ends[1] - ends[0]));
            for k in 0..4 {
                let before = further.len();
                match k {
                    0 => more(&cell[0], &mut further),
                    3 => more(&cell[2], &mut further),
                    _ => more(&at(f64::from(k) / 3.0), &mut further),
                }
                let actual = further.len() - before;
                expected = if i == 0 && k == 0 { actual } else { expected };
                if actual != expected {
                    return Err(TimingError::Rows { at: ends[0], actual, expected });
                }
                if !further[before..].iter().all(finite) {
                    return Err(TimingError::NotFinite(ends[0]));
                }
            }
        }
        Ok(Problem { grid: grid.to_vec(), most, joints, more: further, rows: [P::Value::LEN, expected] })
    }

    fn width(&self, i: usize) -> f64 {
        self.grid[i + 1] - self.grid[i]
    }

    /// The limits of cell `i`, which is to end within `next`.
    fn cell(&self, i: usize, next: Interval, cell: &mut Cell) {
        cell.clear(self.most[i]);
        let width = self.width(i);
        let [joints, more] = self.rows;
        for at in &self.joints[i * joints..(i + 1) * joints] {
            parabola(*at, width).into_iter().for_each(|limit| cell.push(limit));
        }
        for k in 4 * i * more..(4 * i + 1) * more {
            let at = [0, 1, 2, 3].map(|place| self.more[k + place * more]);
            cubic(at, width).into_iter().for_each(|limit| cell.push(limit));
        }
        cell.push(LinearLimit { a: 2.0 * width, b: 1.0, low: next.least, high: next.most });
    }

    /// The squares of speed at each point of the grid from which the `end` speed can be reached.
    fn controllable(&self, end: f64) -> Result<Vec<Interval>, TimingError> {
        let last = self.grid.len() - 1;
        let most = self.most[last].sqrt();
        if !(end >= 0.0 && end <= most) {
            return Err(TimingError::Speed { place: "end", asked: end, least: 0.0, most });
        }
        let mut sets = vec![Interval { least: end * end, most: end * end }; last + 1];
        let mut cell = Cell::default();
        for i in (0..last).rev() {
            self.cell(i, sets[i + 1], &mut cell);
            sets[i] = cell.range().ok_or(TimingError::Impassable(self.grid[i]))?;
        }
        Ok(sets)
    }

    /// The largest acceleration in every cell that stays in the controllable `sets`.
    fn fastest(&self, sets: &[Interval], start: f64) -> Result<TimeOptimal, TimingError> {
        let least = sets[0].least.sqrt();
        let most = sets[0].most.sqrt();
        // A speed that was computed may exceed its limit by rounding.
        if !(start >= least * (1.0 - 1e-12) && start <= most * (1.0 + 1e-12)) {
            return Err(TimingError::Speed { place: "start", asked: start, least, most });
        }
        let mut knots = Vec::with_capacity(self.grid.len());
        let mut cell = Cell::default();
        let mut time = 0.0;
        let mut x = start * start;
        for (i, next) in sets[1..].iter().enumerate() {
            self.cell(i, *next, &mut cell);
            let width = self.width(i);
            let beyond = (x + 2.0 * width * cell.most(x)).min(next.most).max(next.least);
            let v = x.sqrt();
            let after = beyond.sqrt();
            knots.push(Knot { time, s: self.grid[i] - self.grid[0], v, a: (beyond - x) / (2.0 * width) });
            time += 2.0 * width / (v + after);
            if !time.is_finite() {
                return Err(TimingError::Impassable(self.grid[i]));
            }
            x = beyond;
        }
        let s = self.grid[self.grid.len() - 1] - self.grid[0];
        knots.push(Knot { time, s, v: x.sqrt(), a: 0.0 });
        Ok(TimeOptimal { knots })
    }
}

impl Profile for TimeOptimal {
    fn distance(&self) -> f64 {
        self.last().s
    }

    fn duration(&self) -> f64 {
        self.last().time
    }

    /// Before 0 it is at its start, from the duration on at its end, at the speeds it has there.
    fn at(&self, t: f64) -> ProfilePoint {
        let next = self.knots.partition_point(|knot| knot.time <= t);
        let knot = &self.knots[next.max(1) - 1];
        let Some(after) = self.knots.get(next.max(1)) else {
            return ProfilePoint { s: knot.s, v: knot.v, a: knot.a };
        };
        let t = (t - knot.time).max(0.0);
        let s = knot.s + (knot.v + 0.5 * knot.a * t) * t;
        ProfilePoint { s: s.min(after.s), v: (knot.v + knot.a * t).max(0.0), a: knot.a }
    }

    fn stretched_to(mut self, duration: f64) -> Result<Self, ProfileError> {
        check_stretch(duration, self.duration())?;
        let k = duration / self.duration();
        for knot in &mut self.knots {
            knot.time *= k;
            knot.v /= k;
            knot.a /= k * k;
        }
        if let Some(last) = self.knots.last_mut() {
            last.time = duration;
        }
        Ok(self)
    }
}
