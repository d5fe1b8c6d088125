//! The path through the points of a trajectory, from where the robots are.

use mrroc::cell::PATH_SHARE;
use nalgebra::Vector1;

use super::error::{Quantity, TrajectoryError};
use super::piece::Piece;
use super::{JERK_SHARE, JointBounds, JointTrajectory, SHARE, TrajectoryPoint};
use crate::curve::{CubicSpline, CurveError, SplineEnds};

/// How long joints take that are not quite at the first point to come to the trajectory, at most \[s\].
const SETTLES: f64 = 0.5;

/// What a check forgives for rounding, as a share of a limit.
const ROUNDING: f64 = 1e-9;

/// Where a joint is to be, and how it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointState {
    /// [rad or m].
    pub position: f64,
    /// [rad/s or m/s].
    pub velocity: f64,
    /// [rad/s² or m/s²].
    pub acceleration: f64,
}

impl JointState {
    /// At rest at a position [rad or m].
    #[must_use]
    pub const fn resting(position: f64) -> JointState {
        JointState { position, velocity: 0.0, acceleration: 0.0 }
    }

    const fn values(self) -> [f64; 3] {
        [self.position, self.velocity, self.acceleration]
    }
}

/// A path in time through the points of a [`JointTrajectory`], from where the robots are to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedPath {
    limits: Vec<JointBounds>,
    /// When each segment ends \[s\].
    ends: Vec<f64>,
    /// The joints' pieces of each segment, segment by segment.
    pieces: Vec<Piece>,
    /// The point of the trajectory at the end of the first segment, counted from 1.
    first: usize,
}

impl TimedPath {
    /// The path of a trajectory for joints in these states. Where the trajectory has begun, by a first point at time 0 or by the time that has
    /// [passed](JointTrajectory::passed), they must be within [`starting_within`](JointTrajectory::starting_within) of it, and come to it in half a
    /// second. To a later first point they go in the time that it says.
    ///
    /// # Errors
    /// [`TrajectoryError::Joints`], [`TrajectoryError::Past`], [`TrajectoryError::Start`], [`TrajectoryError::Spline`]; [`TrajectoryError::Limit`] for the first limit that the path
    /// would exceed: it may use [`SHARE`] of an acceleration and [`JERK_SHARE`] of a jerk, so that the robots can be brought to rest on it.
    pub fn from(trajectory: &JointTrajectory, states: &[JointState]) -> Result<TimedPath, TrajectoryError> {
        let (expected, actual) = (trajectory.limits.len(), states.len());
        if expected != actual {
            return Err(TrajectoryError::Joints { expected, actual });
        }
        let (knots, first) = Knots::of(trajectory, states)?;
        let path = knots.path(trajectory.limits.clone(), first);
        path.check(states)?;
        Ok(path)
    }

