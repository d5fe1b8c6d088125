//! RRT-Connect: a tree from the start and one from the goals grow towards each other.

use super::sampling::Samples;
use super::tree::Tree;
use super::{Points, Space, distance};

/// The longest step of a tree: the root of the sum of squares over all joints [rad or m].
const RANGE: f32 = 1.4;

/// The straight motion to the first of the `goals` to which it is clear.
pub(crate) fn straight(space: &mut impl Space, start: &[f32], goals: &[Vec<f32>]) -> Option<Points> {
    let goal = goals.iter().find(|goal| space.is_clear(start, goal))?;
    Some(vec![start.to_vec(), goal.clone()])
}

/// A tree from the start, and one from the goals, that are to grow.
pub(crate) fn rooted(start: &[f32], goals: &[Vec<f32>]) -> [Tree; 2] {
    let mut trees = [Tree::new(start.len()), Tree::new(start.len())];
    trees[0].add(start, None);
    for goal in goals {
        trees[1].add(goal, None);
    }
    trees
}

/// A path between two [`rooted`] trees: from their start to one of the `goals`, all of them clear, of which none is straight ahead.
///
/// # Errors
/// `effort` checks have found none: the nearest position to a goal that was reached from the start, and its distance.
pub(crate) fn connect(
    space: &mut impl Space,
    samples: &mut Samples,
    trees: &mut [Tree; 2],
    goals: &[Vec<f32>],
    effort: u64,
) -> Result<Points, (Vec<f32>, f64)> {
    let end = *space.spent() + effort;
    let (is_free, range) = (space.longest_step().is_none(), space.longest_step().unwrap_or(RANGE));
    let n = goals.first().map_or(0, Vec::len);
    let (mut wanted, mut from, mut to) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    while *space.spent() < end {
        // The smaller one grows.
        let grows = usize::from(trees[1].len() < trees[0].len());
        samples.next(&mut wanted);
        let (near, squared) = trees[grows].nearest(&wanted);
        *space.spent() += 1;
        let apart = squared.sqrt();
        if apart > trees[grows].domain(near) {
            continue;
        }
        trees[grows].position(near, &mut from);
        step(&from, &wanted, apart, range, &mut to);
        let is_clear = space.project(&mut to) && space.is_clear(&from, &to);
        trees[grows].tried(near, is_clear);
        if !is_clear {
            continue;
        }
        let new = trees[grows].add(&to, Some(near));
        // The other one goes towards it as far as it can.
        let other = 1 - grows;
        wanted.copy_from_slice(&to);
        let (mut near, squared) = trees[other].nearest(&wanted);
        let mut left = squared.sqrt();
        loop {
            trees[other].position(near, &mut from);
            let arrives = step(&from, &wanted, left, range, &mut to);
            if !arrives && !space.project(&mut to) {
                break;
            }
            if !space.is_clear(&from, &to) {
                break;
            }
            if arrives {
                let mut path = trees[grows].to_root(new);
                let mut rest = trees[other].to_root(near);
                if grows == 1 {
                    core::mem::swap(&mut path, &mut rest);
                }
                path.reverse();
                path.extend(rest);
                return Ok(path);
            }
            near = trees[other].add(&to, Some(near));
            let before = left;
            left = if is_free { left - range } else { distance(&to, &wanted) };
            // A projection may lead back.
            if left > before - 0.1 * range {
                break;
            }
        }
    }
    let reached = goals.iter().map(|goal| trees[0].nearest(goal));
    let (node, squared) = reached.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f32::INFINITY));
    trees[0].position(node, &mut from);
    Err((from, f64::from(squared.sqrt())))
}

/// The position at most one step from `from` towards `wanted`, which is `distance` away; whether it is that.
fn step(from: &[f32], wanted: &[f32], distance: f32, range: f32, to: &mut [f32]) -> bool {
    let arrives = distance <= range;
    let share = if arrives { 1.0 } else { range / distance };
    for ((to, from), wanted) in to.iter_mut().zip(from).zip(wanted) {
        *to = if arrives { *wanted } else { from + (wanted - from) * share };
    }
    arrives
}
