//! Positions on the way, which a path passes exactly and without resting there.
//!
//! In: the points of each stage of a path. Out: [`Point`]s of one path. At a position on the way the path turns from a direction `e`
//! to another one `f`. Rounding a corner `P` there by `d` leads past it: in its middle the curve is at `P + 3/16 d (f - e)`. So the
//! corner is put beyond the position `C`, to `P = C - 3/16 d (f - e)`, where its curve passes `C`. `e` and `f` depend on all such
//! corners, so these are found by iteration. The new legs and curves are proven clear, or `d` is made smaller.

use crate::check::Checker;
use crate::edge::{Edges, single};
use crate::path::{Point, Rounding, curve, direction, is_clear};

/// The largest distance from a corner at which it is rounded [rad or m].
const LARGEST: f64 = 0.6;
/// The least one. With less room than that the corner stays at the position, and is passed at hardly any speed.
const LEAST: f64 = 2e-3;
/// The length of `e + f` below which the path turns back at the position, where a curve through it stands nearly still in its middle.
const BACK: f64 = 0.2;
/// The share of the shorter leg at the position that rounding takes up: of a leg between two corners beyond their positions, which
/// shorten it by at most `2 * 3/8 d`, each has half.
const SHARE: f64 = 0.35;
/// Where the middle of the curve is: the sum of its six points by 1, 5, 10, 10, 5 and 1 of 32.
const MIDDLE: f64 = 3.0 / 16.0;
/// Each round of the iteration makes the error three times smaller at least.
const ROUNDS: usize = 50;
/// Points that are nearer than this are one [rad or m].
const SAME: f64 = 1e-9;

/// The points of one path along `parts`, each of which begins where the one before it ends; with curves through the positions on the
/// way, or with corners that stay at them.
pub(crate) fn passed(
    checker: &mut Checker,
    edges: &mut Edges,
    parts: &[Vec<Vec<f64>>],
    curved: bool,
) -> Vec<Point> {
    // All points, and whether the path must pass them.
    let mut all: Vec<(&[f64], bool)> = Vec::new();
    for part in parts {
        for (i, q) in part.iter().enumerate() {
            let is_end = i + 1 == part.len();
            match all.last_mut() {
                Some((last, passes)) if last.iter().zip(q).all(|(a, b)| (b - a).abs() < SAME) => {
                    *passes |= is_end;
                }
                _ => all.push((q, is_end)),
            }
        }
    }
    let free = |(at, _): &(&[f64], bool)| Point { at: at.to_vec(), rounding: Rounding::Free };
    let mut points: Vec<Point> = all.iter().map(free).collect();
    let last = all.len().saturating_sub(1);
    for i in (1..last.max(1)).filter(|i| all[*i].1) {
        let [(e, before), (f, behind)] = legs(&points, i);
        let straight = e.iter().zip(&f).map(|(e, f)| (e + f) * (e + f)).sum::<f64>().sqrt();
        let d = LARGEST.min(SHARE * before).min(SHARE * behind);
        let has_room = curved && straight >= BACK && d >= LEAST;
        points[i].rounding = if has_room { Rounding::By(d) } else { Rounding::Least };
    }
    loop {
        for _ in 0..ROUNDS {
            for i in 1..last.max(1) {
                if let Rounding::By(d) = points[i].rounding {
                    let [(e, _), (f, _)] = legs(&points, i);
                    let beyond = e.iter().zip(&f).map(|(e, f)| MIDDLE * d * (f - e));
                    points[i].at = all[i].0.iter().zip(beyond).map(|(q, beyond)| q - beyond).collect();
                }
            }
        }
        let failing: Vec<(usize, f64)> = (1..last.max(1))
            .filter_map(|i| match points[i].rounding {
                Rounding::By(d) if !is_clear_at(checker, edges, &points, i, d) => Some((i, d)),
                Rounding::By(_) | Rounding::Free | Rounding::Least => None,
            })
            .collect();
        if failing.is_empty() {
            return points;
        }
        for (i, d) in failing {
            let rounding = if 0.5 * d < LEAST { Rounding::Least } else { Rounding::By(0.5 * d) };
            points[i] = Point { at: all[i].0.to_vec(), rounding };
        }
    }
}

/// Directions and lengths of the legs before and behind a point.
fn legs(points: &[Point], i: usize) -> [(Vec<f64>, f64); 2] {
    [i, i + 1].map(|i| direction(&points[i - 1].at, &points[i].at))
}

/// Whether a corner may be there: its legs and its curve are clear and within the limits of the joints.
fn is_clear_at(checker: &mut Checker, edges: &mut Edges, points: &[Point], i: usize, d: f64) -> bool {
    let [(e, before), (f, behind)] = legs(points, i);
    let at = &points[i].at;
    2.0 * d <= before.min(behind)
        && checker.is_within(at)
        && edges.is_clear(checker, &single(&points[i - 1].at), &single(at))
        && edges.is_clear(checker, &single(at), &single(&points[i + 1].at))
        && is_clear(checker, edges, &curve(at, &e, &f, d))
}
