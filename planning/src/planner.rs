//! Plans motions of all robots of a clearance.

use core::f64::consts::{PI, TAU};
use std::sync::Arc;

use mrroc::robot::JointKind;
use mrroc_robots::clearance::{Clearance, Nearest};
use nalgebra::Vector3;

use crate::arm::Arm;
use crate::check::Checker;
use crate::edge::{Edges, single};
use crate::error::PlanError;
use crate::limits::Limits;
use crate::path::Path;
use crate::plan::{Motion, Plan};
use crate::search::{Roadmap, Samples, find, shorten};
use crate::speed::Speed;
use crate::stop::ROBOTS;
use crate::timing::timed;
use crate::upright::Upright;
use crate::via;

/// Ranges longer than this have no ends that matter to a plan: two turns.
const ENDLESS: f64 = 2.0 * TAU;

/// How much more than the margins paths keep \[m\]: what is left for stops, which leave them. Where no speed is slow enough for these, the
/// path is searched for anew with the second one.
pub(crate) const MORE: [f32; 2] = [5e-4, 3e-3];

/// Plans motions for the robots of a [`Clearance`], with its bodies, pairs and margins.
///
/// Planning is deterministic: the same clearance, start, goals and settings give the same plan, to the bit; with a
/// [roadmap](Self::with_roadmap) the same sequence of queries gives the same plans.
#[derive(Clone)]
pub struct Planner {
    clearance: Clearance,
    pub(crate) checker: Checker,
    pub(crate) edges: Edges,
    pub(crate) limits: Limits,
    pub(crate) seed: u64,
    pub(crate) effort: u64,
    pub(crate) reaction: f64,
    roadmap: Roadmap,
}

impl Planner {
    /// For all robots of `clearance`, 1 to 4.
    ///
    /// # Errors
    /// [`PlanError::Robots`].
    pub fn new(clearance: Clearance) -> Result<Self, PlanError> {
        let checker = Checker::new(&clearance);
        let limits = Limits::of(&checker.arms);
        let edges = Edges::default();
        let (seed, effort, reaction, roadmap) = (1, 400_000, 0.03, Roadmap::default());
        Planner { clearance, checker, edges, limits, seed, effort, reaction, roadmap }.has_robots()
    }

    /// Itself, if it has as many robots as it can plan for.
    pub(crate) fn has_robots(self) -> Result<Self, PlanError> {
        match self.checker.arms.len() {
            1..=ROBOTS => Ok(self),
            robots => Err(PlanError::Robots(robots)),
        }
    }

    /// The same with another clearance.
    pub(crate) fn with_clearance(&self, clearance: Clearance) -> Self {
        let mut checker = Checker::new(&clearance);
        checker.uprights = self.checker.uprights.clone();
        let (limits, edges) = (Limits::of(&checker.arms), Edges::default());
        let (Planner { seed, effort, reaction, .. }, roadmap) = (self, self.roadmap.emptied());
        let (seed, effort, reaction) = (*seed, *effort, *reaction);
        Planner { clearance, checker, edges, limits, seed, effort, reaction, roadmap }
    }

    /// The robot of this name.
    pub(crate) fn arm(&self, robot: &str) -> Result<&Arm, PlanError> {
        let arms = &self.checker.arms;
        let found = arms.iter().find(|arm| arm.name().as_str() == robot);
        found.ok_or_else(|| PlanError::no_robot(robot, arms.iter().map(Arm::name)))
    }

    /// Another seed of its samples: another path, where there are several.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// The effort of a plan, in checks of eight postures; 400,000 unless said otherwise, which is about a second. At most four fifths of
    /// it are for the search of a first path. The rest is for making it shorter, which ends as soon as that gains nothing.
    ///
    /// A motion that is being checked when the effort ends is checked to its end. Rounding corners and proving stops are not counted:
    /// every plan needs them, and they end.
    #[must_use]
    pub fn with_effort(mut self, checks: u64) -> Self {
        self.effort = checks;
        self
    }

    /// The time from a fault until the last robot brakes \[s\], finite and >= 0: 30 ms unless said otherwise, enough for steps of up to
    /// 2 ms. Another number is refused when a plan is asked for.
    #[must_use]
    pub fn with_reaction(mut self, reaction: f64) -> Self {
        self.reaction = reaction;
        self
    }

