//! How fast a path is passed: the least time within the limits of all joints, slower where a stop would not be clear.
//!
//! In: a path whose motion is clear. Out: a [`Speed`]: velocity, acceleration and jerk of every joint within [`SHARES`] of its limits, and
//! from every instant all stops clear ([`Swept`]).
//!
//! First the fastest motion; then, piece by piece, what its stops sweep. Where that is not clear, the speed is limited to the largest
//! that is, and the motion is planned anew. A lower limit in one place makes no other place faster, so few rounds are needed.

use mrroc_generators::curve::{Parametric, SplinePoint};
use mrroc_generators::profile::ProfilePoint;
use mrroc_generators::timing::{LinearLimit, PathLimits, TimeOptimal};
use nalgebra::SVector;

use crate::check::{Among, Checker};
use crate::error::PlanError;
use crate::limits::Limits;
use crate::path::{At, Path};
use crate::pieces::Pieces;
use crate::proof::Proof;
use crate::speed::Speed;
use crate::stop::Swept;
use crate::twist::Twist;

/// Shares of the limits that a plan uses, of velocity and of acceleration and jerk: the rest is for the operator's speed (decision 5).
pub(crate) const SHARES: [f64; 2] = [0.98, 0.88];
/// The longest cell of the grid [rad or m], and how many there are at least.
const CELL: f64 = 0.05;
const CELLS: f64 = 40.0;
/// How often the motion is planned anew at most.
const ROUNDS: usize = 24;
/// How often a cell is cut in halves at most, and where no speed is slow enough so.
const HALVINGS: [u32; 2] = [6, 9];
/// Shares of the speed below which a place counts as impassable.
const SLOWEST: f64 = 1e-3;
/// What the place of a motion may be off the end of a cell by rounding [rad or m].
const ROUNDING: f64 = 1e-9;
/// Samples of a motion in which its limits are measured, at least in a cell.
const SAMPLES: usize = 4;

/// The parameter of a path, as a path of its own.
struct Parameter<'a> {
    knots: &'a [f64],
}

impl Parametric for Parameter<'_> {
    type Value = SVector<f64, 1>;

    fn range(&self) -> (f64, f64) {
        (self.knots[0], self.knots[self.knots.len() - 1])
    }

    fn at(&self, u: f64) -> SplinePoint<SVector<f64, 1>> {
        SplinePoint { value: [u].into(), first: [1.0].into(), second: [0.0].into() }
    }

    fn knots(&self) -> &[f64] {
        self.knots
    }
}

/// The motion along `path` from rest to rest, with stops that begin after a `reaction` time \[s\] at the latest; and the grid of the cells
/// that are proven. With a `twist` arms that hold one body may also brake on it.
pub(crate) fn timed(
    checker: &mut Checker,
    path: &Path,
    limits: &Limits,
    reaction: f64,
    twist: Option<&Twist>,
) -> Result<(Speed, Vec<f64>), PlanError> {
    let grid = grid(path);
    let windows = window(limits);
    let least = vec![0.0; grid.len() - 1];
    let stops = Stops { path, rest: None, limits, reaction, grid: &grid, twist };
    let speed = stops.slowed(checker, 0, &least, |most| {
        let plan = along(path, &grid, limits, [0.0; 2], |cell| Cell { most: most[cell], ..Cell::FREE })?;
        let speed = Speed::of(&plan, windows);
        let factor = excess(path, &speed, limits, grid.len() * SAMPLES);
        Ok(speed.slower(factor))
    })?;
    Ok((speed, grid))
}

/// The window of time over which a motion is averaged, so that the limits of jerk are kept \[s\].
pub(crate) fn window(limits: &Limits) -> f64 {
    let jerks = limits.jerk.iter().zip(&limits.acceleration);
    jerks.filter_map(|(jerk, a)| jerk.map(|jerk| 2.0 * a / jerk)).fold(0.0, f64::max)
}

/// What the stops of a motion are proven on.
pub(crate) struct Stops<'a> {
    pub(crate) path: &'a Path,
    /// The path up to a cell before which the robots rest for longer than the reaction time, and that cell.
    pub(crate) rest: Option<(&'a Path, usize)>,
    pub(crate) limits: &'a Limits,
    /// The latest begin of a stop \[s\].
    pub(crate) reaction: f64,
    pub(crate) grid: &'a [f64],
    /// On what arms that hold one body may brake together.
    pub(crate) twist: Option<&'a Twist>,
}

