//! The first path of any number of robots: what is simple is tried first.
//!
//! All straight; then by what is remembered of earlier queries ([`Roadmap`]); then, of several robots, one after the other ([`in_turns`]); then all joints at once ([`connect`]).

use super::sampling::Samples;
use super::turns::in_turns;
use super::{Joints, Points, Roadmap, connect, rooted, straight};
use crate::check::Checker;
use crate::edge::Edges;

/// How many of several goals robots try to reach one after the other.
const GOALS: usize = 4;

/// A path from `start` to one of the `goals`, all of them clear, by so many checks.
///
/// # Errors
/// As of [`connect`].
pub(crate) fn find(
    checker: &mut Checker,
    edges: &mut Edges,
    samples: &mut Samples,
    roadmap: &mut Roadmap,
    start: &[f32],
    goals: &[Vec<f32>],
    effort: u64,
) -> Result<Points, (Vec<f32>, f64)> {
    let end = checker.batches + effort;
    if let Some(path) = straight(&mut Joints { checker, edges }, start, goals) {
        return Ok(path);
    }
    if let Some(path) = roadmap.route(checker, edges, start, goals, effort) {
        return Ok(path);
    }
    if checker.arms.len() > 1 {
        let goals = &goals[..goals.len().min(GOALS)];
        let share = effort / (2 * goals.len() as u64);
        let path = goals.iter().find_map(|goal| in_turns(checker, edges, samples, start, goal, share));
        if let Some(path) = path {
            roadmap.keep_path(&path, checker.more);
            return Ok(path);
        }
    }
    let left = end.saturating_sub(checker.batches);
    let mut trees = rooted(start, goals);
    let found = connect(&mut Joints { checker, edges }, samples, &mut trees, goals, left);
    for tree in &trees {
        roadmap.keep_tree(tree, start.len(), checker.more);
    }
    if let Ok(path) = &found {
        roadmap.keep_path(path, checker.more);
    }
    found
}
