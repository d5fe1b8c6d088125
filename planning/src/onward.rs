//! How fast robots that move already pass over to another path.
//!
//! In: a motion, the instant of the hand-over, and a path that is that of the motion at first. Out: a [`Speed`] that is the motion's until then,
//! and afterwards the fastest within the limits of all joints, with stops that are clear ([`Stops`]).
//!
//! Where jerk is limited, a [`Speed`] is the mean of a time-optimal motion over a window of time. The new motion goes on from where that time-optimal
//! one is, with its speed, and the mean is taken over both. So position, velocity and acceleration go on without a break, and the
//! jerk is limited across the hand-over too.
//!
//! The common part of both paths is as long as the robots need to come to rest on it, so there is always a motion: it may end there.

use crate::check::Checker;
use crate::error::PlanError;
use crate::limits::Limits;
use crate::path::Path;
use crate::speed::Speed;
use crate::timing::{Cell, Passed, SHARES, Stops, along, share_of_limits, window};

/// By what limits of velocity and acceleration are divided on the common part: there the motion may begin at its limit, computed otherwise.
const COMMON: Cell = Cell { velocity: 0.998, acceleration: 0.995, ..Cell::FREE };
/// What joints may exceed their limits by on the common part and behind it, as a share of speed: less than what a plan leaves of them.
const EXCESS: [f64; 2] = [1.008, 1.002];
/// How often the motion is made slower where it exceeds limits.
const ROUNDS: usize = 20;
/// By how much more accelerations are lowered than seems to be needed.
const MORE: f64 = 1.003;
/// The time between two instants at which limits are measured \[s\].
const STEP: f64 = 2e-3;
/// By what limits of acceleration, with the square of it, are divided for the way to a standstill.
const CALM: f64 = 1.1;
/// Places that are nearer than this are one [rad or m].
const SAME: f64 = 1e-7;

/// Another path for robots that move.
pub(crate) struct Onward<'a> {
    /// The motion until the hand-over.
    pub(crate) speed: &'a Speed,
    /// When that is \[s\], not before it begins or behind its end.
    pub(crate) at: f64,
    /// The whole path, and up to which parameter it is that of the motion.
    pub(crate) path: &'a Path,
    pub(crate) common: f64,
    /// Whether the robots come to rest at the end of the common part.
    pub(crate) rests: bool,
    pub(crate) limits: &'a Limits,
    pub(crate) reaction: f64,
}

/// Where the mean of a motion begins to depend on the hand-over: the parameter and the speed of what is averaged.
pub(crate) fn begin(speed: &Speed, at: f64) -> [f64; 2] {
    let now = speed.sharp().at(at);
    [now.s, now.v]
}

/// The parameter at which robots can be at rest on their path at the latest that begin to brake at the parameter and the speed of `from`.
pub(crate) fn standstill(path: &Path, speed: &Speed, limits: &Limits, [from, v]: [f64; 2]) -> f64 {
    let (mut u, mut square) = (from, v * v);
    let calm = CALM.max(speed.stretch).powi(2);
    while square > 0.0 && u < path.length() {
        let at = path.at(u);
        // The largest deceleration that all joints allow at this speed; none where the path bends too much for it.
        let allowed = (0..limits.joints()).map(|j| {
            let (first, bend) = (at.first[j], at.second[j] * square);
            let most = SHARES[1] * limits.acceleration[j] / calm;
            let side = first.abs();
            if side > 0.0 { (most + bend * first.signum()) / side } else { f64::INFINITY }
        });
        let brakes = allowed.fold(f64::INFINITY, f64::min).max(0.0);
        let step = 1e-3_f64.min(path.length() - u);
        square -= 2.0 * step * brakes;
        u += step;
    }
    u.min(path.length())
}