    /// Remembers what its queries prove, and tries that first in later ones: a roadmap of at most so many positions, of which those that are known the
    /// longest are forgotten; 0, unless said otherwise, is none. Some thousand are enough for an arm; one has about 150 bytes.
    ///
    /// A start and a goal from which a straight motion to one of the nearest of these positions is clear need no search. That gains much where paths are
    /// hard to find, as through a window, and where the same positions come again; see the book for figures. Where it does not help, the
    /// planner searches as without it, by what its few checks have left of the effort.
    ///
    /// A plan then depends on the queries before it: the same ones in the same order give the same plans, to the bit. A clone goes on with what is known when it is
    /// made. A planner of another world, as of [`beside`](Self::beside), or with something more to keep upright, begins with nothing.
    #[must_use]
    pub fn with_roadmap(mut self, positions: usize) -> Self {
        self.roadmap = Roadmap::new(positions);
        self
    }

    /// Keeps an axis of a robot's flange upright on the whole path: its angle from the vertical, the z axis of the world, is at most
    /// `tolerance` \[rad\], above 0 and below pi, between samples too. `axis_F` is in the flange's frame, of any length. A robot may have several.
    ///
    /// Start and goals must be upright. Suspensions and other stops on the path stay so; **fault stops do not**.
    ///
    /// ```
    /// # use mrroc_planning::{PlanError, Planner};
    /// # fn with_a_cup(planner: Planner) -> Result<Planner, PlanError> {
    /// // The tool points down, so what it holds stands upright while the flange's z axis points down.
    /// planner.with_upright("arm", -nalgebra::Vector3::z(), 0.1)
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`PlanError::NoRobot`], [`PlanError::BadUpright`].
    #[allow(non_snake_case)]
    pub fn with_upright(
        mut self,
        robot: &str,
        axis_F: Vector3<f64>,
        tolerance: f64,
    ) -> Result<Self, PlanError> {
        let robot = self.arm(robot)?.name();
        let length = axis_F.norm();
        if !(length.is_finite() && length > 0.0 && tolerance > 0.0 && tolerance < PI) {
            return Err(PlanError::BadUpright { robot: robot.to_string() });
        }
        self.checker.uprights.0.push(Upright { robot, axis_F: axis_F / length, tolerance });
        self.roadmap = self.roadmap.emptied();
        Ok(self)
    }

    /// The clearance that it plans with.
    #[must_use]
    pub const fn clearance(&self) -> &Clearance {
        &self.clearance
    }

    /// A motion from rest to rest: from the joint positions `start` [rad or m] of all robots, one behind the other, to the first of
    /// `goals` that is reached.
    ///
    /// # Errors
    /// [`PlanError`].
    pub fn plan(&mut self, start: &[f64], goals: &[Vec<f64>]) -> Result<Plan, PlanError> {
        self.plan_through(start, &[goals])
    }

    /// One motion from rest to rest that passes one position of each list of `stages` after the other, and ends at one of the last list.
    /// Of each list it is the position that is reached first.
    ///
    /// The motion does not rest on the way: it passes each position there **exactly**, on a curve. Where the path turns back there
    /// (by more than 168°), or has no room for a curve, it passes within 1e-4 rad or m of it, at hardly any speed.
    ///
    /// # Errors
    /// [`PlanError`]; [`PlanError::Stage`] tells which of several lists failed.
    pub fn plan_through<G: AsRef<[Vec<f64>]>>(
        &mut self,
        start: &[f64],
        stages: &[G],
    ) -> Result<Plan, PlanError> {
        let stages: Vec<&[Vec<f64>]> = stages.iter().map(AsRef::as_ref).collect();
        match self.planned_through(start, &stages, MORE[0]) {
            Err(error @ PlanError::StopsNotClear { .. }) => {
                self.planned_through(start, &stages, MORE[1]).map_err(|_| error)
            }
            found => found,
        }
    }

    /// A motion on a path that keeps so much `more` than the margins \[m\].
    fn planned_through(
        &mut self,
        start: &[f64],
        stages: &[&[Vec<f64>]],
        more: f32,
    ) -> Result<Plan, PlanError> {
        let parts = self.find_through(start, stages, more)?;
        let last = parts.last().and_then(|part| part.last()).map_or(start, Vec::as_slice);
        let ends = [start.to_vec(), last.to_vec()];
        let offset = self.offset(start);
        self.checker.offset.clone_from(&offset);
        let parts: Vec<Vec<Vec<f64>>> =
            parts.iter().map(|part| part.iter().map(|q| reduced(q, &offset)).collect()).collect();
        let mut curved = parts.len() > 1;
        let more = self.checker.more;
        let (path, (speed, grid)) = loop {
            self.checker.more = more;
            let points = via::passed(&mut self.checker, &mut self.edges, &parts, curved);
            if points.len() < 2 {
                break (Path::point(&reduced(start, &offset)), (Speed::still(), vec![0.0]));
            }
            let path = Path::rounded(&mut self.checker, &mut self.edges, &points);
            self.checker.more = 0.0;
            match timed(&mut self.checker, &path, &self.limits, self.reaction, None) {
                Ok(timed) => break (path, timed),
                // A sharp turn may leave no speed in the middle of a wide curve, or no room for its stops.
                Err(PlanError::Timing(_) | PlanError::StopsNotClear { .. }) if curved => curved = false,
                Err(error) => return Err(error),
            }
        };
        let robots = self.checker.arms.iter().map(Arm::name).collect();
        let (limits, reaction) = (self.limits.clone(), self.reaction);
        let (leaves, carries) = (0.0, false);
        let motion = Motion { path, speed, limits, offset, ends, grid, leaves, reaction, carries };
        Ok(Plan { robots, motion: Arc::new(motion) })
    }

    /// For each of `stages` the points of a path to one of its positions from where the stage before ends, shortened. What is kept
    /// more than the margins is from then on what all of them keep.
    pub(crate) fn find_through(
        &mut self,
        start: &[f64],
        stages: &[&[Vec<f64>]],
        wanted: f32,
    ) -> Result<Vec<Vec<Vec<f64>>>, PlanError> {
        if stages.is_empty() {
            return Err(PlanError::NoStage);
        }
        let of_stage = |stage: usize, error: PlanError| match stages.len() {
            1 => error,
            stages => PlanError::Stage { stage: stage + 1, stages, why: Box::new(error) },
        };
        let end = self.checker.batches + self.effort;
        self.may_begin(start)?;
        // A goal that cannot be reached is told before any search.
        let goals = stages.iter().enumerate();
        let goals = goals.map(|(i, goals)| self.clear_goals(goals).map_err(|error| of_stage(i, error)));
        let goals = goals.collect::<Result<Vec<_>, _>>()?;
        let mut parts: Vec<Vec<Vec<f64>>> = Vec::new();
        let mut more = wanted;
        for (i, goals) in goals.iter().enumerate() {
            let from = parts.last().and_then(|part| part.last()).map_or(start, Vec::as_slice).to_vec();
            // What the stages before have left is shared evenly.
            let left = (stages.len() - i) as u64;
            let effort = end.saturating_sub(self.checker.batches) * 4 / (5 * left);
            parts.push(self.search(&from, goals, effort, wanted).map_err(|error| of_stage(i, error))?);
            more = more.min(self.checker.more);
        }
        self.checker.more = more;
        for (i, part) in parts.iter_mut().enumerate() {
            let effort = end.saturating_sub(self.checker.batches) / (stages.len() - i) as u64;
            self.shorten_by(part, effort);
        }
        Ok(parts)
    }

    /// Points of a path whose straight legs are clear, without corners rounded and without times: [`find_first`](Self::find_first) by at
    /// most four fifths of the effort, then [`shorten`](Self::shorten) by what is left.
    ///
    /// # Errors
    /// [`PlanError`].
    pub fn find(&mut self, start: &[f64], goals: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, PlanError> {
        let parts = self.find_through(start, &[goals], MORE[0])?;
        Ok(parts.into_iter().flatten().collect())
    }

    /// The first path that is found, usually a long one: points whose straight legs are clear, from `start` to one of `goals`.
    ///
    /// # Errors
    /// [`PlanError`].
    pub fn find_first(&mut self, start: &[f64], goals: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, PlanError> {
        self.start_is_clear(start)?;
        let clear = self.clear_goals(goals)?;
        self.search(start, &clear, self.effort, MORE[0])
    }

    /// Whether there may be a motion from `start`, with the reaction time that was told.
    pub(crate) fn may_begin(&mut self, start: &[f64]) -> Result<(), PlanError> {
        if !(self.reaction.is_finite() && self.reaction >= 0.0) {
            return Err(PlanError::Reaction(self.reaction));
        }
        self.start_is_clear(start)
    }

    fn start_is_clear(&mut self, start: &[f64]) -> Result<(), PlanError> {
        self.within_limits("start", start)?;
        self.checker.more = 0.0;
        if self.checker.is_clear(start) {
            self.is_upright("start", start)
        } else {
            Err(PlanError::StartNotClear(Box::new(self.nearest(start)?)))
        }
    }

    /// Those goals that are clear, at least one.
    pub(crate) fn clear_goals<'a>(&mut self, goals: &'a [Vec<f64>]) -> Result<Vec<&'a [f64]>, PlanError> {
        self.checker.more = 0.0;
        let mut clear = Vec::new();
        let mut refused = None;
        for goal in goals {
            self.within_limits("goal", goal)?;
            let is_clear = self.checker.is_clear(goal);
            let is_upright = self.is_upright("goal", goal);
            if is_clear && is_upright.is_ok() {
                clear.push(goal.as_slice());
            } else if refused.is_none() {
                let nearest = if is_clear { None } else { Some(Box::new(self.nearest(goal)?)) };
                refused = nearest.map(PlanError::GoalNotClear).or(is_upright.err());
            }
        }
        if clear.is_empty() { Err(refused.unwrap_or(PlanError::NoGoal)) } else { Ok(clear) }
    }

    fn is_upright(&self, place: &'static str, q: &[f64]) -> Result<(), PlanError> {
        for upright in &self.checker.uprights.0 {
            let Some(arm) = self.checker.arms.iter().find(|arm| arm.name() == upright.robot) else {
                continue;
            };
            let (tilt, tolerance) = (upright.tilt(arm, q), upright.tolerance);
            // What is no number is not upright.
            if tilt.is_nan() || tilt > tolerance {
                return Err(PlanError::NotUpright {
                    place,
                    robot: upright.robot.to_string(),
                    tilt,
                    tolerance,
                });
            }
        }
        Ok(())
    }

    /// The first path from a clear start to one of the clear goals, at least one, by so many checks.
    fn search(
        &mut self,
        start: &[f64],
        clear: &[&[f64]],
        effort: u64,
        more: f32,
    ) -> Result<Vec<Vec<f64>>, PlanError> {
        // Where the start itself is no farther than its margin from something, the path is not either.
        for more in [more, MORE[0], 0.0] {
            self.checker.more = more;
            if self.checker.is_clear(start) && clear.iter().any(|goal| self.checker.is_clear(goal)) {
                break;
            }
        }
        let offset = self.offset(start);
        self.checker.offset.clone_from(&offset);
        let from = inner(start, &offset);
        let to: Vec<Vec<f32>> = clear.iter().map(|goal| inner(goal, &offset)).collect();
        let [lower, upper] = self.ranges(&from, &to);
        let mut samples = Samples::new(self.seed, &lower, &upper);
        let before = self.checker.batches;
        self.roadmap.turn(&self.checker);
        let Planner { checker, edges, roadmap, .. } = self;
        match find(checker, edges, &mut samples, roadmap, &from, &to, effort) {
            Ok(path) => {
                let goal =
                    to.iter().position(|goal| path.last() == Some(goal)).map_or(clear[0], |i| clear[i]);
                // Where the start is a goal, the path may be one point.
                let middle = path.get(1..path.len() - 1).unwrap_or_default();
                let middle = middle.iter().map(|q| outer(q, &offset, start));
                Ok(core::iter::once(start.to_vec()).chain(middle).chain([goal.to_vec()]).collect())
            }
            Err((nearest, apart)) => {
                let nearest = Box::new(self.nearest(&outer(&nearest, &offset, start))?);
                Err(PlanError::NotFound { checks: self.checker.batches - before, apart, nearest })
            }
        }
    }

    /// Makes a path shorter, as far as a quarter of the effort allows; its ends stay. What replaces a part of it is clear; the rest stays as it is,
    /// clear or not.
    pub fn shorten(&mut self, points: &mut Vec<Vec<f64>>) {
        self.shorten_by(points, self.effort / 4);
    }

    fn shorten_by(&mut self, points: &mut Vec<Vec<f64>>, effort: u64) {
        let [Some(start), Some(goal)] = [points.first().cloned(), points.last().cloned()] else { return };
        let offset = self.offset(&start);
        self.checker.offset.clone_from(&offset);
        let mut path: Vec<Vec<f32>> = points.iter().map(|q| inner(q, &offset)).collect();
        shorten(&mut self.checker, &mut self.edges, self.seed, &mut path, effort);
        self.roadmap.turn(&self.checker);
        self.roadmap.keep_clear(&mut self.checker, &mut self.edges, &path);
        *points = path.iter().map(|q| outer(q, &offset, &start)).collect();
        let last = points.len() - 1;
        points[0] = start;
        points[last] = goal;
    }

    /// Whole turns by which endless joints are off what they are computed with, so that single precision is enough [rad].
    pub(crate) fn offset(&self, start: &[f64]) -> Vec<f64> {
        (0..start.len())
            .map(|j| if self.is_endless(j) { (start[j] / TAU).round() * TAU } else { 0.0 })
            .collect()
    }

    fn is_endless(&self, joint: usize) -> bool {
        let Limits { kinds, lower, upper, .. } = &self.limits;
        kinds[joint] == JointKind::Revolute && upper[joint] - lower[joint] > ENDLESS
    }

    /// Where samples are drawn: within the limits; endless joints a turn around the start and the goals.
    fn ranges(&self, from: &[f32], to: &[Vec<f32>]) -> [Vec<f32>; 2] {
        let range = |j: usize| {
            if self.is_endless(j) {
                let ends = core::iter::once(from[j]).chain(to.iter().map(|goal| goal[j]));
                let (least, most) =
                    ends.fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), q| (a.min(q), b.max(q)));
                (least - PI as f32, most + PI as f32)
            } else {
                (self.limits.lower[j] as f32, self.limits.upper[j] as f32)
            }
        };
        [(0..from.len()).map(|j| range(j).0).collect(), (0..from.len()).map(|j| range(j).1).collect()]
    }

    fn within_limits(&self, place: &'static str, q: &[f64]) -> Result<(), PlanError> {
        let expected = self.limits.joints();
        if q.len() != expected {
            return Err(PlanError::Joints { expected, actual: q.len() });
        }
        for arm in &self.checker.arms {
            let robot = arm.name().as_str().to_owned();
            for j in 0..arm.joints {
                let (position, lower, upper) =
                    (q[arm.first + j], self.limits.lower[arm.first + j], self.limits.upper[arm.first + j]);
                if !(lower..=upper).contains(&position) {
                    return Err(PlanError::Limit { place, robot, joint: j + 1, position, lower, upper });
                }
            }
            if arm.part.shape.is_coupled() && !arm.part.shape.is_possible(&arm.own(q)) {
                return Err(PlanError::Coupled { place, robot });
            }
        }
        Ok(())
    }

    /// What is nearest at a position.
    pub(crate) fn nearest(&mut self, q: &[f64]) -> Result<Nearest, PlanError> {
        Ok(self.clearance.nearest_at(&self.limits.split(q))?)
    }
}

/// Positions without whole turns.
pub(crate) fn reduced(q: &[f64], offset: &[f64]) -> Vec<f64> {
    q.iter().zip(offset).map(|(q, offset)| q - offset).collect()
}

/// Positions as they are computed with.
fn inner(q: &[f64], offset: &[f64]) -> Vec<f32> {
    single(&reduced(q, offset))
}

/// The positions that are computed with as `q`. A joint that is computed to be where it is at the `start` is there exactly: what stays
/// does not move by a rounding.
fn outer(q: &[f32], offset: &[f64], start: &[f64]) -> Vec<f64> {
    let joints = q.iter().zip(offset).zip(start);
    let place = |((q, offset), start): ((&f32, &f64), &f64)| {
        if *q == (start - offset) as f32 { *start } else { f64::from(*q) + offset }
    };
    joints.map(place).collect()
}
