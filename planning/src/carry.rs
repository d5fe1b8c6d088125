//! Motions of a body that several arms hold rigidly, around obstacles.
//!
//! In: arms, their positions where they hold the body, and where it is to be. Out: a [`Carried`]: how the body moves, with the joints of all arms on the
//! way, on the branch of their inverse kinematics that they have at the start, and times within the limits of all joints.
//!
//! ```text
//! X_WB(u) -> X_WE_i = X_WB X_BE_i -> inverse kinematics of each arm -> curves of degree 5 through joints and their derivatives -> clear? limits? stops?
//! ```
//!
//! The search is in the body's pose, `y = (p - p_0, log(R R_0^-1))` of where it is at the start. Straight motions of `y` are cut into steps; between two
//! steps the joints are off the chord by no more than their middle tells, with room for more. What is found is then proven: each piece of the path is a curve in the
//! joints, which passes the solutions with their first and second derivatives, and misses them by less than [`MISS`] between its ends.

use std::collections::BTreeMap;
use std::sync::Arc;

use mrroc::pose::Pose;
use mrroc::prelude::Fault;
use mrroc_generators::cooperation::{BodyFrame, BodyPath};
use mrroc_robots::Kinematics;
use nalgebra::{SVector, Translation3, UnitQuaternion, Vector3};

use crate::arm::Arm;
use crate::check::Checker;
use crate::edge::{Edges, single};
use crate::error::PlanError;
use crate::path::{Path, Piece, along, bezier, curve, direction, distance};
use crate::plan::{Motion, Plan};
use crate::planner::{MORE, Planner, reduced};
use crate::search::{Samples, Space, connect, rooted, shorten_any, straight};
use crate::speed::Speed;
use crate::timing::timed;

/// How far beyond start and goal the body is looked for \[m\] and [rad].
const BEYOND: [f64; 2] = [0.6, 1.0];
/// The longest step of a search, and of the body between two steps of a motion [m or rad].
const STEP: f64 = 0.3;
const LONGEST: f64 = 0.06;
/// The most that a joint moves from a step to its middle, and is off the chord there: more is a jump to another branch, or too near to a singular posture
/// [rad or m].
const JUMP: [f64; 2] = [0.15, 0.02];
/// By how much more than in its middle the joints may be off the chord of a step: a share, and as much [rad or m].
const OFF: [f64; 2] = [1.5, 1e-4];
/// The distance from a corner of the body's path at which it is rounded, and the least [m or rad].
const ROUNDED: [f64; 2] = [0.15, 0.01];
/// How far a piece of the path misses the joints between its ends at most [rad or m].
const MISS: f64 = 2e-11;
/// The longest and the shortest such piece [m or rad].
const PIECE: [f64; 2] = [0.04, 5e-4];
/// From where derivatives are taken, to either side [m or rad], at most; as a share of a piece of the body's path, and of one of the joints'.
const BESIDE: [f64; 3] = [5e-4, 5e-3, 0.02];
/// How far the body may be from where a motion begins [m or rad].
const SAME: f64 = 1e-6;
/// A shorter motion is none [m or rad].
const REST: f64 = 1e-9;

type Forward = Arc<dyn Fn(&[f64]) -> Pose + Send + Sync>;
type Inverse = Arc<dyn Fn(&Pose, &[f64]) -> Option<Vec<f64>> + Send + Sync>;

/// Arms that hold one body rigidly, each with its flange: see [`Planner::carry`].
#[derive(Clone, Default)]
pub struct Holders(Vec<Holder>);

#[derive(Clone)]
struct Holder {
    robot: String,
    forward: Forward,
    inverse: Inverse,
}

impl Holders {
    /// Nobody yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// And the robot of this name, whose kinematics, with its base, is that of `robot`.
    #[must_use]
    pub fn and<const N: usize, R>(mut self, name: &str, robot: &R) -> Self
    where
        R: Kinematics<N> + Clone + Send + Sync + 'static,
    {
        let near = |q: &[f64]| SVector::<f64, N>::from_fn(|i, _| q.get(i).copied().unwrap_or_default());
        let (one, two) = (robot.clone(), robot.clone());
        let forward: Forward = Arc::new(move |q| one.forward(&near(q)));
        let inverse: Inverse = Arc::new(move |pose, q| {
            let found = two.inverse(pose, &near(q)).ok()?;
            two.is_attainable(&found).then(|| found.as_slice().to_vec())
        });
        self.0.push(Holder { robot: name.to_owned(), forward, inverse });
        self
    }
}

