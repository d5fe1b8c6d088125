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
