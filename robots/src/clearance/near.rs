//! Which capsules of two parts may be nearer to one another than a distance, by their trees.
//!
//! In: two parts of robots that stand, or one and an obstacle. Out: the pairs of their capsules, the nearest nodes first, without those that are farther apart
//! than what was found. Two nodes are at least as far apart as
//!
//! ```text
//! |c_1 - c_2| - s_1 - s_2 - D_1 - D_2 - margin,
//! ```
//!
//! with the centres of their boxes, how far these reach along the line between the centres, and how far the balls around them may still get: no point
//! below a node gets farther than its ball. A search allocates nothing.

use nalgebra::{Matrix3, Vector3};

use super::bits::Bits;
use super::cover::{Node, ROUNDING};
use super::gap::Gap;
use super::obstacle::Obstacle;
use super::placement::{Placed, Placement};
use crate::models::Capsule;

/// A part of a robot, by their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct PartOf {
    pub(super) robot: usize,
    pub(super) part: usize,
}

/// A leaf of a tree.
#[derive(Clone, Copy)]
pub(super) struct Leaf<'a> {
    /// Its place among the nodes of its robot.
    pub(super) at: usize,
    /// The number of its capsule.
    pub(super) link: usize,
    pub(super) placed: &'a Placed,
}

impl<'a> Leaf<'a> {
    pub(super) fn of(robot: &'a Placement, at: usize) -> Self {
        Self { at, link: robot.nodes[at].link as usize, placed: robot.placed(at) }
    }
}

/// Two parts, and what is taken off their distance.
pub(super) struct Between<'a> {
    sides: [PartOf; 2],
    /// The places of their roots.
    roots: [usize; 2],
    /// The rotations of their frames.
    turns: [Matrix3<f64>; 2],
    /// The motion from which on their travel counts, and their margin \[m\]; `None` where the distance itself is asked for.
    taken: Option<(usize, f64)>,
    /// Which pairs are looked at; `None`: all.
    open: Option<&'a Bits>,
    /// Along which the nearest pair so far is apart: what is behind one of both ends is farther apart.
    along: Option<Along>,
    /// How far that pair is apart \[m\].
    nearest: f64,
}

/// A direction of length 1, and its size along the axes of both frames.
#[derive(Clone, Copy)]
struct Along {
    line: Vector3<f64>,
    sizes: [Vector3<f64>; 2],
}

impl<'a> Between<'a> {
    /// Of two parts; `taken` are the motion from which on their travel counts and their margin \[m\], `None` where the distance itself is asked for.
    pub(super) fn new(
        robots: &[Placement],
        sides: [PartOf; 2],
        taken: Option<(usize, f64)>,
        open: Option<&'a Bits>,
    ) -> Self {
        let [a, b] = sides;
        let [one, other] = [&robots[a.robot], &robots[b.robot]];
        let roots = [one.parts[a.part].nodes.start, other.parts[b.part].nodes.start];
        let turns = [one.turn(a.part), other.turn(b.part)];
        Self { sides, roots, turns, taken, open, along: None, nearest: f64::INFINITY }
    }

    /// How much is left at least between what is below both roots \[m\], or another number above `least`.
    pub(super) fn left(&self, robots: &mut [Placement], least: f64) -> f64 {
        self.left_below(robots, self.roots, least)
    }

    /// Visits the pairs of capsules that may have no more than `least` \[m\] left between them. `visit` is given what was least so far, and
    /// returns the gap of the pair and the least one with it.
    pub(super) fn visit(
        &mut self,
        robots: &mut [Placement],
        least: f64,
        visit: &mut impl FnMut(Leaf<'_>, Leaf<'_>, f64) -> (Gap, f64),
    ) -> f64 {
        self.visit_below(robots, self.roots, least, visit)
    }

    /// How much is left between two nodes at least \[m\], or another number above `least`; infinite where nothing below them is looked at.
    #[inline]
    fn left_below(&self, robots: &mut [Placement], nodes: [usize; 2], least: f64) -> f64 {
        if let Some(open) = self.open
            && !open.has(nodes[0] - self.roots[0], nodes[1] - self.roots[1])
        {
            return f64::INFINITY;
        }
        let [a, b] = self.sides;
        robots[a.robot].place(a.part, nodes[0]);
        robots[b.robot].place(b.part, nodes[1]);
        let [one, other] = [&robots[a.robot], &robots[b.robot]];
        let [placed, beside] = [one.placed(nodes[0]), other.placed(nodes[1])];
        let taken =
            self.taken.map_or(0.0, |(since, margin)| placed.travel[since] + beside.travel[since] + margin);
        let line = beside.centre - placed.centre;
        let [node, next] = [&one.nodes[nodes[0]], &other.nodes[nodes[1]]];
        if let Some(Along { line: along, sizes }) = &self.along {
            let reach = reach(node, placed, along, &sizes[0]) + reach(next, beside, along, &sizes[1]);
            let left = line.dot(along) - reach - taken;
            if left > least {
                return left;
            }
        }
        let length = line.norm();
        let left = length - placed.around - beside.around - taken;
        if left > least || length == 0.0 {
            return left;
        }
        let along = line / length;
        let [size, beside_size] = [&self.turns[0], &self.turns[1]].map(|turn| turn.tr_mul(&along).abs());
        let reach = reach(node, placed, &along, &size).min(placed.around)
            + reach(next, beside, &along, &beside_size).min(beside.around);
        length - reach - taken
    }

