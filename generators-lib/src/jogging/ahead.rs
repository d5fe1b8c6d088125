//! How much of a path can be gone, and how fast.
//!
//! In: a path, and how much of it may be needed to come to rest. Out: how much of it is clear, how fast its parts can be gone, and
//! what bounds it. It is looked at in small pieces, each of them once.

use mrroc::operator::jog::JogStop;
use mrroc::prelude::*;
use mrroc::robot::JointVector;

use super::{JogLimits, JogPath};

/// Pieces that are looked at ahead.
const PIECES: usize = 32;

/// How much slower than it may be at most a motion is where a path is still gone, and no longer where it is given up.
const SLOWEST: f64 = 0.04;

/// How often the piece in which a path ends is halved.
const HALVINGS: usize = 8;

/// How often it is looked ahead in a step. Each look takes two solutions of the inverse kinematics, which are iterations for many arms:
/// a step's work must not grow with how far a robot needs to see. Four pieces a step are seen far faster than they are gone.
const LOOKS: usize = 4;

/// How much of a path is clear.
#[derive(Clone, Debug)]
pub struct Ahead<R: Robot> {
    /// Length of a piece.
    piece: f64,
    /// How far it is clear, and the joints there [rad or m].
    clear: f64,
    joints: R::Joints,
    /// What bounds it there.
    bound: Option<JogStop>,
    /// Where it was found to be bounded, by what, and how often the piece before is still to be halved.
    ending: Option<(f64, JogStop, usize)>,
    /// The largest speeds in the newest pieces, the newest one at `newest`.
    speeds: [f64; PIECES],
    newest: usize,
    /// Acceleration and jerk of the path \[1/s²\], \[1/s³\].
    acceleration: f64,
    jerk: f64,
    /// The largest speed that limits of the tool and the joints allow at the beginning, at 100 %.
    full: f64,
}

/// How joints and tool change with the length of a path.
struct Change<J> {
    /// Joints [rad or m] for each unit of length, and their curvature.
    joints: J,
    bend: J,
    /// The tool \[m\], \[rad\].
    along: f64,
    about: f64,
}

impl<R: Robot> Ahead<R> {
    /// Of a path that begins at the joints `q` [rad or m]; `None` where the arm cannot even begin it.
    #[must_use]
    pub fn of(path: &JogPath<R>, model: &R, q: R::Joints, limits: &JogLimits) -> Option<Self> {
        // Short against what bends paths, long against the rounding of inverse kinematics.
        let first = 1e-3_f64.min(path.length());
        let change = change(path, model, first, &q, &path.joints(model, first, &q)?, first)?;
        let of_arm = model.limits();
        let least =
            |shares: &dyn Fn(usize) -> f64| (0..R::Joints::LEN).map(shares).fold(f64::INFINITY, f64::min);
        let share = |limit: f64, joint: usize| limits.joints * limit / change.joints[joint].abs();
        let acceleration = (limits.acceleration / change.along)
            .min(limits.turning_acceleration / change.about)
            .min(least(&|i| share(of_arm.acceleration[i], i)));
        // It comes to its acceleration within a tenth of a second, or as fast as the joints may.
        let jerk = (10.0 * acceleration)
            .min(of_arm.jerk.map_or(f64::INFINITY, |jerk| least(&|i| share(jerk[i], i))));
        let full = speed::<R>(&change, model, limits);
        if !(acceleration.is_finite() && acceleration > 0.0 && full.is_finite() && full > 0.0) {
            return None;
        }
        // What it takes to come to rest from full speed, with a piece to spare.
        let rest = full * full / (2.0 * acceleration) + full * acceleration / (2.0 * jerk);
        let piece = 1.25 * rest / (PIECES - 2) as f64;
        Some(Ahead {
            piece,
            clear: 0.0,
            joints: q,
            bound: None,
            ending: None,
            speeds: [full; PIECES],
            newest: 0,
            acceleration,
            jerk,
            full,
        })
    }

    /// Acceleration \[1/s²\] and jerk \[1/s³\] of the path.
    #[must_use]
    pub const fn limits(&self) -> (f64, f64) {
        (self.acceleration, self.jerk)
    }

    /// How much of the path is clear.
    #[must_use]
    pub const fn clear(&self) -> f64 {
        self.clear
    }

    /// What bounds it there, if anything does.
    #[must_use]
    pub const fn bound(&self) -> Option<JogStop> {
        self.bound
    }

