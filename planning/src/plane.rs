//! Planes between the balls of two limbs.
//!
//! In: the trees of both, and where the first limb is, seen from the second one. Out: a direction along which what is below two nodes is apart by more than
//! is wanted, if one is found soon. Where all is on one side of a plane, few balls need to be looked at.
//!
//! Gilbert's algorithm (SIAM J. Control 4, 1966): from a difference of two points, one of each side, to the nearest one on the line to that which lies
//! farthest back.

use crate::balls::Node;
use crate::lanes::Frames;

/// How deep a stack of nodes may get: the trees of some ten thousand balls, halved in each node, are far from it.
pub(crate) const DEPTH: usize = 48;

/// How many directions are tried.
const TRIES: usize = 8;

type Vector = [f32; 3];

fn dot(a: Vector, b: Vector) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a + b x`.
fn along(a: Vector, b: Vector, x: f32) -> Vector {
    [0, 1, 2].map(|i| a[i] + b[i] * x)
}

/// How far what is below a node reaches along a direction of length 1 \[m\], and the point that does.
pub(crate) fn farthest(nodes: &[Node], node: u32, direction: Vector) -> (f32, Vector) {
    let reach = |at: u32| dot(nodes[at as usize].centre, direction) + nodes[at as usize].radius;
    let mut most = (f32::NEG_INFINITY, [0.0; 3]);
    let mut stack = [(0_u32, 0.0_f32); DEPTH];
    stack[0] = (node, reach(node));
    let mut depth = 1;
    while depth > 0 {
        depth -= 1;
        let (at, far) = stack[depth];
        if far <= most.0 {
            continue;
        }
        let Node { centre, radius, second, .. } = nodes[at as usize];
        if second == 0 {
            most = (far, along(centre, direction, radius));
            continue;
        }
        let [one, two] = [at + 1, second].map(|child| (child, reach(child)));
        // The farther one is looked at first.
        [stack[depth], stack[depth + 1]] = if one.1 > two.1 { [two, one] } else { [one, two] };
        depth += 2;
    }
    most
}

/// A direction of length 1, seen from the second limb, along which the first one is farther away than `wanted` \[m\] below two nodes, in one lane of
/// where it is; `first` is tried first.
pub(crate) fn find(
    trees: [&[Node]; 2],
    nodes: [u32; 2],
    frame: &Frames,
    lane: usize,
    wanted: f32,
    first: Vector,
) -> Option<Vector> {
    let [x, y, z, origin] = [frame.x, frame.y, frame.z, frame.origin].map(|p| p.0.map(|of| of.lane(lane)));
    let mut direction = first;
    let mut between: Option<Vector> = None;
    for _ in 0..TRIES {
        let back = [x, y, z].map(|axis| -dot(axis, direction));
        let (_, [a, b, c]) = farthest(trees[0], nodes[0], back);
        let near = along(along(along(origin, x, a), y, b), z, c);
        let (_, far) = farthest(trees[1], nodes[1], direction);
        let apart = along(near, far, -1.0);
        if dot(apart, direction) > wanted {
            return Some(direction);
        }
        let next = between.map_or(apart, |between| {
            let line = along(apart, between, -1.0);
            let share = -dot(between, line) / dot(line, line);
            if share > 0.0 { along(between, line, share.min(1.0)) } else { between }
        });
        let length = dot(next, next).sqrt();
        // No direction is better than the distance of two points; no number is above none.
        if length.is_nan() || length <= wanted {
            return None;
        }
        direction = next.map(|x| x / length);
        between = Some(next);
    }
    None
}

#[cfg(test)]
mod tests {
    use mrroc_robots::clearance::Capsule;
    use nalgebra::{Rotation3, Vector3};
    use proptest::prelude::*;

    use super::*;
    use crate::balls::BallTree;
    use crate::lanes::Points;

    fn leaves(tree: &BallTree) -> impl Iterator<Item = &Node> {
        tree.nodes.iter().filter(|node| node.second == 0)
    }

    /// Of capsules from the origin to each of these places.
    fn tree(places: &[[f64; 3]]) -> BallTree {
        let capsule = |place: &[f64; 3]| Capsule::new(Vector3::zeros(), Vector3::from(*place), 0.03);
        BallTree::of(&places.iter().map(capsule).collect::<Vec<_>>())
    }

    proptest! {
        #[test]
        fn all_balls_of_one_limb_are_beyond_those_of_the_other_along_a_direction_that_is_found(
            one in proptest::collection::vec(proptest::array::uniform3(-0.2..0.2_f64), 2..9),
            other in proptest::collection::vec(proptest::array::uniform3(-0.2..0.2_f64), 2..9),
            turn in proptest::array::uniform3(-2.0..2.0_f64), place in proptest::array::uniform3(-0.8..0.8_f64),
            wanted in 0.0..0.2_f32,
        ) {
            let trees = [tree(&one), tree(&other)];
            let turn = Rotation3::new(Vector3::from(turn));
            let column = |k: usize| Points::splat([0, 1, 2].map(|i| turn[(i, k)] as f32));
            let origin = Points::splat(place.map(|x| x as f32));
            let frame = Frames { x: column(0), y: column(1), z: column(2), origin };
            let [a, b] = trees.each_ref().map(|tree| tree.nodes.as_slice());
            let found = find([a, b], [0, 0], &frame, 3, wanted, [1.0, 0.0, 0.0]);
            let centre = |node: &Node| Vector3::from(node.centre.map(f64::from));
            let seen = |node: &Node| turn * centre(node) + Vector3::from(place);
            if let Some(direction) = found {
                let along = Vector3::from(direction.map(f64::from));
                prop_assert!((along.norm() - 1.0).abs() < 1e-6);
                for one in leaves(&trees[0]) {
                    for other in leaves(&trees[1]) {
                        let apart = along.dot(&(seen(one) - centre(other)));
                        let apart = apart - f64::from(one.radius) - f64::from(other.radius);
                        prop_assert!(apart > f64::from(wanted) - 1e-6);
                    }
                }
            } else {
                // Along the line between points of balls that are three times their radii apart, these are apart.
                let [one, other] = [&trees[0].nodes[0], &trees[1].nodes[0]];
                let apart = (seen(one) - centre(other)).norm();
                prop_assert!(apart < 3.0 * f64::from(one.radius + other.radius + wanted));
            }
        }

        #[test]
        fn what_reaches_farthest_is_a_ball_that_reaches_no_less_far_than_any_other(
            places in proptest::collection::vec(proptest::array::uniform3(-0.2..0.2_f64), 1..20),
            direction in proptest::array::uniform3(-1.0..1.0_f32),
        ) {
            let length = dot(direction, direction).sqrt();
            prop_assume!(length > 0.1);
            let direction = direction.map(|x| x / length);
            let tree = tree(&places);
            let (far, point) = farthest(&tree.nodes, 0, direction);
            let most = leaves(&tree).map(|node| dot(node.centre, direction) + node.radius);
            prop_assert_eq!(far, most.fold(f32::NEG_INFINITY, f32::max));
            prop_assert!((dot(point, direction) - far).abs() < 1e-6);
        }
    }
}
