//! Makes a path shorter: what is straight and clear replaces what is not.

use mrroc::random::Random;

use super::{Joints, Points, Space, between, distance};
use crate::check::{Among, Checker};
use crate::edge::Edges;

/// Ends after so many tries in a row that gained nothing: of one robot, and of several for each of them.
const IN_VAIN: [usize; 2] = [10, 30];

/// What is gained by less than this share of the path is not worth a check.
const GAIN: f32 = 0.01;

/// A shortcut that would begin or end nearer than this to a point of the path does so at that point [rad or m].
const SAME: f32 = 1e-4;

/// Length of a path: the sum of the roots of the sums of squares over all joints [rad or m].
fn length(path: &[Vec<f32>]) -> f64 {
    path.windows(2).map(|pair| f64::from(distance(&pair[0], &pair[1]))).sum()
}

/// Shortens `path` by at most `effort` checks.
pub(crate) fn shorten(checker: &mut Checker, edges: &mut Edges, seed: u64, path: &mut Points, effort: u64) {
    let end = checker.batches + effort;
    skip(&mut Joints { checker, edges }, path, end);
    let mut random = Random::seeded(seed ^ 0x5ca1_ab1e);
    let mut in_vain = 0;
    // Where one robot moves alone, there is nothing to be gained for the others.
    let robots = if checker.among == Among::All { checker.arms.len() } else { 1 };
    let tries = if robots == 1 { IN_VAIN[0] } else { IN_VAIN[1] * robots };
    while path.len() > 2 && in_vain < tries && checker.batches < end {
        in_vain += 1;
        // Of several robots either all take the straight line, or one of them.
        let one = if robots == 1 { 1 } else { random.below(2 * robots) };
        let is_shorter = if one < robots && robots > 1 {
            cut_of(checker, edges, &mut random, path, one)
        } else {
            cut(&mut Joints { checker, edges }, &mut random, path)
        };
        if is_shorter {
            in_vain = 0;
        }
    }
    skip(&mut Joints { checker, edges }, path, end);
}

/// Shortens a path in any space by at most `effort` checks.
pub(crate) fn shorten_any(space: &mut impl Space, seed: u64, path: &mut Points, effort: u64) {
    let end = *space.spent() + effort;
    skip(space, path, end);
    let mut random = Random::seeded(seed ^ 0x5ca1_ab1e);
    let mut in_vain = 0;
    while path.len() > 2 && in_vain < IN_VAIN[0] && *space.spent() < end {
        in_vain = if cut(space, &mut random, path) { 0 } else { in_vain + 1 };
    }
    skip(space, path, end);
}

/// A straight motion between two random points, if it is clear and gains enough; whether it was.
fn cut(space: &mut impl Space, random: &mut Random, path: &mut Points) -> bool {
    let whole = length(path);
    let [a, b] = two_of(random, path, whole);
    if a.0 == b.0 {
        return false;
    }
    let [from, to] = [a, b].map(|place| place_on(path, place));
    let before =
        distance(&from, &path[a.0 + 1]) + length(&path[a.0 + 1..=b.0]) as f32 + distance(&path[b.0], &to);
    let least = GAIN * whole as f32;
    if before - distance(&from, &to) < least {
        return false;
    }
    let mut points = vec![from, to];
    let is_clear = space.is_clear(&points[0], &points[1])
        || space.bend(&mut points) && before - (length(&points) as f32) >= least;
    if !is_clear {
        return false;
    }
    // What remains of both legs is a part of what was clear.
    path.splice(a.0 + 1..=b.0, points);
    path.dedup();
    true
}

/// The same for the joints of one robot: the others pass the points that they have passed.
fn cut_of(
    checker: &mut Checker,
    edges: &mut Edges,
    random: &mut Random,
    path: &mut Points,
    robot: usize,
) -> bool {
    let whole = length(path);
    let [a, b] = two_of(random, path, whole);
    if a.0 == b.0 {
        return false;
    }
    let [from, to] = [a, b].map(|place| place_on(path, place));
    let before: Points =
        [from.clone()].into_iter().chain(path[a.0 + 1..=b.0].iter().cloned()).chain([to.clone()]).collect();
    let passed = length(&before);
    if passed <= 0.0 {
        return false;
    }
    let joints = checker.arms[robot].first..checker.arms[robot].first + checker.arms[robot].joints;
    let mut after = before.clone();
    for k in 1..after.len() - 1 {
        let share = (length(&before[..=k]) / passed) as f32;
        for j in joints.clone() {
            after[k][j] = from[j] + (to[j] - from[j]) * share;
        }
    }
    if passed - length(&after) < f64::from(GAIN) * whole {
        return false;
    }
    // The others have moved so before.
    checker.among = Among::Of(robot);
    let is_clear = after.windows(2).all(|leg| edges.is_clear(checker, &leg[0], &leg[1]));
    checker.among = Among::All;
    if is_clear {
        path.splice(a.0 + 1..=b.0, after);
        path.dedup();
    }
    is_clear
}

/// Two random places on a path of this length, one behind the other.
fn two_of(random: &mut Random, path: &Points, whole: f64) -> [(usize, f32); 2] {
    let [a, b] = [random.unit(), random.unit()].map(|share| at(path, share * whole));
    if (a.0, a.1) <= (b.0, b.1) { [a, b] } else { [b, a] }
}

/// The point at a share of a leg; an end of the leg that is all but there. So no points remain that are nearly one: to leave one of them out would
/// make a leg that was never checked.
fn place_on(path: &Points, (leg, share): (usize, f32)) -> Vec<f32> {
    let place = between(&path[leg], &path[leg + 1], share);
    let near = path[leg..=leg + 1].iter().find(|end| distance(end, &place) < SAME);
    near.cloned().unwrap_or(place)
}

/// Leaves out points between two that a straight motion joins: for each one, from the far end on.
fn skip(space: &mut impl Space, path: &mut Points, end: u64) {
    let mut from = 0;
    while from + 2 < path.len() {
        let mut to = path.len() - 1;
        while to > from + 1 && *space.spent() < end {
            if space.is_clear(&path[from], &path[to]) {
                path.drain(from + 1..to);
                break;
            }
            to -= 1;
        }
        from += 1;
    }
}

/// The leg of a path in which a length is, and the share of that leg before it.
fn at(path: &[Vec<f32>], along: f64) -> (usize, f32) {
    let mut left = along;
    for (leg, pair) in path.windows(2).enumerate() {
        let length = f64::from(distance(&pair[0], &pair[1]));
        if left <= length && length > 0.0 {
            return (leg, (left / length) as f32);
        }
        left -= length;
    }
    (path.len() - 2, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shortcut_begins_at_a_point_of_the_path_that_is_all_but_there() {
        let path: Points = [0.0, 1.0, 3.0].map(|q| vec![q]).to_vec();
        for (place, expected) in
            [((0, 0.5), 0.5), ((0, 5e-5), 0.0), ((0, 1.0 - 5e-5), 1.0), ((1, 1e-3), 1.002)]
        {
            assert_eq!(place_on(&path, place), [expected], "{place:?}");
        }
    }
}
