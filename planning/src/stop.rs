//! Whether what a stop sweeps is clear, from everywhere on a piece of a path.
//!
//! In: a piece of a path, and the speed at which it is passed. Out: whether all states that a fault stop leads through are clear.
//!
//! A stop on the path needs no check of its own: the path is clear. In a fault stop each robot leaves it. From the joint
//! velocities `q'` it goes on for the reaction time `T_r`, until the last robot knows of the fault, and then brakes:
//!
//! - without limits of jerk all joints of a robot stand after `T = max |q'_i| / a_i`, on a straight line in joint space:
//!   `q + lambda q' (T_r + T / 2)`, `lambda` 0 to 1;
//! - with them each joint brakes by itself: anywhere between `q_i` and `q_i + w_i`.
//!
//! Robots need not begin together, so every `lambda` of one robot goes with every one of the others. One that is still told where to go
//! follows the path until it brakes: the velocity of each joint is one of those that it has on the path until then, so `q'` is a range
//! for each joint. Positions and velocities are bounded by the control points of the path, between samples too.

use core::ops::Range;

use mrroc_robots::clearance::braking_distance;

use crate::arm::Around;
use crate::check::Checker;
use crate::lanes::{LANES, Lanes, Mask};
use crate::limits::Limits;
use crate::path::Path;

/// The most boxes into which the states of a stop are divided.
const MOST: usize = 400;

/// What a stop sweeps from a piece of a path.
pub(crate) struct Swept {
    /// The middle of the positions of the piece, and how far they are off it.
    middle: Vec<f64>,
    half: Vec<f64>,
    /// How far each joint goes until it stands, and how far it may be off that line then.
    travel: Vec<f64>,
    off: Vec<f64>,
}

/// How far a joint gets in a fault stop [rad or m].
#[derive(Clone, Copy, Default)]
pub(crate) struct Reach {
    /// With a limit of jerk, the middle of where it may be, as seen from where it was, and how far it may be off that.
    pub(crate) middle: f64,
    pub(crate) half: f64,
    /// Without one, how far it goes on its line until it stands, and how far it may be off the line then.
    pub(crate) travel: f64,
    pub(crate) off: f64,
}

/// How far the joints of a robot get in a fault stop, from velocities in the range that `rates` has for each [rad/s or m/s].
pub(crate) fn reaches(
    limits: &Limits,
    joints: Range<usize>,
    reaction: f64,
    rates: impl Fn(usize) -> [f64; 2],
    mut visit: impl FnMut(usize, Reach),
) {
    let fastest = |j: usize| rates(j)[0].abs().max(rates(j)[1].abs());
    let time = joints.clone().map(|j| fastest(j) / limits.acceleration[j]).fold(0.0, f64::max);
    for j in joints {
        let Some(jerk) = limits.jerk[j] else {
            let [lower, upper] = rates(j).map(|rate| rate * (reaction + 0.5 * time));
            let (travel, off) = (0.5 * (lower + upper), 0.5 * (upper - lower));
            visit(j, Reach { travel, off, ..Reach::default() });
            continue;
        };
        let [lower, upper] = rates(j).map(|rate| {
            if rate == 0.0 {
                return 0.0;
            }
            (rate.abs() * reaction + braking_distance(rate.abs(), limits.acceleration[j], jerk))
                .copysign(rate)
        });
        let [lower, upper] = [lower.min(0.0), upper.max(0.0)];
        let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower));
        visit(j, Reach { middle, half, ..Reach::default() });
    }
}

/// A box of states: the part of its line on which each robot is, as middle and half.
#[derive(Clone, Copy)]
struct Part {
    middle: [f64; ROBOTS],
    half: [f64; ROBOTS],
}

/// The most robots.
pub(crate) const ROBOTS: usize = 4;