    /// How long it takes \[s\].
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.ends.last().copied().unwrap_or(0.0)
    }

    /// The limits of its joints.
    #[must_use]
    pub fn limits(&self) -> &[JointBounds] {
        &self.limits
    }

    /// Position, velocity and acceleration of a joint, from 0, at a path time \[s\]; before and after the path it stands.
    #[must_use]
    pub fn at(&self, time: f64, joint: usize) -> [f64; 3] {
        let time = time.max(0.0);
        let last = self.ends.len() - 1;
        let segment = self.ends.partition_point(|&end| end < time).min(last);
        let begins = self.begins(segment);
        let piece = &self.pieces[segment * self.limits.len() + joint];
        if time >= self.ends[last] {
            let [position, ..] = piece.at(self.ends[last] - begins);
            return [position, 0.0, 0.0];
        }
        piece.at(time - begins)
    }

    /// When a segment begins \[s\].
    fn begins(&self, segment: usize) -> f64 {
        segment.checked_sub(1).map_or(0.0, |before| self.ends[before])
    }

    /// Segments that are not over at a path time \[s\]: how long each takes, and its pieces.
    pub(super) fn rest(&self, time: f64) -> impl Iterator<Item = (f64, &[Piece])> {
        let first = self.ends.partition_point(|&end| end <= time);
        let pieces = self.pieces.chunks(self.limits.len()).enumerate().skip(first);
        pieces.map(|(segment, pieces)| (self.ends[segment] - self.begins(segment), pieces))
    }

    /// Whether all limits are kept, also by the step of the acceleration with which the path begins.
    fn check(&self, states: &[JointState]) -> Result<(), TrajectoryError> {
        let joints = self.limits.len();
        let mut before: Vec<f64> = states.iter().map(|state| state.acceleration).collect();
        for (segment, pieces) in self.pieces.chunks(joints).enumerate() {
            let time = self.ends[segment] - self.begins(segment);
            for (joint, (piece, limits)) in pieces.iter().zip(&self.limits).enumerate() {
                let exceeds = |quantity, value, limit| {
                    let (joint, point) = (joint + 1, self.first + segment);
                    Err(TrajectoryError::Limit { quantity, joint, point, value, limit })
                };
                let (lower, upper) = (limits.lower, limits.upper);
                let room = ROUNDING * (1.0 + upper - lower);
                if let Some(value) = piece.beyond(time, lower - room, upper + room) {
                    return exceeds(Quantity::Position, value, if value < lower { lower } else { upper });
                }
                // A path that replaces one which is being halted begins with an acceleration of the halt.
                let begins_with = if segment == 0 { states[joint].acceleration.abs() } else { 0.0 };
                let acceleration =
                    begins_with.clamp(SHARE * limits.acceleration, PATH_SHARE * limits.acceleration);
                let mut derivative = *piece;
                for (quantity, limit) in [
                    (Quantity::Velocity, limits.velocity),
                    (Quantity::Acceleration, acceleration),
                    (Quantity::Jerk, JERK_SHARE * limits.jerk),
                ] {
                    derivative = derivative.derivative();
                    let most = limit * (1.0 + ROUNDING);
                    if let Some(value) = derivative.beyond(time, -most, most) {
                        return exceeds(quantity, value, limit.copysign(value));
                    }
                }
                let [.., begins] = piece.at(0.0);
                let [.., ends] = piece.at(time);
                if limits.jerk.is_finite() {
                    let is_last = segment + 1 == self.ends.len();
                    let steps = [begins - before[joint], if is_last { ends } else { 0.0 }];
                    let room = 1e-6 * limits.acceleration;
                    if let Some(step) = steps.into_iter().find(|step| step.abs() > room) {
                        return exceeds(Quantity::StepOfAcceleration, step, 0.0);
                    }
                }
                before[joint] = ends;
            }
        }
        Ok(())
    }
}

/// What lies between two knots.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Degree {
    Three,
    Five,
}

impl Degree {
    fn piece(self, from: [f64; 3], to: [f64; 3], time: f64) -> Piece {
        match self {
            Degree::Three => Piece::cubic([from[0], from[1]], [to[0], to[1]], time),
            Degree::Five => Piece::quintic(from, to, time),
        }
    }
}

/// Where the path goes, one state per joint at each time.
struct Knots {
    times: Vec<f64>,
    states: Vec<Vec<[f64; 3]>>,
    degree: Degree,
}

