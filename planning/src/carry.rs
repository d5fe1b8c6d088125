//! Motions of a body that several arms hold rigidly, around obstacles.
//!
//! In: arms, their positions where they hold the body, and where it is to be. Out: a [`Carried`]: how the body moves, with the joints of all arms on the
//! way, on the branch of their inverse kinematics that they have at the start, and times within the limits of all joints.
//!
//! ```text
//! X_WB(u) -> X_WE_i = X_WB X_BE_i -> inverse kinematics of each arm -> curves of degree 5 through joints and their derivatives -> clear? limits? stops?
//! ```
//!
//! The search is in the coordinates of the body's pose ([`Bodies`]). The path of all joints that comes of it is one of curves ([`Chain`]), as any plan may have:
//! it is proven clear, timed and followed as that of a plan.

use std::sync::Arc;

use mrroc::pose::Pose;
use mrroc::prelude::Fault;
use mrroc_generators::cooperation::{BodyFrame, BodyPath};

use crate::arm::Arm;
use crate::body_space::Bodies;
use crate::chain::{Chain, Holders, pose};
use crate::edge::single;
use crate::error::PlanError;
use crate::path::{Path, Piece, along, distance};
use crate::plan::{Motion, Plan};
use crate::planner::{MORE, Planner, reduced};
use crate::search::{Samples, connect, rooted, shorten_any, straight};
use crate::speed::Speed;
use crate::timing::{grid, timed};
use crate::twist::Twist;

