//! Arms that a body joins: from where the body is to the joints of the arms, and from its path to theirs.
//!
//! In: poses of the body, as coordinates `y = (p - p_0, log(R R_0^-1))` of where it is at the start. Out: the joints of all robots, by the inverse
//! kinematics `X_WE_i = X_WB X_BE_i` on the branch that is nearest. A path of the body becomes one of all joints: curves of degree 5 that pass these joints
//! with their first and second derivatives, as short as is needed to miss them by less than [`MISS`] between their ends.

use std::sync::Arc;

use mrroc::pose::Pose;
use mrroc_generators::cooperation::BodyFrame;
use mrroc_robots::Kinematics;
use nalgebra::{SVector, Translation3, UnitQuaternion, Vector3};

use crate::arm::Arm;
use crate::error::PlanError;
use crate::path::{Path, Piece, along, bezier};

/// How far a piece of the path misses the joints between its ends at most [rad or m].
const MISS: f64 = 2e-11;
/// How long such a piece is as a rule, up to half as much again, and where it may be halved no more [m or rad].
const PIECE: [f64; 2] = [0.04, 5e-4];
/// From where derivatives are taken, to either side [m or rad], at most; as a share of a piece of the body's path, and of one of the joints'.
const BESIDE: [f64; 3] = [5e-4, 5e-3, 0.02];

/// How far a holder's flange may be from where the clearance has it \[m\].
const APART: f64 = 1e-6;

/// What a clearance calls the tools that robots carry.
const TOOL: &str = "tool";

/// The difference of places from which a twist, and what joints do on it, is taken [m or rad].
const ALONG: f64 = 1e-3;
/// The longest step on it, from which joints are found on their branch [m or rad].
const STEP: f64 = 0.02;

type Forward = Arc<dyn Fn(&[f64]) -> Pose + Send + Sync>;
type Inverse = Arc<dyn Fn(&Pose, &[f64]) -> Option<Vec<f64>> + Send + Sync>;

/// Arms that hold one body rigidly, each with its flange: see [`Planner::carry`](crate::Planner::carry).
#[derive(Clone, Default)]
pub struct Holders(Vec<Holder>);

#[derive(Clone)]
struct Holder {
    robot: String,
    joints: usize,
    forward: Forward,
    inverse: Inverse,
}

impl Holders {
    /// Nobody yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// And the robot of this name, whose kinematics, with its base, is that of `robot`: its flange is where the clearance has it.
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
        self.0.push(Holder { robot: name.to_owned(), joints: N, forward, inverse });
        self
    }
}

/// The pose at coordinates that count from a pose.
pub(crate) fn pose(from: &Pose, y: &[f64]) -> Pose {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(y[3], y[4], y[5]));
    let place = from.translation.vector + Vector3::new(y[0], y[1], y[2]);
    Pose::from_parts(Translation3::from(place), turn * from.rotation)
}

/// Arms that a body joins.
pub(crate) struct Chain<'a> {
    holders: &'a [Holder],
    /// The first joint of each holder, and how many it has.
    joints: Vec<[usize; 2]>,
    /// `X_BE` of each holder.
    grasps: Vec<Pose>,
    /// Where the body is at the start.
    pub(crate) begins: Pose,
}

impl<'a> Chain<'a> {
    pub(crate) fn closed(
        arms: &[Arm],
        Holders(holders): &'a Holders,
        body: BodyFrame,
        start: &[f64],
    ) -> Result<Self, PlanError> {
        if holders.is_empty() {
            return Err(PlanError::NoHolder);
        }
        let mut joints = Vec::new();
        let mut tools = Vec::new();
        let mut is_grasped = false;
        for Holder { robot, joints: actual, forward, .. } in holders {
            let arm = arms.iter().find(|arm| arm.name().as_str() == robot);
            let arm = arm.ok_or_else(|| PlanError::no_robot(robot, arms.iter().map(Arm::name)))?;
            if *actual != arm.joints {
                return Err(PlanError::Joints { expected: arm.joints, actual: *actual });
            }
            let tool = forward(&start[arm.first..arm.first + arm.joints]);
            let known = arm.part.shape.flange(&arm.own(start));
            let apart = (tool.translation.vector - known.translation.vector).norm();
            // What is no number is not there.
            if apart.is_nan() || apart > APART {
                return Err(PlanError::OtherFlange { robot: robot.clone(), apart, limit: APART });
            }
            is_grasped |= has_grasped(arm);
            joints.push([arm.first, arm.joints]);
            tools.push(tool);
        }
        if !is_grasped {
            let robots = holders.iter().map(|holder| holder.robot.as_str()).collect::<Vec<_>>().join(", ");
            return Err(PlanError::NotGrasped { robots });
        }
        let begins = body.pose(&tools);
        let grasps = tools.iter().map(|tool| begins.inv_mul(tool)).collect();
        Ok(Chain { holders, joints, grasps, begins })
    }

