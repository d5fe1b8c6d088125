//! Whether what a stop sweeps is clear, from everywhere on a piece of a path.
//!
//! In: a piece of a path, and the speed at which it is passed. Out: whether all states that a fault stop leads through are clear.
//!
//! A stop on the path needs no check of its own: the path is clear. In a fault stop each robot leaves it. From the joint
//! velocities `q'` it goes on for the reaction time, until the last robot knows of the fault, and then brakes: [`reaches`] has where each joint
//! may be at each share of the stop, 0 to 1.
//!
//! Robots need not begin together, so every share of one robot goes with every one of the others. One that is still told where to go
//! follows the path until it brakes: the velocity of each joint is one of those that it has on the path until then, so `q'` is a range
//! for each joint. Arms that hold one body may also brake together on a [`Twist`].
//! Positions and velocities are bounded by the control points of the path, between samples too.

use core::ops::Range;

use crate::check::Checker;
use crate::lanes::LANES;
use crate::limits::Limits;
use crate::path::Path;
use crate::proof::{Boxes, Proof};
use crate::reach::{Reach, reaches};
use crate::twist::Twist;

/// The most boxes into which the states of a stop are divided. With four times as many, motions of four arms were as fast, and took twice as long to plan.
const MOST: usize = 100;
// At most twice as many as there were before, from at most as many as there are lanes on, so that they fit in a mask.
const _: () = assert!(MOST + LANES <= 2 * Boxes::BITS as usize);

/// The shortest part of a stop that is divided [rad or m].
const SHORTEST: f64 = 1e-4;

/// What a stop sweeps from a piece of a path.
pub(crate) struct Swept {
    /// The middle of the positions of the piece, and how far they are off it.
    middle: Vec<f64>,
    half: Vec<f64>,
    /// Where each joint may be in the stop, as seen from there.
    reach: Vec<Reach>,
}

/// A box of states: the shares of the stop between which each robot is.
#[derive(Clone, Copy)]
struct Part {
    shares: [[f64; 2]; ROBOTS],
}

/// The most robots.
pub(crate) const ROBOTS: usize = 4;

impl Swept {
    /// From the parameters `from` to `to`, with speeds of at most `speed` \[1/s\] from there until the reaction time \[s\] is over.
    pub(crate) fn new(path: &Path, [from, to]: [f64; 2], speed: f64, limits: &Limits, reaction: f64) -> Self {
        let n = limits.velocity.len();
        let mut swept = Swept { middle: vec![0.0; n], half: vec![0.0; n], reach: vec![Reach::default(); n] };
        let mut place = vec![[f64::INFINITY, f64::NEG_INFINITY]; n];
        let mut begin = from;
        loop {
            begin = path.stretch(begin, to, |j, middle, half| {
                place[j] = [place[j][0].min(middle - half), place[j][1].max(middle + half)];
            });
            if begin >= to {
                break;
            }
        }
        for (j, [lower, upper]) in place.into_iter().enumerate() {
            (swept.middle[j], swept.half[j]) = (0.5 * (lower + upper), 0.5 * (upper - lower));
        }
        let mut rates = vec![[0.0; 2]; n];
        path.rates(from, to + speed * reaction, |j, ends| rates[j] = ends.map(|rate| rate * speed));
        for robot in &limits.robots {
            reaches(limits, robot.clone(), reaction, |j| rates[j], |j, reach| swept.reach[j] = reach);
        }
        swept
    }

    /// The same for arms that hold one body, and may also brake together on the `twist` that it has in a cell of the grid; `None` where they have
    /// no posture on it.
    pub(crate) fn together(
        mut self,
        path: &Path,
        [from, to]: [f64; 2],
        speed: f64,
        limits: &Limits,
        reaction: f64,
        (twist, cell): (&Twist, usize),
    ) -> Option<Self> {
        let mut rates = vec![[0.0; 2]; limits.joints()];
        path.rates(from, to + speed * reaction, |j, ends| rates[j] = ends.map(|rate| rate * speed));
        let (time, far, bends) = twist.stop(cell, limits, &rates, speed, reaction)?;
        for (j, rates) in rates.into_iter().enumerate().filter(|(j, _)| limits.jerk[*j].is_none()) {
            self.reach[j] = Reach::bent(rates, reaction, time, 0.5 * bends[j] * far * far);
        }
        Some(self)
    }