impl Stops<'_> {
    /// The motion that is `fastest` with speeds of at most so much in each cell, which are lowered until the stops from all cells are clear from
    /// the `first` on; but not below the `least` ones.
    pub(crate) fn slowed(
        &self,
        checker: &mut Checker,
        first: usize,
        least: &[f64],
        mut fastest: impl FnMut(&[f64]) -> Result<Speed, PlanError>,
    ) -> Result<Speed, PlanError> {
        let grid = self.grid;
        let count = grid.len() - 1;
        let mut most = vec![f64::INFINITY; count];
        let groups = groups(self.limits.robots.len()).into_iter();
        let mut proofs: Vec<Proof> = groups.map(|among| Proof::new(checker, among)).collect();
        // What was proven clear needs no second proof at a lower speed.
        let whole = |cell: &[f64]| vec![Pieces::new([cell[0], cell[1]]); proofs.len()];
        let mut pieces: Vec<Vec<Pieces>> = grid.windows(2).map(whole).collect();
        let not_clear =
            |cell: usize| PlanError::StopsNotClear { at: 100.0 * grid[cell] / self.path.length() };
        let mut at = 0;
        for round in 0..ROUNDS {
            let speed = fastest(&most)?;
            let passed = Passed::of(grid, &speed);
            let mut slowed = None;
            for cell in first..count {
                let rest = self.rest.map(|(_, rest)| rest).filter(|rest| cell < *rest);
                let (last, passed) = passed.ahead(cell, rest.unwrap_or(count), self.reaction);
                let mut slow = pieces[cell].iter().map(Pieces::proven).fold(f64::INFINITY, f64::min);
                if passed <= slow {
                    continue;
                }
                let mut is_clear = |speed: f64, halvings: u32| {
                    proofs.iter_mut().zip(&mut pieces[cell]).all(|(proof, pieces)| {
                        pieces.are_clear(speed, halvings, |ends| {
                            self.is_clear_from(checker, proof, ends, speed)
                        })
                    })
                };
                if is_clear(passed, HALVINGS[0]) {
                    continue;
                }
                for halvings in HALVINGS {
                    let mut fast = passed;
                    while fast - slow > 0.1 * fast && fast > SLOWEST * passed {
                        let middle = 0.5 * (slow + fast);
                        if is_clear(middle, halvings) { slow = middle } else { fast = middle }
                    }
                    if slow > 0.0 {
                        break;
                    }
                }
                if slow == 0.0 {
                    return Err(not_clear(cell));
                }
                // Less, and the less the more often it was tried: the speed of a place is measured with that of its neighbours.
                let share = 1.0 - 0.03 * (round + 1) as f64;
                let mut is_least = true;
                for (most, least) in most[cell..=last].iter_mut().zip(&least[cell..=last]) {
                    *most = most.min((share * slow).max(*least));
                    is_least &= *most <= *least;
                }
                if is_least {
                    return Err(not_clear(cell));
                }
                slowed = Some(cell);
            }
            match slowed {
                None => return Ok(speed),
                Some(cell) => at = cell,
            }
        }
        Err(not_clear(at))
    }

    /// Whether the stops from everywhere on a piece are proven clear, for the pairs of a proof.
    fn is_clear_from(&self, checker: &Checker, proof: &mut Proof, [from, to]: [f64; 2], speed: f64) -> bool {
        let path = self.rest.filter(|(_, rest)| to <= self.grid[*rest]).map_or(self.path, |(path, _)| path);
        let ends = [from, to];
        let mut swept = Some(Swept::new(path, ends, speed, self.limits, self.reaction));
        if let Some(twist) = self.twist {
            let cell = self.grid.partition_point(|u| *u <= from).saturating_sub(1);
            let together =
                |swept: Swept| swept.together(path, ends, speed, self.limits, self.reaction, (twist, cell));
            swept = swept.and_then(together);
        }
        swept.is_some_and(|swept| swept.is_within(self.limits) && swept.is_clear(checker, proof, self.limits))
    }
}

/// What is proven apart: robots need not begin to brake together, so the pairs of each robot alone are looked at wherever it may stand,
/// and those of two robots wherever these two may.
fn groups(robots: usize) -> Vec<Among> {
    let two = (0..robots).flat_map(|a| (a + 1..robots).map(move |b| Among::Two(a, b)));
    (0..robots).map(Among::Alone).chain(two).collect()
}

/// What limits a motion in a cell of its grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// The largest speed of the parameter \[1/s\].
    pub(crate) most: f64,
    /// By what the limits of velocity are divided, and by the square of what those of acceleration are.
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
}

impl Cell {
    /// Only the limits of the joints.
    pub(crate) const FREE: Cell = Cell { most: f64::INFINITY, velocity: 1.0, acceleration: 1.0 };
}