impl Swept {
    /// From the parameters `from` to `to`, with speeds of at most `speed` \[1/s\] from there until the reaction time \[s\] is over.
    pub(crate) fn new(path: &Path, [from, to]: [f64; 2], speed: f64, limits: &Limits, reaction: f64) -> Self {
        let n = limits.velocity.len();
        let mut swept =
            Swept { middle: vec![0.0; n], half: vec![0.0; n], travel: vec![0.0; n], off: vec![0.0; n] };
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
            reaches(
                limits,
                robot.clone(),
                reaction,
                |j| rates[j],
                |j, reach| {
                    swept.middle[j] += reach.middle;
                    swept.half[j] += reach.half;
                    (swept.travel[j], swept.off[j]) = (reach.travel, reach.off);
                },
            );
        }
        swept
    }

    /// The middle of the positions of a joint at a share of the stop, 0 to 1 [rad or m].
    pub(crate) fn at(&self, j: usize, share: f64) -> f64 {
        self.middle[j] + share * self.travel[j]
    }

    /// How far a joint may be off that, at shares within `half` of `middle` [rad or m].
    pub(crate) fn around(&self, j: usize, middle: f64, half: f64) -> f64 {
        self.half[j] + half * self.travel[j].abs() + (middle + half) * self.off[j]
    }

    /// How far the joint of some that goes farthest goes on its line [rad or m].
    pub(crate) fn longest(&self, joints: Range<usize>) -> f64 {
        joints.map(|j| self.travel[j].abs()).fold(0.0, f64::max)
    }

    /// A joint that would stop beyond its limit is refused by its robot before it gets there. The path itself is within the limits.
    pub(crate) fn is_within(&self, limits: &Limits) -> bool {
        (0..self.middle.len()).all(|j| {
            let Swept { middle, half, travel, off } = self;
            let far = [-1.0, 1.0].map(|side| middle[j] + travel[j] + side * (off[j] - half[j]).max(0.0));
            limits.lower[j] <= far[0] && far[1] <= limits.upper[j]
        })
    }

    /// Whether all of it is proven clear, for the pairs that the checker is told to check.
    ///
    /// What was proven for all of some boxes needs no proof in parts of them.
    pub(crate) fn is_clear(&self, checker: &mut Checker, limits: &Limits) -> bool {
        let robots: Vec<usize> = (0..limits.robots.len()).filter(|&i| checker.among.has_arm(i)).collect();
        let n = self.middle.len();
        let mut open = vec![Part { middle: [0.5; ROBOTS], half: [0.5; ROBOTS] }];
        // As many as there are lanes.
        while open.len() < LANES
            && let Some(parts) =
                open.iter().map(|part| self.divided(limits, &robots, *part)).collect::<Option<Vec<_>>>()
        {
            open = parts.into_flattened();
        }
        let (mut q, mut half) = (vec![Lanes::default(); n], vec![Lanes::default(); n]);
        let mut left = MOST;
        checker.list_all();
        loop {
            if left < open.len() {
                return false;
            }
            left -= open.len();
            let mut unproven = Vec::new();
            for taken in open.chunks(LANES) {
                let batch: [Part; LANES] = core::array::from_fn(|lane| taken[lane.min(taken.len() - 1)]);
                for &robot in &robots {
                    for j in limits.robots[robot].clone() {
                        q[j] = Lanes::new(batch.map(|part| self.at(j, part.middle[robot]) as f32));
                        half[j] = Lanes::new(batch.map(|part| {
                            (self.around(j, part.middle[robot], part.half[robot]) * (1.0 + 1e-6)) as f32
                        }));
                    }
                }
                let wanted = ((1u16 << taken.len()) - 1) as Mask;
                let verdict = checker.check_listed(&q, Around::Box(&half), wanted);
                if verdict.clear != wanted {
                    return false;
                }
                let is_unproven = |(lane, _): &(usize, &Part)| verdict.proven >> lane & 1 == 0;
                unproven.extend(taken.iter().enumerate().filter(is_unproven).map(|(_, part)| *part));
            }
            if unproven.is_empty() {
                return true;
            }
            checker.narrow();
            let parts = unproven.iter().map(|part| self.divided(limits, &robots, *part));
            let Some(parts) = parts.collect::<Option<Vec<_>>>() else { return false };
            open = parts.into_flattened();
        }
    }

    /// A box in two, across the longest of the lines of `robots`; `None` where they are too short.
    fn divided(&self, limits: &Limits, robots: &[usize], part: Part) -> Option<[Part; 2]> {
        let length = |robot: usize| self.longest(limits.robots[robot].clone()) * part.half[robot];
        let all = robots.iter().copied();
        let robot = all.max_by(|a, b| length(*a).total_cmp(&length(*b)).then(b.cmp(a)))?;
        if length(robot) < 1e-4 {
            return None;
        }
        let side = |sign: f64| {
            let mut half = part;
            half.half[robot] *= 0.5;
            half.middle[robot] += sign * half.half[robot];
            half
        };
        Some([side(-1.0), side(1.0)])
    }
}
