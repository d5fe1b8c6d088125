//! A new plan while robots follow another one.
//!
//! In: the plan, an instant of its path time, new goals. Out: a plan that **is** the old one until that instant, and then leads to one of the goals. So it
//! may take the place of the old one at any time before: nothing changes then.
//!
//! ```text
//!   old path  ──────●────────────○───────X──────╮C─ ─ ─ ─▶ old goal
//!               hand-over   standstill          ╲
//!                                                ╲ new path ──▶ new goal
//! ```
//!
//! From the hand-over on the robots can come to rest before `X`. Up to there the path is the old one. The new path begins at `C` on the old one,
//! on one of its legs, and the corner there is rounded. Where that has no motion, or the path turns back, the robots come to rest at `C` and go on
//! from there; or as soon as they can. All of it is proven in the world that the planner knows now, as any plan is.

use std::sync::Arc;

use crate::arm::Arm;
use crate::error::PlanError;
use crate::onward::{Onward, begin, standstill};
use crate::path::{Path, Piece, Point, Rounding, direction};
use crate::plan::{Motion, Plan};
use crate::planner::{MORE, Planner, reduced};

/// How far behind the place where robots can rest a new path begins [rad or m]: what there is for its curve.
const ROOM: f64 = 0.3;
/// The least of it.
const LEAST: f64 = 0.02;
/// Points that are nearer than this are one [rad or m].
const SAME: f64 = 1e-9;
/// The cosine of the angle behind which robots rest before they turn.
const BACK: f64 = -0.8;

/// Where a new path leaves the old one.
struct Turn {
    /// The parameter of the old path.
    at: f64,
    /// From where on robots can rest on it.
    stands: f64,
    /// Where the leg begins whose corner it is, if there is room for a curve; otherwise robots rest there.
    from: Option<f64>,
}

impl Planner {
    /// A new plan for robots that follow `plan`: it is the same motion until the path time `at` \[s\], and then leads to the first of `goals` that
    /// is reached. Robots may be handed over to it at any time before ([`Following::hand_over`](crate::Following::hand_over)). Path times are those of `plan`;
    /// behind its end `at` is its end.
    ///
    /// The planner may know another world than the one of `plan`: what the robots pass from `at` on is proven anew.
    ///
    /// # Errors
    /// [`PlanError`]; the robots may then follow `plan` to its end.
    pub fn replan(&mut self, plan: &Plan, at: f64, goals: &[Vec<f64>]) -> Result<Plan, PlanError> {
        let robots: Vec<_> = self.checker.arms.iter().map(Arm::name).collect();
        if robots != plan.robots || self.limits.robots != plan.motion.limits.robots {
            let names = |all: &[mrroc::fault::Name]| {
                all.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
            };
            return Err(PlanError::OtherRobots { plan: names(&plan.robots), planner: names(&robots) });
        }
        let Motion { path, speed, carries, .. } = &*plan.motion;
        if *carries {
            return Err(PlanError::CarriesBody);
        }
        if at.is_nan() || at < speed.begins {
            return Err(PlanError::PathTime { at, begins: speed.begins });
        }
        // What is averaged is at rest before the mean is.
        let at = speed.behind_rest(at);
        let from = begin(speed, at);
        let path = &path.until(path.corner_from(from[0] - SAME));
        let stands = standstill(path, speed, &self.limits, from).max(from[0] + from[1] * self.reaction);
        let stands = stands.min(path.length());
        let mut first = None;
        let tries = [
            (at, curve_behind(path, from[0], stands), MORE[0]),
            (at, Turn { at: stands, stands, from: None }, MORE[1]),
        ];
        for (at, turn, more) in tries {
            match self.turned(plan, path, at, goals, &turn, more) {
                Err(
                    error @ (PlanError::StartNotClear(_)
                    | PlanError::StopsNotClear { .. }
                    | PlanError::Timing(_)
                    | PlanError::HandOver { .. }),
                ) => first = first.or(Some(error)),
                found => return found,
            }
        }
        Err(first.unwrap_or(PlanError::HandOver { at }))
    }