/// A motion of a body that arms hold, made by [`Planner::carry`].
#[derive(Clone)]
pub struct Carried {
    plan: Plan,
    body: Arc<Body>,
}

/// How the body moves, by the parameter of the plan's path.
struct Body {
    path: Path,
    begins: Pose,
    ends: Pose,
}

impl Body {
    fn at(&self, u: f64) -> Pose {
        pose(&self.begins, &self.path.at(u).q)
    }
}

impl Carried {
    /// The same motion as that of all joints, which any [`Plan`] is: what a [`PlanGuard`](crate::PlanGuard) watches.
    #[must_use]
    pub const fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Where the body is at a path time \[s\]: `X_WB`.
    #[must_use]
    pub fn body_at(&self, time: f64) -> Pose {
        let speed = &self.plan.motion.speed;
        if time <= speed.begins {
            self.body.begins
        } else if time >= speed.duration() {
            self.body.ends
        } else {
            self.body.at(speed.at(time).s)
        }
    }

    /// The path of the body, for a [`RigidCarry`](mrroc_generators::generators::RigidCarry) with the body's frame of the query.
    #[must_use]
    pub fn path(&self) -> CarriedPath {
        CarriedPath { carried: self.clone(), time: 0.0, is_over: false }
    }
}

/// The path of a body: see [`Carried::path`].
#[derive(Clone)]
pub struct CarriedPath {
    carried: Carried,
    time: f64,
    is_over: bool,
}

impl BodyPath for CarriedPath {
    #[allow(non_snake_case)]
    fn begin(&mut self, X_WB: &Pose) -> Result<(), Fault> {
        (self.time, self.is_over) = (0.0, false);
        let off = self.carried.body.begins.inv_mul(X_WB);
        let (distance, angle) = (off.translation.vector.norm(), off.rotation.angle());
        if distance <= SAME && angle <= SAME {
            return Ok(());
        }
        let text = format!("the body is {distance:.2e} m and {angle:.2e} rad from where the plan begins");
        Err(Fault::thrown(&text))
    }

    fn advance(&mut self, dt: f64) -> Result<Option<Pose>, Fault> {
        if self.is_over {
            return Ok(None);
        }
        let duration = self.carried.plan.duration();
        self.time += dt;
        // The sum of n increments may miss n * dt by rounding; that must not cost a step.
        self.is_over = duration - self.time <= 1e-9 * dt;
        Ok(Some(self.carried.body_at(if self.is_over { duration } else { self.time })))
    }
}

impl Planner {
    /// A motion of a body that `holders` hold rigidly, from rest to rest: from where it is when all robots are at `start` [rad or m], to `X_WG` in the world. Its
    /// frame at the start is `body`. Robots that do not hold it stay where they are.
    ///
    /// The body and what its holders do on the way keep the margins, between samples too, and all joints their limits. In the clearance the first
    /// holder has grasped the body ([`grasp`](mrroc_robots::clearance::Clearance::grasp)), and the pairs of the body with the links of the others that
    /// hold it are ignored. Each arm stays on the branch of its inverse kinematics that it has at the start; the body is looked for up to 0.6 m and 1 rad beyond
    /// start and goal. There is no motion through singular postures.
    ///
    /// Let a `RigidCarry` move the arms, `along` the same `body` and [`Carried::path`]. It tells all arms poses of the same body, so their relative pose
    /// is kept to rounding.
    ///
    /// # Stops
    ///
    /// **Suspensions and other stops on the path are proven**: they keep the margins, and the arms together. Of fault stops it is proven, as of any plan, that
    /// each arm that brakes in its own joints keeps clear, with the body in the grasp of the first; then the arms pull at the body. **Fault stops on the common
    /// twist, on which the arms of a `RigidCarry` brake together, are not proven**: they leave the path along the body's tangent, not along the
    /// joints'. Leave them room by the margin.
    ///
    /// # Errors
    /// [`PlanError`]; [`PlanError::OffBranch`] and [`PlanError::Singular`] are those of held bodies alone.
    #[allow(non_snake_case)]
    pub fn carry(
        &mut self,
        holders: &Holders,
        body: BodyFrame,
        start: &[f64],
        X_WG: &Pose,
    ) -> Result<Carried, PlanError> {
        match self.carried(holders, body, start, X_WG, MORE[0]) {
            Err(error @ PlanError::StopsNotClear { .. }) => {
                self.carried(holders, body, start, X_WG, MORE[1]).map_err(|_| error)
            }
            found => found,
        }
    }