    /// The middle of the positions of a joint between two shares of the stop, and how far it may be off that [rad or m].
    pub(crate) fn between(&self, j: usize, [from, to]: [f64; 2]) -> [f64; 2] {
        let [lower, upper] = self.reach[j].between(from, to);
        [self.middle[j] + 0.5 * (lower + upper), self.half[j] + 0.5 * (upper - lower)]
    }

    /// How far the joint of some that goes farthest goes [rad or m].
    pub(crate) fn longest(&self, joints: Range<usize>) -> f64 {
        joints.map(|j| self.reach[j].travel().abs()).fold(0.0, f64::max)
    }

    /// A joint that would stop beyond its limit is refused by its robot before it gets there. The path itself is within the limits.
    pub(crate) fn is_within(&self, limits: &Limits) -> bool {
        (0..self.middle.len()).all(|j| {
            let [lower, upper] = self.reach[j].between(1.0, 1.0);
            let off = (0.5 * (upper - lower) - self.half[j]).max(0.0);
            let far = self.middle[j] + self.reach[j].travel();
            limits.lower[j] <= far - off && far + off <= limits.upper[j]
        })
    }

    /// Whether all of it is proven clear, for the pairs of a proof.
    pub(crate) fn is_clear(&self, checker: &Checker, proof: &mut Proof, limits: &Limits) -> bool {
        // With how far they go.
        let robots: Vec<(usize, f64)> = (0..limits.robots.len())
            .filter(|&robot| proof.among.has_arm(robot))
            .map(|robot| (robot, self.longest(limits.robots[robot].clone())))
            .collect();
        let mut open = vec![Part { shares: [[0.0, 1.0]; ROBOTS] }];
        // As many as there are lanes.
        while open.len() < LANES
            && let Some(parts) =
                open.iter().map(|part| self.divided(limits, &robots, *part)).collect::<Option<Vec<_>>>()
        {
            open = parts.into_flattened();
        }
        let robot_of: Vec<usize> =
            limits.robots.iter().enumerate().flat_map(|(i, joints)| joints.clone().map(move |_| i)).collect();
        let place = |parts: &[Part], part: usize, j: usize| self.between(j, parts[part].shares[robot_of[j]]);
        let mut left = MOST - open.len();
        let mut unproven = proof.begin(checker, open.len(), |part, j| place(&open, part, j));
        while unproven != 0 {
            let parts = open.iter().enumerate().filter(|(i, _)| unproven >> i & 1 == 1);
            let parts = parts.map(|(_, part)| self.divided(limits, &robots, *part));
            let Some(parts) = parts.collect::<Option<Vec<_>>>() else { return false };
            open = parts.into_flattened();
            if left < open.len() {
                return false;
            }
            left -= open.len();
            unproven = proof.go_on(checker, unproven, |part, j| place(&open, part, j));
        }
        true
    }

    /// A box in two, across the longest of the stops of `robots`; `None` where that makes none of them much smaller.
    fn divided(&self, limits: &Limits, robots: &[(usize, f64)], part: Part) -> Option<[Part; 2]> {
        let lengths = robots.iter().map(|&(robot, longest)| {
            let [from, to] = part.shares[robot];
            (robot, longest * 0.5 * (to - from))
        });
        let (robot, length) = lengths.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))?;
        let [from, to] = part.shares[robot];
        let middle = 0.5 * (from + to);
        let joints = limits.robots[robot].clone();
        let left = joints.map(|j| self.between(j, [middle; 2])[1]).fold(0.0, f64::max);
        if length < SHORTEST.max(0.3 * left) {
            return None;
        }
        Some([[from, middle], [middle, to]].map(|shares| {
            let mut half = part;
            half.shares[robot] = shares;
            half
        }))
    }
}