    /// The largest speed of all that is ahead, at 100 %.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.speeds.iter().fold(self.full, |least, speed| least.min(*speed))
    }

    /// Looks further, up to so far that it can come to rest behind `s` from full speed; a few times in each call.
    pub fn look(&mut self, path: &JogPath<R>, model: &R, s: f64, limits: &JogLimits) {
        let far = (s + self.piece * (PIECES - 1) as f64).min(path.length());
        for _ in 0..LOOKS {
            if self.bound.is_some() {
                return;
            }
            match self.ending {
                // It comes as near to the end of what is clear as halving finds it.
                Some((beyond, bound, halvings)) => {
                    let middle = 0.5 * (self.clear + beyond);
                    let beyond = match self.see(path, model, middle, limits) {
                        Ok((joints, _)) => {
                            (self.clear, self.joints) = (middle, joints);
                            beyond
                        }
                        Err(_) => middle,
                    };
                    let left = halvings - 1;
                    self.ending = (left > 0).then_some((beyond, bound, left));
                    self.bound = (left == 0).then_some(bound);
                }
                None if self.clear < far => {
                    let next = (self.clear + self.piece).min(path.length());
                    match self.see(path, model, next, limits) {
                        Ok((joints, speed)) => {
                            self.newest = (self.newest + 1) % PIECES;
                            self.speeds[self.newest] = speed;
                            (self.clear, self.joints) = (next, joints);
                        }
                        Err(bound) => self.ending = Some((next, bound, HALVINGS)),
                    }
                }
                None => break,
            }
        }
        if self.clear >= path.length() {
            self.bound.get_or_insert(JogStop::There);
        }
    }

    /// The joints after `s` of the path, and how fast it can be gone there, at 100 %.
    ///
    /// # Errors
    /// What keeps the robot from it.
    fn see(
        &self,
        path: &JogPath<R>,
        model: &R,
        s: f64,
        limits: &JogLimits,
    ) -> Result<(R::Joints, f64), JogStop> {
        let joints = path.joints(model, s, &self.joints).ok_or(JogStop::Kinematics)?;
        let of_arm = model.limits();
        for i in 0..R::Joints::LEN {
            let beyond = |q: f64| {
                (of_arm.lower[i] + limits.margin - q).max(q - (of_arm.upper[i] - limits.margin)).max(0.0)
            };
            // One that is there already may go back.
            if beyond(joints[i]) > beyond(self.joints[i]) {
                return Err(JogStop::Joint(i as u8));
            }
        }
        let change =
            change(path, model, s, &self.joints, &joints, s - self.clear).ok_or(JogStop::Kinematics)?;
        let twice = |i: usize| 2.0 * limits.joints * of_arm.acceleration[i];
        let bears = (0..R::Joints::LEN)
            .all(|i| change.joints[i].abs() * self.acceleration <= twice(i).max(f64::MIN_POSITIVE));
        let speed = speed::<R>(&change, model, limits);
        if !(bears && speed >= SLOWEST * self.full) {
            return Err(JogStop::Kinematics);
        }
        // Limits that joints share are kept away from as those of single joints.
        let step = joints - self.joints;
        let longest = step.as_slice().iter().fold(f64::MIN_POSITIVE, |longest, q| q.abs().max(longest));
        let further = limits.margin / longest;
        let time = (1.0 + further) * (s - self.clear) / speed;
        let coupled = model.check_coupled(&self.joints, &(joints + step * further), time);
        coupled.map_err(|broken| JogStop::Joint(broken.joint as u8)).map(|()| (joints, speed))
    }
}

/// How joints and tool change at `s`, of which the joints are known there and `by` before it.
fn change<R: Robot>(
    path: &JogPath<R>,
    model: &R,
    s: f64,
    before: &R::Joints,
    here: &R::Joints,
    by: f64,
) -> Option<Change<R::Joints>> {
    let after = path.joints(model, s + by, here)?;
    let joints = (*here - *before) * (1.0 / by);
    let next = (after - *here) * (1.0 / by);
    let worse = R::Joints::from_joints(|i| if next[i].abs() > joints[i].abs() { next[i] } else { joints[i] });
    let (a, b) = (path.tool(model, before), path.tool(model, here));
    let along = (b.translation.vector - a.translation.vector).norm() / by;
    let about = a.rotation.angle_to(&b.rotation) / by;
    Some(Change { joints: worse, bend: (next - joints) * (1.0 / by), along, about })
}

/// How fast that can be gone at 100 %.
fn speed<R: Robot>(change: &Change<R::Joints>, model: &R, limits: &JogLimits) -> f64 {
    let of_arm = model.limits();
    let joint = |i: usize| {
        let straight = limits.joints * of_arm.velocity[i] / change.joints[i].abs();
        let bent = (limits.joints * of_arm.acceleration[i] / change.bend[i].abs()).sqrt();
        straight.min(bent)
    };
    let joints = (0..R::Joints::LEN).map(joint).fold(f64::INFINITY, f64::min);
    joints.min(limits.speed / change.along).min(limits.turn / change.about)
}