    #[allow(non_snake_case)]
    fn carried(
        &mut self,
        holders: &Holders,
        body: BodyFrame,
        start: &[f64],
        X_WG: &Pose,
        more: f32,
    ) -> Result<Carried, PlanError> {
        self.may_begin(start)?;
        let offset = self.offset(start);
        self.checker.offset.clone_from(&offset);
        let chain = Chain::closed(&self.checker.arms, holders, body, start)?;
        let goal = chain.coordinates(X_WG);
        let last = chain.joints_of(&goal, start).map_err(|robot| PlanError::OffBranch { robot })?;
        self.clear_goals(core::slice::from_ref(&last))?;
        self.checker.more = more;
        let mut space = Bodies {
            checker: &mut self.checker,
            edges: &mut self.edges,
            chain: &chain,
            offset: &offset,
            known: BTreeMap::new(),
        };
        let to: Vec<Vec<f32>> = vec![single(&goal)];
        space.know(&[0.0; 6], start.to_vec());
        space.know(&to[0], last.clone());
        let range = |i: usize| {
            let beyond = BEYOND[i / 3];
            [(goal[i].min(0.0) - beyond) as f32, (goal[i].max(0.0) + beyond) as f32]
        };
        let [lower, upper] = [0, 1].map(|end| (0..6).map(|i| range(i)[end]).collect::<Vec<_>>());
        let mut samples = Samples::new(self.seed, &lower, &upper);
        let before = space.checker.batches;
        let effort = self.effort * 4 / 5;
        let found = straight(&mut space, &[0.0; 6], &to)
            .map_or_else(|| connect(&mut space, &mut samples, &mut rooted(&[0.0; 6], &to), &to, effort), Ok);
        let mut points = match found {
            Ok(points) => points,
            Err((nearest, apart)) => {
                let q = space.known(&nearest).unwrap_or_else(|| start.to_vec());
                let checks = space.checker.batches - before;
                return Err(PlanError::NotFound { checks, apart, nearest: Box::new(self.nearest(&q)?) });
            }
        };
        let left = self.effort.saturating_sub(space.checker.batches - before);
        shorten_any(&mut space, self.seed, &mut points, left);
        let mut points: Vec<Vec<f64>> =
            points.iter().map(|y| y.iter().map(|y| f64::from(*y)).collect()).collect();
        if let Some(end) = points.last_mut() {
            end.copy_from_slice(&goal);
        }
        points.dedup_by(|b, a| distance(a, b) < REST);
        if points.len() < 2 {
            let path = Path::point(&reduced(start, &offset));
            let still = Path::point(&[0.0; 6]);
            return Ok(self.carrying(
                path,
                (Speed::still(), vec![0.0]),
                [start, start],
                still,
                [&chain.begins; 2],
            ));
        }
        let body = space.rounded(&points);
        let path = chain.path(&body, start, &offset).map_err(|at| PlanError::Singular { at })?;
        self.checker.more = 0.0;
        if !path.is_clear(&mut self.checker, &mut self.edges, [0.0, path.length()]) {
            return Err(PlanError::Singular { at: 100.0 });
        }
        let timed = timed(&mut self.checker, &path, &self.limits, self.reaction)?;
        let last = along(&path.at(path.length()).q, &offset, 1.0);
        Ok(self.carrying(path, timed, [start, &last], body, [&chain.begins, X_WG]))
    }