    /// The plan that turns off there; `path` is that of `plan` up to its next corner.
    fn turned(
        &mut self,
        plan: &Plan,
        path: &Path,
        at: f64,
        goals: &[Vec<f64>],
        turn: &Turn,
        more: f32,
    ) -> Result<Plan, PlanError> {
        let old = &*plan.motion;
        let corner: Vec<f64> = (0..self.limits.joints()).map(|joint| old.place(turn.at, joint)).collect();
        let parts = self.find_through(&corner, &[goals], more)?;
        let more = self.checker.more;
        let offset = self.offset(&corner);
        self.checker.offset.clone_from(&offset);
        let path = path.clone().moved(&reduced(&old.offset, &offset));
        // In another world the common part may not be clear.
        self.checker.more = 0.0;
        if !path.is_clear(&mut self.checker, &mut self.edges, [old.speed.at(at).s, turn.at]) {
            return Err(PlanError::HandOver { at });
        }
        let mut points: Vec<Point> = Vec::new();
        for q in parts.iter().flatten() {
            let at = reduced(q, &offset);
            if points.last().is_none_or(|last| last.at.iter().zip(&at).any(|(a, b)| (b - a).abs() > SAME)) {
                points.push(Point { at, rounding: Rounding::Free });
            }
        }
        let goal = parts.last().and_then(|part| part.last()).unwrap_or(&corner).clone();
        let mut error = PlanError::HandOver { at };
        for from in turn.from.map(Some).into_iter().chain([None]) {
            let mut points = points.clone();
            let (leaves, common, rests) = match from {
                Some(from) if turns(&path, from, &points) => {
                    points.insert(0, Point { at: path.at(from).q, rounding: Rounding::Free });
                    (from, turn.stands, false)
                }
                Some(_) => continue,
                None => (turn.at, turn.at, true),
            };
            let mut new = path.until(leaves);
            if points.len() < 2 && new.pieces.is_empty() {
                // The robots stand at the goal.
                continue;
            }
            if points.len() > 1 {
                self.checker.more = more;
                new.append(&Path::rounded(&mut self.checker, &mut self.edges, &points));
                self.checker.more = 0.0;
            }
            let onward = Onward {
                speed: &old.speed,
                at,
                path: &new,
                common,
                rests,
                limits: &self.limits,
                reaction: self.reaction,
            };
            match onward.timed(&mut self.checker, &old.grid) {
                Ok((speed, grid)) => {
                    let ends = [old.ends[0].clone(), goal];
                    let (path, limits, reaction) = (new, self.limits.clone(), self.reaction);
                    let (leaves, carries) = (at, false);
                    let motion =
                        Motion { path, speed, limits, offset, ends, grid, leaves, reaction, carries };
                    return Ok(Plan { robots: plan.robots.clone(), motion: Arc::new(motion) });
                }
                Err(why) => error = why,
            }
        }
        Err(error)
    }
}

/// Whether robots that come from a place of a leg turn into the new path by less than back.
fn turns(path: &Path, from: f64, points: &[Point]) -> bool {
    let [corner, next, ..] = points else { return false };
    let e = path.at(from).first;
    let (f, _) = direction(&corner.at, &next.at);
    e.iter().zip(&f).map(|(e, f)| e * f).sum::<f64>() > BACK
}

/// Where on a leg behind a place there is room for a curve; the end of the path where there is none.
fn curve_behind(path: &Path, begins: f64, stands: f64) -> Turn {
    let legs = path.knots().windows(2).zip(&path.pieces);
    for (ends, piece) in legs {
        let begin = stands.max(ends[0]);
        if matches!(piece, Piece::Leg { .. }) && ends[1] - begin > LEAST {
            let at = ends[1].min(begin + ROOM);
            // The curve takes up at most half of the leg before the corner.
            let from = ends[0].max(2.0 * begin - at).max(begins);
            return Turn { at, stands, from: Some(from) };
        }
    }
    Turn { at: path.length(), stands, from: None }
}