/// The fastest motion along the part of a path that a grid is on, with `speeds` at its ends.
pub(crate) fn along(
    path: &Path,
    grid: &[f64],
    limits: &Limits,
    speeds: [f64; 2],
    of_cell: impl Fn(usize) -> Cell,
) -> Result<TimeOptimal, PlanError> {
    let own = PathLimits { velocity: [1e9].into(), acceleration: [1e12].into(), speed: f64::INFINITY };
    let mut asked = 0;
    let rows = |point: &SplinePoint<SVector<f64, 1>>, rows: &mut Vec<LinearLimit>| {
        // Four places of each cell are asked for, one after the other.
        let cell = of_cell((asked / 4).min(grid.len() - 2));
        asked += 1;
        let at = path.at(point.value[0]);
        // As `x / square <= 1`, so that rest is allowed by all that is interpolated in a cell.
        let mut slowest = 1.0 / (cell.most * cell.most);
        for j in 0..limits.joints() {
            let high = SHARES[1] * limits.acceleration[j] / (cell.acceleration * cell.acceleration);
            rows.push(LinearLimit { a: at.first[j], b: at.second[j], low: -high, high });
            let share = at.first[j] * cell.velocity / (SHARES[0] * limits.velocity[j]);
            slowest = slowest.max(share * share);
        }
        rows.push(LinearLimit { a: 0.0, b: slowest, low: -1.0, high: 1.0 });
    };
    Ok(TimeOptimal::with_linear_limits(&Parameter { knots: grid }, grid, &own, speeds, rows)?)
}

/// How much faster than the limits allow joints are at a time: the share of velocity, of acceleration and, with the accelerations `before` at a
/// time so much earlier \[s\], of jerk; and their accelerations.
pub(crate) fn share_of_limits(
    at: &At,
    now: ProfilePoint,
    limits: &Limits,
    before: Option<(&[f64], f64)>,
) -> (f64, Vec<f64>) {
    let mut factor = 0.0_f64;
    let mut accelerations = Vec::with_capacity(limits.joints());
    for j in 0..limits.joints() {
        let velocity = (at.first[j] * now.v).abs() / (SHARES[0] * limits.velocity[j]);
        let acceleration = at.first[j] * now.a + at.second[j] * now.v * now.v;
        let share = acceleration.abs() / (SHARES[1] * limits.acceleration[j]);
        factor = factor.max(velocity).max(share.sqrt());
        if let (Some(jerk), Some((before, step))) = (limits.jerk[j], before) {
            let rise = (acceleration - before[j]).abs() / step;
            factor = factor.max((rise / (SHARES[1] * jerk)).cbrt());
        }
        accelerations.push(acceleration);
    }
    (factor, accelerations)
}

/// How many times slower a motion must be to keep all limits, at least 1.
fn excess(path: &Path, speed: &Speed, limits: &Limits, samples: usize) -> f64 {
    let step = speed.duration() / samples as f64;
    let mut factor = 1.0_f64;
    let mut before: Option<Vec<f64>> = None;
    for k in 0..=samples {
        let now = speed.at(k as f64 * step);
        let before_now = before.as_deref().map(|before| (before, step));
        let (share, accelerations) = share_of_limits(&path.at(now.s), now, limits, before_now);
        factor = factor.max(share);
        before = Some(accelerations);
    }
    factor
}

/// The grid of cells over a path, whose ends are its knots among others.
pub(crate) fn grid(path: &Path) -> Vec<f64> {
    let cells = (path.length() / CELL).max(CELLS);
    mrroc_generators::timing::grid(&Parameter { knots: path.knots() }, cells as usize)
}

/// The largest speed in each cell of a grid.
pub(crate) struct Passed<'a> {
    grid: &'a [f64],
    most: Vec<f64>,
}

impl<'a> Passed<'a> {
    /// Of a motion along the path of the grid.
    pub(crate) fn of(grid: &'a [f64], speed: &Speed) -> Self {
        let mut most = vec![0.0_f64; grid.len() - 1];
        let mut first = 0;
        for pair in speed.breaks().windows(2) {
            let [from, to] = [speed.at(pair[0]), speed.at(pair[1])];
            let v = speed.most_in_piece(pair[0], pair[1]);
            while first + 1 < most.len() && grid[first + 1] <= from.s + ROUNDING {
                first += 1;
            }
            for (cell, most) in most.iter_mut().enumerate().skip(first) {
                if cell > first && grid[cell] >= to.s - ROUNDING {
                    break;
                }
                *most = most.max(v);
            }
        }
        Passed { grid, most }
    }

    /// The largest speed in each cell, of which there are so many.
    pub(crate) fn most(self) -> Vec<f64> {
        self.most
    }

    /// The last cell before `end` that is reached from a cell within the reaction time \[s\], and the largest speed until then.
    pub(crate) fn ahead(&self, cell: usize, end: usize, reaction: f64) -> (usize, f64) {
        let mut most = self.most[cell];
        let mut last = cell;
        while last + 1 < end && self.grid[last + 1] < self.grid[cell + 1] + most * reaction {
            last += 1;
            most = most.max(self.most[last]);
        }
        (last, most)
    }
}