    fn visit_below(
        &mut self,
        robots: &mut [Placement],
        nodes: [usize; 2],
        mut least: f64,
        visit: &mut impl FnMut(Leaf<'_>, Leaf<'_>, f64) -> (Gap, f64),
    ) -> f64 {
        let [a, b] = self.sides;
        let [one, other] = [&robots[a.robot].nodes[nodes[0]], &robots[b.robot].nodes[nodes[1]]];
        if one.is_leaf() && other.is_leaf() {
            let [one, other] = [Leaf::of(&robots[a.robot], nodes[0]), Leaf::of(&robots[b.robot], nodes[1])];
            let (gap, least) = visit(one, other, least);
            if gap.distance < self.nearest {
                self.turn_along(&gap, [one.placed, other.placed]);
            }
            return least;
        }
        let pairs = if other.is_leaf() || (!one.is_leaf() && one.radius >= other.radius) {
            let [first, second] = one.children(nodes[0]);
            [[first, nodes[1]], [second, nodes[1]]]
        } else {
            let [first, second] = other.children(nodes[1]);
            [[nodes[0], first], [nodes[0], second]]
        };
        let left = [self.left_below(robots, pairs[0], least), self.left_below(robots, pairs[1], least)];
        let nearer = usize::from(left[1] < left[0]);
        let is_near = |left: f64, least: f64| left <= least && left < f64::INFINITY;
        if is_near(left[nearer], least) {
            least = self.visit_below(robots, pairs[nearer], least, visit);
        }
        let farther = 1 - nearer;
        if is_near(left[farther], least) && is_near(self.left_below(robots, pairs[farther], least), least) {
            least = self.visit_below(robots, pairs[farther], least, visit);
        }
        least
    }

    /// Takes the line between the points of a gap, from the first side to the second, if it has one.
    fn turn_along(&mut self, gap: &Gap, [one, other]: [&Placed; 2]) {
        self.nearest = gap.distance;
        let [p, q] = &gap.points;
        let line = q - p;
        let line = if line.dot(&(other.centre - one.centre)) < 0.0 { -line } else { line };
        let length = line.norm();
        if length > SHORTEST {
            let line = line / length;
            let sizes = [self.turns[0].tr_mul(&line).abs(), self.turns[1].tr_mul(&line).abs()];
            self.along = Some(Along { line, sizes });
        }
    }
}

/// A gap that is shorter has no direction \[m\].
const SHORTEST: f64 = 1e-6;

/// How far a node reaches from its centre along a direction of length 1 \[m\], or against it, that has such a size along the axes of its frame.
#[inline]
fn reach(node: &Node, placed: &Placed, along: &Vector3<f64>, size: &Vector3<f64>) -> f64 {
    if node.is_leaf() {
        let Capsule { ends: [a, b], radius } = &placed.capsule;
        0.5 * (b - a).dot(along).abs() + radius + ROUNDING
    } else {
        size.dot(&node.half) + node.round
    }
}

/// A part and an obstacle, and what is taken off their distance.
pub(super) struct Beside<'a> {
    pub(super) side: PartOf,
    pub(super) obstacle: &'a Obstacle,
    /// Their margin \[m\]; `None` where the distance itself is asked for.
    pub(super) margin: Option<f64>,
    /// Which capsules are looked at; `None`: all.
    pub(super) open: Option<&'a Bits>,
}

impl Beside<'_> {
    /// How much is left between a node and the obstacle at least \[m\], if it is not more than `least`.
    #[inline]
    pub(super) fn at_least(&self, robots: &mut [Placement], node: usize, least: f64) -> Option<f64> {
        let PartOf { robot, part } = self.side;
        let robot = &mut robots[robot];
        if self.open.is_some_and(|open| !open.has(node - robot.parts[part].nodes.start, 0)) {
            return None;
        }
        let Placed { centre, around, travel, .. } = robot.place(part, node);
        let taken = around + self.margin.map_or(0.0, |margin| travel[0] + margin);
        // An obstacle's distance is looked for no farther than is asked.
        let left = self.obstacle.distance(centre, least + taken + ROUNDING) - taken;
        (left <= least).then_some(left)
    }

    /// As [`Between::visit`], of the capsules below a node.
    pub(super) fn visit(
        &self,
        robots: &mut [Placement],
        node: usize,
        mut least: f64,
        visit: &mut impl FnMut(Leaf<'_>, f64) -> f64,
    ) -> f64 {
        let of = &robots[self.side.robot].nodes[node];
        if of.is_leaf() {
            return visit(Leaf::of(&robots[self.side.robot], node), least);
        }
        let nodes = of.children(node);
        let bounds = nodes.map(|child| self.at_least(robots, child, least).unwrap_or(f64::INFINITY));
        let nearer = usize::from(bounds[1] < bounds[0]);
        for child in [nearer, 1 - nearer] {
            if bounds[child] <= least && bounds[child] < f64::INFINITY {
                least = self.visit(robots, nodes[child], least, visit);
            }
        }
        least
    }
}