impl Knots {
    /// Those of a trajectory that robots begin in these states; and which point the second of them is.
    fn of(trajectory: &JointTrajectory, states: &[JointState]) -> Result<(Knots, usize), TrajectoryError> {
        let (points, passed) = (&trajectory.points, trajectory.passed);
        let next = points.partition_point(|point| point.time <= passed);
        if next == points.len() {
            return match points.as_slice() {
                // A trajectory of one point at time 0 says where the robots are.
                [only] if passed == 0.0 => Self::standing(trajectory, only, states),
                _ => Err(TrajectoryError::Past { duration: trajectory.duration(), passed }),
            };
        }
        let bare = points[0].velocities.is_empty();
        let degree = if !bare && points[0].accelerations.is_empty() { Degree::Three } else { Degree::Five };
        let of_points: Vec<f64> = points.iter().map(|point| point.time).collect();
        let mut times = vec![0.0];
        times.extend(of_points[next..].iter().map(|time| time - passed));
        let settles = SETTLES.min(times.last().copied().unwrap_or(SETTLES));
        let mut knots = Vec::with_capacity(states.len());
        for (joint, (state, limits)) in states.iter().zip(&trajectory.limits).enumerate() {
            let told = |point: &TrajectoryPoint| {
                let value = |values: &[f64]| values.get(joint).copied().unwrap_or(0.0);
                [point.positions[joint], value(&point.velocities), value(&point.accelerations)]
            };
            let mut told: Vec<_> = points.iter().map(told).collect();
            let Some(before) = next.checked_sub(1) else {
                // It begins later: from where the robot is to the first point.
                told.insert(0, state.values());
                if bare {
                    spline(&times, &mut told)?;
                }
                knots.push(told);
                continue;
            };
            // It has begun: the robot must be about where it is now, and comes to it.
            if bare {
                spline(&of_points, &mut told)?;
            }
            let segment = degree.piece(told[before], told[next], of_points[next] - of_points[before]);
            let start = segment.at(passed - of_points[before]);
            let off = state.position - start[0];
            if off.is_nan() || off.abs() > trajectory.tolerance {
                let (joint, position, start) = (joint + 1, state.position, start[0]);
                return Err(TrajectoryError::Start { joint, position, start });
            }
            // A robot whose jerk is not limited may begin with any acceleration.
            let acceleration = if limits.jerk.is_finite() { state.acceleration - start[2] } else { 0.0 };
            let off = [off, state.velocity - start[1], acceleration];
            // What the joint is off by goes to 0 on a path of its own.
            let settle = Piece::quintic(off, [0.0; 3], settles);
            let mut of_joint = vec![start];
            of_joint.extend_from_slice(&told[next..]);
            for (time, knot) in times.iter().zip(&mut of_joint).filter(|(time, _)| **time < settles) {
                let off = settle.at(*time);
                *knot = [knot[0] + off[0], knot[1] + off[1], knot[2] + off[2]];
            }
            knots.push(of_joint);
        }
        Ok((Knots { times, states: knots, degree }, next + 1))
    }

    /// Of a trajectory that says no more than where the robots are already.
    fn standing(
        trajectory: &JointTrajectory,
        only: &TrajectoryPoint,
        states: &[JointState],
    ) -> Result<(Knots, usize), TrajectoryError> {
        let later = TrajectoryPoint { time: SETTLES, ..only.clone() };
        let points = vec![only.clone(), later];
        Self::of(&JointTrajectory { points, ..trajectory.clone() }, states)
    }

    fn path(self, limits: Vec<JointBounds>, first: usize) -> TimedPath {
        let segments = self.times.len() - 1;
        let mut pieces = Vec::with_capacity(segments * limits.len());
        for segment in 0..segments {
            let time = self.times[segment + 1] - self.times[segment];
            for states in &self.states {
                let (from, to) = (states[segment], states[segment + 1]);
                pieces.push(self.degree.piece(from, to, time));
            }
        }
        TimedPath { limits, ends: self.times[1..].to_vec(), pieces, first }
    }
}

/// Velocities and accelerations at the knots between the first and the last one: those of the cubic spline through all of them that begins with the
/// velocity of the first and ends at rest.
fn spline(times: &[f64], knots: &mut [[f64; 3]]) -> Result<(), CurveError> {
    let points = knots.iter().map(|knot| Vector1::new(knot[0])).collect();
    let ends = SplineEnds::Clamped(Vector1::new(knots[0][1]), Vector1::zeros());
    let spline = CubicSpline::new(times.to_vec(), points, ends)?;
    let last = knots.len() - 1;
    for (knot, time) in knots.iter_mut().zip(times).take(last).skip(1) {
        let at = spline.at(*time);
        (knot[1], knot[2]) = (at.first.x, at.second.x);
    }
    (knots[last][1], knots[last][2]) = (0.0, 0.0);
    Ok(())
}