impl Onward<'_> {
    /// The motion, and the grid of the cells that are proven; `grid` is that of the motion until the hand-over.
    pub(crate) fn timed(&self, checker: &mut Checker, grid: &[f64]) -> Result<(Speed, Vec<f64>), PlanError> {
        let [begin, v] = begin(self.speed, self.at);
        let grid = self.grid(grid, begin);
        let place = |u: f64| grid.partition_point(|place| *place < u - 1e-12);
        let (first, turn) = (place(begin), place(self.common));
        let sharp = Passed::of(&grid, &self.speed.sharp()).most();
        let is_common = |cell: usize| grid[cell] < self.common - SAME;
        // Slower than the motion is without the mean it cannot be made on the common part.
        let least: Vec<f64> =
            sharp.iter().enumerate().map(|(cell, most)| if is_common(cell) { *most } else { 0.0 }).collect();
        let mut cells: Vec<Cell> =
            (0..least.len()).map(|cell| if is_common(cell) { COMMON } else { Cell::FREE }).collect();
        let before = self.rests.then(|| self.path.until(self.common));
        let rest = before.as_ref().map(|path| (path, turn));
        let stops = Stops {
            path: self.path,
            rest,
            limits: self.limits,
            reaction: self.reaction,
            grid: &grid,
            twist: None,
        };
        let seen = self.speed.at(self.at);
        let from = seen.s - seen.v.max(v) * self.reaction;
        // Robots that come to rest in a corner do not leave it within the reaction time.
        let corner = self.path.corner_from(from);
        let from = if corner < begin { place(corner) } else { place(from).saturating_sub(1) };
        let end = grid.len() - 1;
        // Robots that stand have a mean of nothing so far.
        let old = self.speed.with_window_if_still(window(self.limits));
        let speed = stops.slowed(checker, from, &least, |most| {
            for _ in 0..ROUNDS {
                let part = |[from, to]: [usize; 2], v: f64| {
                    along(self.path, &grid[from..=to], self.limits, [v, 0.0], |i| {
                        let cell = cells[from + i];
                        Cell { most: cell.most.min(most[from + i]), ..cell }
                    })
                };
                let mut parts = Vec::new();
                let split = if self.rests { turn } else { end };
                if first < split {
                    parts.push(part([first, split], v)?);
                }
                if split < end {
                    parts.push(part([split, end], 0.0)?);
                }
                let speed = old.onward(self.at, &parts, self.reaction);
                if !self.slow(&speed, &grid, &least, &mut cells) {
                    return Ok(speed);
                }
            }
            Err(PlanError::HandOver { at: self.at })
        })?;
        Ok((speed, grid))
    }

    /// Cells with the old ones on the common part, so that what was clear on them is so again.
    fn grid(&self, old: &[f64], begin: f64) -> Vec<f64> {
        let own = crate::timing::grid(self.path);
        let common = self.common - SAME;
        let is_apart = |u: &f64| (u - begin).abs() > SAME && (u - self.common).abs() > SAME;
        let kept = old.iter().copied().filter(|u| *u < common && is_apart(u));
        let new = own.iter().copied().filter(|u| *u > common && is_apart(u));
        let mut grid: Vec<f64> = kept.chain(new).chain([begin]).collect();
        if (self.common - begin).abs() > SAME {
            grid.push(self.common);
        }
        grid.sort_by(f64::total_cmp);
        grid
    }

    /// Makes those cells slower in which limits are exceeded; whether there were any.
    fn slow(&self, speed: &Speed, grid: &[f64], least: &[f64], cells: &mut [Cell]) -> bool {
        let (sharp, lag) = (speed.sharp(), speed.lag());
        let samples = ((speed.duration() - self.at) / STEP).ceil().max(1.0);
        let step = (speed.duration() - self.at) / samples;
        let mut shares = vec![0.0_f64; cells.len()];
        let mut before: Option<Vec<f64>> = None;
        for k in 0..=samples as u32 {
            let time = self.at + f64::from(k) * step;
            let now = speed.at(time);
            let earlier = before.as_deref().map(|before| (before, step));
            let (share, accelerations) = share_of_limits(&self.path.at(now.s), now, self.limits, earlier);
            before = Some(accelerations);
            let from = sharp.at((time - lag - step).max(self.at)).s;
            if share > EXCESS[usize::from(from > self.common)] {
                let to = sharp.at(time).s;
                let first = grid.partition_point(|u| *u <= from).max(1) - 1;
                let last = grid.partition_point(|u| *u < to).clamp(first + 1, cells.len());
                for (of_cell, cell) in shares[first..last].iter_mut().zip(first..) {
                    *of_cell = of_cell.max(share);
                    if grid[cell] < self.common - SAME {
                        cells[cell].most = cells[cell].most.min((now.v / share).max(least[cell]));
                    }
                }
            }
        }
        let mut any = false;
        for (cell, share) in shares.into_iter().enumerate().filter(|(_, share)| *share > 0.0) {
            any = true;
            cells[cell].acceleration *= share * MORE;
            if grid[cell] >= self.common - SAME {
                cells[cell].velocity *= share * MORE;
            }
        }
        any
    }
}