    fn carrying(
        &self,
        path: Path,
        (speed, grid): (Speed, Vec<f64>),
        ends: [&[f64]; 2],
        body: Path,
        [begins, ends_at]: [&Pose; 2],
    ) -> Carried {
        let motion = Motion {
            path,
            speed,
            limits: self.limits.clone(),
            offset: self.checker.offset.clone(),
            ends: ends.map(<[f64]>::to_vec),
            grid,
            leaves: 0.0,
            reaction: self.reaction,
        };
        let robots = self.checker.arms.iter().map(Arm::name).collect();
        let body = Body { path: body, begins: *begins, ends: *ends_at };
        Carried { plan: Plan { robots, motion: Arc::new(motion) }, body: Arc::new(body) }
    }
}

/// The pose at coordinates that count from a pose.
fn pose(from: &Pose, y: &[f64]) -> Pose {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(y[3], y[4], y[5]));
    let place = from.translation.vector + Vector3::new(y[0], y[1], y[2]);
    Pose::from_parts(Translation3::from(place), turn * from.rotation)
}

/// Arms that a body joins.
struct Chain<'a> {
    holders: &'a [Holder],
    /// The first joint of each holder, and how many it has.
    joints: Vec<[usize; 2]>,
    /// `X_BE` of each holder.
    grasps: Vec<Pose>,
    /// Where the body is at the start.
    begins: Pose,
}

impl<'a> Chain<'a> {
    fn closed(
        arms: &[Arm],
        Holders(holders): &'a Holders,
        body: BodyFrame,
        start: &[f64],
    ) -> Result<Self, PlanError> {
        if holders.is_empty() {
            return Err(PlanError::Robots(0));
        }
        let mut joints = Vec::new();
        let mut tools = Vec::new();
        for Holder { robot, forward, .. } in holders {
            let arm = arms.iter().find(|arm| arm.name().as_str() == robot);
            let arm = arm.ok_or_else(|| PlanError::no_robot(robot, arms.iter().map(Arm::name)))?;
            joints.push([arm.first, arm.joints]);
            tools.push(forward(&start[arm.first..arm.first + arm.joints]));
        }
        let begins = body.pose(&tools);
        let grasps = tools.iter().map(|tool| begins.inv_mul(tool)).collect();
        Ok(Chain { holders, joints, grasps, begins })
    }

    #[allow(non_snake_case)]
    fn coordinates(&self, X_WB: &Pose) -> [f64; 6] {
        let by = X_WB.translation.vector - self.begins.translation.vector;
        let turn = (X_WB.rotation * self.begins.rotation.inverse()).scaled_axis();
        [by.x, by.y, by.z, turn.x, turn.y, turn.z]
    }

    /// The joints of all robots with the body there, on the branch that is nearest; or the robot that has none.
    fn joints_of(&self, y: &[f64], near: &[f64]) -> Result<Vec<f64>, String> {
        let body = pose(&self.begins, y);
        let mut q = near.to_vec();
        for ((holder, [first, count]), grasp) in self.holders.iter().zip(&self.joints).zip(&self.grasps) {
            let own = *first..first + count;
            let found = (holder.inverse)(&(body * grasp), &near[own.clone()]);
            q[own].copy_from_slice(&found.ok_or_else(|| holder.robot.clone())?);
        }
        Ok(q)
    }

    /// The path of all joints for that of the body, by the same parameter; or how much of it there is, in percent.
    fn path(&self, body: &Path, start: &[f64], offset: &[f64]) -> Result<Path, f64> {
        let mut path = Path { knots: vec![0.0], pieces: Vec::new() };
        let mut near = start.to_vec();
        for (ends, piece) in body.knots().windows(2).zip(&body.pieces) {
            let width = ends[1] - ends[0];
            let at = |s: f64| -> Vec<f64> {
                match piece {
                    Piece::Leg { from, along: e } => along(from, e, s),
                    Piece::Curve(points) => points.iter().map(|p| bezier(p, s / width)[0]).collect(),
                }
            };
            let (mut from, mut step) = (0.0, PIECE[0]);
            while from < width {
                let failed = 100.0 * (ends[0] + from) / body.length();
                // No rest that is all but nothing.
                let to = if from + 1.5 * step >= width { width } else { from + step };
                let beside = BESIDE[0].min(BESIDE[1] * width).min(BESIDE[2] * step);
                let curve = self.piece(&at, [from, to], beside, &near).map(|(curve, last)| {
                    near = last;
                    curve
                });
                match curve {
                    Some(curve) => {
                        let less = |(p, offset): (&[f64; 6], &f64)| p.map(|p| p - offset);
                        let curve = curve.iter().zip(offset).map(less).collect();
                        path.push(to - from, Piece::Curve(curve));
                        (from, step) = (to, PIECE[0].min(2.0 * step));
                    }
                    None if 0.5 * step < PIECE[1] => return Err(failed),
                    None => step *= 0.5,
                }
            }
        }
        Ok(path)
    }