/// How far beyond start and goal the body is looked for \[m\] and [rad].
const BEYOND: [f64; 2] = [0.6, 1.0];
/// How far the body may be from where a motion begins [m or rad].
const SAME: f64 = 1e-6;
/// How far joints may be beyond a limit by rounding [rad or m].
const ROUNDING: f64 = 1e-9;
/// A shorter motion is none [m or rad].
const REST: f64 = 1e-9;

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
    /// The body and what its holders do on the way keep the margins, between samples too, and all joints their limits. In the clearance one
    /// holder has grasped the body ([`grasp`](mrroc_robots::clearance::Clearance::grasp)), and the pairs of the body with the links of the others that
    /// hold it are ignored. Each arm stays on the branch of its inverse kinematics that it has at the start; the body is looked for up to 0.6 m and 1 rad beyond
    /// start and goal. There is no motion through singular postures.
    ///
    /// Let a `RigidCarry` move the arms, `along` the same `body` and [`Carried::path`]. It tells all arms poses of the same body, so their relative pose
    /// is kept to rounding.
    ///
    /// # Stops
    ///
    /// Suspensions and other stops on the path keep the margins, and the arms together. Fault stops keep the margins where all arms brake together on the
    /// common twist, as those of a `RigidCarry` do (decision 7), and where each arm brakes in its own joints, with the body in the grasp of that holder:
    /// then the arms pull at the body.
    ///
    /// How far the joints are off straight lines on the twist is **taken from samples, and a quarter more: that is no proof**. Of
    /// robots with limits of jerk only the other stops are looked at. [`Planner::beside`] a plan of these arms does not know the twist.
    ///
    /// While demands are missing, a `RigidCarry` goes on with the last **change** of its twist before it brakes. The planner takes the twist as it is at the
    /// fault: what its change adds in these steps is not looked at.
    ///
    /// [`Planner::replan`] refuses the plan: another motion of the joints would pull at the body.
    ///
    /// # Errors
    /// [`PlanError`]; [`PlanError::NoHolder`], [`PlanError::OtherFlange`], [`PlanError::NotGrasped`], [`PlanError::OffBranch`], [`PlanError::Singular`] and
    /// [`PlanError::CarryNotClear`] are those of held bodies alone.
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
        // Where start or goal are no farther than their margin from something, the path is not either.
        for more in [more, MORE[0], 0.0] {
            self.checker.more = more;
            if self.checker.is_clear(start) && self.checker.is_clear(&last) {
                break;
            }
        }
        let mut space = Bodies::new(&mut self.checker, &mut self.edges, &chain, &offset);
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
        self.keeps_limits(&path)?;
        for ends in path.knots().windows(2) {
            if !path.is_clear(&mut self.checker, &mut self.edges, [ends[0], ends[1]]) {
                return Err(PlanError::CarryNotClear { at: 100.0 * ends[0] / path.length() });
            }
        }
        let twist = self.twist(&chain, &body, &path);
        let timed = timed(&mut self.checker, &path, &self.limits, self.reaction, Some(&twist))?;
        let last = along(&path.at(path.length()).q, &offset, 1.0);
        Ok(self.carrying(path, timed, [start, &last], body, [&chain.begins, X_WG]))
    }

    /// Refuses a path on which a joint may be beyond its limits: a curve lies between the least and the largest of its control points.
    fn keeps_limits(&self, path: &Path) -> Result<(), PlanError> {
        let limits = &self.limits;
        let mut beyond = None;
        for (piece, ends) in path.pieces.iter().zip(path.knots().windows(2)) {
            let mut look = |j: usize, point: f64| {
                let at = point + self.checker.offset[j];
                if at < limits.lower[j] - ROUNDING || at > limits.upper[j] + ROUNDING {
                    beyond = beyond.or(Some((j, at)));
                }
            };
            for j in 0..limits.joints() {
                match piece {
                    Piece::Curve(points) => points[j].into_iter().for_each(|point| look(j, point)),
                    Piece::Leg { from, along } => {
                        [0.0, ends[1] - ends[0]].into_iter().for_each(|s| look(j, from[j] + along[j] * s));
                    }
                }
            }
        }
        let Some((j, position)) = beyond else { return Ok(()) };
        let (lower, upper) = (limits.lower[j], limits.upper[j]);
        let arm = self.checker.arms.iter().rfind(|arm| arm.first <= j);
        let (robot, joint) =
            arm.map_or((String::new(), j + 1), |arm| (arm.name().to_string(), j - arm.first + 1));
        Err(PlanError::Limit { place: "path", robot, joint, position, lower, upper })
    }

    /// The twists of the body from all cells of the path's grid, from both ends of each and its middle.
    fn twist(&self, chain: &Chain<'_>, body: &Path, path: &Path) -> Twist {
        let mut twist = Twist::new(&self.limits);
        for ends in grid(path).windows(2) {
            let mut fastest = f64::INFINITY;
            path.rates(ends[0], ends[1], |j, [lower, upper]| {
                fastest = fastest.min(self.limits.velocity[j] / lower.abs().max(upper.abs()));
            });
            let farthest = fastest * (self.reaction + 0.5 * twist.longest);
            let places = [ends[0], 0.5 * (ends[0] + ends[1]), ends[1]]
                .map(|u| (u, along(&path.at(u).q, &self.checker.offset, 1.0)));
            twist.add(farthest, |far| places.iter().map(|(u, q)| chain.bends(body, *u, q, far)).collect());
        }
        twist
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
            carries: true,
        };
        let robots = self.checker.arms.iter().map(Arm::name).collect();
        let body = Body { path: body, begins: *begins, ends: *ends_at };
        Carried { plan: Plan { robots, motion: Arc::new(motion) }, body: Arc::new(body) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::usage::cells::{around_a_box, stopping};

    #[test]
    fn a_piece_that_goes_beyond_a_limit_between_its_ends_is_refused() {
        let planner =
            Planner::new(around_a_box().build(stopping()).expect("a clearance")).expect("a planner");
        let upper = planner.limits.upper[2];
        let path = |middle: f64| {
            let mut curve = vec![[0.0; 6]; 6];
            curve[2] = [-0.1, -0.1, middle, middle, -0.1, -0.1].map(|off| upper + off);
            Path { knots: vec![0.0, 0.04], pieces: vec![Piece::Curve(curve)] }
        };
        assert_eq!(planner.keeps_limits(&path(0.0)), Ok(()));
        // In its middle, where both points have a weight of 10 of 32.
        let bulging = path(0.2);
        assert!(bulging.at(0.02).q[2] > upper && bulging.at(0.04).q[2] < upper);
        let error = planner.keeps_limits(&bulging).expect_err("refused");
        assert!(matches!(error, PlanError::Limit { place: "path", joint: 3, .. }), "{error}");
    }
}