    #[allow(non_snake_case)]
    pub(crate) fn coordinates(&self, X_WB: &Pose) -> [f64; 6] {
        let by = X_WB.translation.vector - self.begins.translation.vector;
        let turn = (X_WB.rotation * self.begins.rotation.inverse()).scaled_axis();
        [by.x, by.y, by.z, turn.x, turn.y, turn.z]
    }

    /// The joints of all robots with the body there, on the branch that is nearest; or the robot that has none.
    pub(crate) fn joints_of(&self, y: &[f64], near: &[f64]) -> Result<Vec<f64>, String> {
        let body = pose(&self.begins, y);
        let mut q = near.to_vec();
        for ((holder, [first, count]), grasp) in self.holders.iter().zip(&self.joints).zip(&self.grasps) {
            let own = *first..first + count;
            let found = (holder.inverse)(&(body * grasp), &near[own.clone()]);
            q[own].copy_from_slice(&found.ok_or_else(|| holder.robot.clone())?);
        }
        Ok(q)
    }

    /// How the joints accelerate by the parameter of the body's path at a distance on the twist that the body has at `u`; the joints there are `q`.
    pub(crate) fn bends(&self, body: &Path, u: f64, q: &[f64], far: f64) -> Option<Vec<f64>> {
        let u = u.clamp(ALONG, (body.length() - ALONG).max(ALONG));
        let [before, here, behind] = [u - ALONG, u, u + ALONG].map(|u| pose(&self.begins, &body.at(u).q));
        let turn = (behind.rotation * before.rotation.inverse()).scaled_axis() / (2.0 * ALONG);
        let by = (behind.translation.vector - before.translation.vector) / (2.0 * ALONG);
        let velocity = by - turn.cross(&here.translation.vector);
        // The joints at a distance, which they have come to by what is known nearer.
        let mut q = q.to_vec();
        let mut at = |s: f64| -> Option<Vec<f64>> {
            q = self.joints_of(&self.coordinates(&(twisted(velocity, turn, s) * here)), &q).ok()?;
            Some(q.clone())
        };
        let steps = (far / STEP).ceil();
        for k in 1..=steps as u32 {
            at(far * f64::from(k) / steps)?;
        }
        let [a, b, c] = [at(far - ALONG)?, at(far)?, at(far + ALONG)?];
        Some((0..b.len()).map(|j| (a[j] - 2.0 * b[j] + c[j]) / (ALONG * ALONG)).collect())
    }

    /// The path of all joints for that of the body, by the same parameter; or how much of it there is, in percent.
    pub(crate) fn path(&self, body: &Path, start: &[f64], offset: &[f64]) -> Result<Path, f64> {
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

/// Whether an arm carries a body, and not only a tool.
fn has_grasped(arm: &Arm) -> bool {
    let own = arm.part.links.len() - arm.part.carried.len();
    arm.part.links[own..].iter().any(|link| &*link.name != TOOL)
}

/// The displacement after a distance `s` on a twist: `exp(s [turn, velocity])`, both in the world at its origin.
fn twisted(velocity: Vector3<f64>, turn: Vector3<f64>, s: f64) -> Pose {
    let (angle, w) = (turn.norm(), turn.cross_matrix());
    let x = angle * s;
    let [first, second] = if x.abs() < 1e-4 {
        [0.5 * s * s, s * s * s / 6.0]
    } else {
        [(1.0 - x.cos()) / (angle * angle), (x - x.sin()) / (angle * angle * angle)]
    };
    let by = velocity * s + w * velocity * first + w * w * velocity * second;
    Pose::from_parts(Translation3::from(by), UnitQuaternion::from_scaled_axis(turn * s))
}