    /// The curve of all joints while the body goes on from one place to another, and the joints there; `None` where it misses them between.
    fn piece(
        &self,
        at: &impl Fn(f64) -> Vec<f64>,
        [from, to]: [f64; 2],
        beside: f64,
        near: &[f64],
    ) -> Option<(Vec<[f64; 6]>, Vec<f64>)> {
        let width = to - from;
        let [begin, end] = [from, to].map(|s| self.derived(at, s, beside, near));
        let ([p, v, a], [q, w, b]) = (begin?, end?);
        let curve: Vec<[f64; 6]> = (0..p.len())
            .map(|j| {
                let [v, a, w, b] = [
                    v[j] * width / 5.0,
                    a[j] * width * width / 20.0,
                    w[j] * width / 5.0,
                    b[j] * width * width / 20.0,
                ];
                [p[j], p[j] + v, a + 2.0 * v + p[j], b - 2.0 * w + q[j], q[j] - w, q[j]]
            })
            .collect();
        for share in [0.25, 0.5, 0.75] {
            let joints = self.joints_of(&at(from + share * width), &p).ok()?;
            let miss = |(curve, q): (&[f64; 6], &f64)| (bezier(curve, share)[0] - q).abs();
            if curve.iter().zip(&joints).map(miss).fold(0.0, f64::max) > MISS {
                return None;
            }
        }
        Some((curve, q))
    }

    /// The joints at a place of the body's path, and their first and second derivative by its parameter, from four places beside it.
    fn derived(&self, at: &impl Fn(f64) -> Vec<f64>, s: f64, by: f64, near: &[f64]) -> Option<[Vec<f64>; 3]> {
        let middle = self.joints_of(&at(s), near).ok()?;
        let beside = |k: f64| self.joints_of(&at(s + k * by), &middle).ok();
        let [a, b, c, d] = [beside(-2.0)?, beside(-1.0)?, beside(1.0)?, beside(2.0)?];
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for j in 0..middle.len() {
            let [near, far] = [c[j] - b[j], d[j] - a[j]];
            first.push((8.0 * near - far) / (12.0 * by));
            let [near, far] = [c[j] + b[j], d[j] + a[j]].map(|sum| sum - 2.0 * middle[j]);
            second.push((16.0 * near - far) / (12.0 * by * by));
        }
        Some([middle, first, second])
    }
}

/// Places of the body, in its coordinates, between which it may move.
struct Bodies<'a> {
    checker: &'a mut Checker,
    edges: &'a mut Edges,
    chain: &'a Chain<'a>,
    offset: &'a [f64],
    /// The joints at places that motions have come to, by their bits.
    known: BTreeMap<Vec<u32>, Vec<f64>>,
}

impl Bodies<'_> {
    fn know(&mut self, y: &[f32], q: Vec<f64>) {
        self.known.insert(y.iter().map(|y| y.to_bits()).collect(), q);
    }

    fn known(&self, y: &[f32]) -> Option<Vec<f64>> {
        self.known.get(&y.iter().map(|y| y.to_bits()).collect::<Vec<_>>()).cloned()
    }

    /// The joints at a place, by those at the nearest one that is known.
    fn near(&self, y: &[f32]) -> Option<Vec<f64>> {
        let squared = |bits: &[u32]| -> f32 {
            bits.iter().zip(y).map(|(bits, y)| (f32::from_bits(*bits) - y).powi(2)).sum()
        };
        let nearest = self.known.iter().min_by(|a, b| squared(a.0).total_cmp(&squared(b.0)))?;
        let y: Vec<f64> = y.iter().map(|y| f64::from(*y)).collect();
        self.chain.joints_of(&y, nearest.1).ok()
    }

    /// The joints at the end of a motion of the body over a length, if it is clear.
    fn follow(&mut self, from: &[f64], length: f64, at: impl Fn(f64) -> Vec<f64>) -> Option<Vec<f64>> {
        let steps = (length / LONGEST).ceil().max(1.0);
        let mut q = from.to_vec();
        for k in 0..steps as usize {
            // It is counted before: what has no posture costs as well.
            self.checker.batches += 1;
            let middle = self.chain.joints_of(&at((k as f64 + 0.5) / steps), &q).ok()?;
            let next = self.chain.joints_of(&at((k as f64 + 1.0) / steps), &middle).ok()?;
            let mut off = Vec::with_capacity(q.len());
            for ((a, m), b) in q.iter().zip(&middle).zip(&next) {
                let bend = (m - 0.5 * (a + b)).abs();
                if (m - a).abs().max((b - m).abs()) > JUMP[0] || bend > JUMP[1] {
                    return None;
                }
                off.push(if a == b && bend == 0.0 { 0.0 } else { (OFF[0] * bend + OFF[1]) as f32 });
            }
            let [a, b] = [&q, &next].map(|q| single(&reduced(q, self.offset)));
            if !self.edges.is_clear_around(self.checker, &a, &b, &off) {
                return None;
            }
            q = next;
        }
        Some(q)
    }

    /// The path through points, with its corners rounded as far as is clear.
    fn rounded(&mut self, points: &[Vec<f64>]) -> Path {
        let legs: Vec<(Vec<f64>, f64)> =
            points.windows(2).map(|pair| direction(&pair[0], &pair[1])).collect();
        let mut path = Path { knots: vec![0.0], pieces: Vec::new() };
        let mut begin = points[0].clone();
        for (i, pair) in legs.windows(2).enumerate() {
            let [(e, before), (f, behind)] = pair else { continue };
            let corner = &points[i + 1];
            let mut d = ROUNDED[0].min(0.5 * before).min(0.5 * behind);
            let points = loop {
                let points = curve(corner, e, f, d);
                if d <= ROUNDED[1] || self.is_curve_clear(corner, &points, d) {
                    break points;
                }
                d *= 0.5;
            };
            path.leg(&begin, &along(corner, e, -d), e);
            path.push(2.0 * d, Piece::Curve(points));
            begin = along(corner, f, d);
        }
        if let (Some((e, _)), Some(end)) = (legs.last(), points.last()) {
            path.leg(&begin, end, e);
        }
        path
    }

    fn is_curve_clear(&mut self, corner: &[f64], points: &[[f64; 6]], d: f64) -> bool {
        let at = |t: f64| -> Vec<f64> { points.iter().map(|p| bezier(p, t)[0]).collect() };
        let y: Vec<f32> = single(corner);
        let begin = self.known(&y).and_then(|q| self.chain.joints_of(&at(0.0), &q).ok());
        begin.is_some_and(|begin| self.follow(&begin, 2.0 * d, at).is_some())
    }
}

impl Space for Bodies<'_> {
    fn spent(&mut self) -> &mut u64 {
        &mut self.checker.batches
    }

    fn longest_step(&self) -> Option<f32> {
        Some(STEP as f32)
    }

    fn is_clear(&mut self, from: &[f32], to: &[f32]) -> bool {
        let (a, b) = (from, to);
        let at = |t: f64| -> Vec<f64> {
            let place = |(a, b): (&f32, &f32)| f64::from(*a) + (f64::from(*b) - f64::from(*a)) * t;
            a.iter().zip(b).map(place).collect()
        };
        // A shortcut begins between places that are known.
        let Some(q) = self.known(from).or_else(|| self.near(from)) else { return false };
        let length = f64::from(crate::search::distance(from, to));
        let Some(last) = self.follow(&q, length, at) else { return false };
        match self.known(to) {
            // Arms may come there in another posture.
            Some(known) => known.iter().zip(&last).all(|(a, b)| (a - b).abs() < SAME),
            None => {
                self.know(to, last);
                true
            }
        }
    }
}
