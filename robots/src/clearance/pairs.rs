//! Which bodies are checked against which.

use mrroc::robot::MAX_JOINTS;

use super::obstacle::Obstacle;
use super::posture::{Joints, Placed, Placement};
use crate::models::Link;

/// Postures of every robot that tell which bodies always overlap and which never meet.
const POSTURES: usize = 2000;
/// How many are tried to find them among those that linkages and drives allow.
const TRIES: usize = 20_000;
/// Links of one robot that come no nearer than this in any of these postures never meet \[m\].
const NEVER_NEARER: f64 = 0.01;

/// Why a pair is not checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unchecked {
    AlwaysOverlap,
    NeverMeet,
}

/// A link of a robot, by its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Limb {
    pub(super) robot: usize,
    pub(super) link: usize,
}

/// The other side of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Other {
    Limb(Limb),
    Obstacle(usize),
}

/// Two bodies that are checked against one another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pair {
    pub(super) limb: Limb,
    pub(super) other: Other,
    /// The first motion that moves one of them alone: those before move both alike.
    pub(super) since: usize,
    pub(super) margin: f64,
}

impl Pair {
    /// Whether both are links of one robot.
    pub(super) fn is_own(&self) -> bool {
        matches!(self.other, Other::Limb(limb) if limb.robot == self.limb.robot)
    }
}

/// The first motion that moves only one of two links of a robot; `None` when none does.
fn first_apart(a: &Link, b: &Link) -> Option<usize> {
    let apart = a.moved_by ^ b.moved_by;
    (apart != 0).then_some(apart.trailing_zeros() as usize)
}

/// All pairs that can meet: links of different robots, links and obstacles, links of one robot that no joint connects.
pub(super) fn possible(robots: &[Placement], obstacles: usize) -> Vec<Pair> {
    let mut pairs = Vec::new();
    let margin = 0.0;
    for (robot, one) in robots.iter().enumerate() {
        for (link, outline) in one.links.iter().enumerate() {
            let limb = Limb { robot, link };
            for (other, behind) in one.links.iter().enumerate().skip(link + 1) {
                let connected = outline.rank.abs_diff(behind.rank) < 2;
                if let Some(since) = first_apart(outline, behind).filter(|_| !connected) {
                    pairs.push(Pair { limb, other: Other::Limb(Limb { robot, link: other }), since, margin });
                }
            }
            for (second, another) in robots.iter().enumerate().skip(robot + 1) {
                for link in 0..another.links.len() {
                    let other = Other::Limb(Limb { robot: second, link });
                    pairs.push(Pair { limb, other, since: 0, margin });
                }
            }
            pairs.extend((0..obstacles).map(|o| Pair { limb, other: Other::Obstacle(o), since: 0, margin }));
        }
    }
    pairs
}

/// Removes, and gives back, pairs of which a check would mean nothing, as 2000 postures spread over the joints' ranges show.
///
/// Those of a robot with itself or with obstacles that overlap in all postures: what is mounted there, or modelled too
/// stout. And links of one robot that stay 10 mm apart in all of them, such as cranks in planes side by side: the way to
/// a standstill, which knows no directions, would stop the robot for nothing. Pairs of two robots stay whatever they do.
pub(super) fn without_meaningless(
    pairs: &mut Vec<Pair>,
    robots: &mut [Placement],
    obstacles: &[Obstacle],
) -> Vec<(Pair, Unchecked)> {
    let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY); pairs.len()];
    for (robot, placement) in robots.iter_mut().enumerate() {
        let mut stood = 0;
        for sample in 1..=TRIES {
            if stood == POSTURES {
                break;
            }
            let q = spread(placement, sample);
            if !placement.shape().is_possible(&q) || !placement.stand(&q, None) {
                continue;
            }
            stood += 1;
            for (pair, (least, most)) in pairs.iter().zip(&mut ranges) {
                let own = placement.placed.get(pair.limb.link).filter(|_| pair.limb.robot == robot);
                let Some(own) = own else { continue };
                let distance = match pair.other {
                    Other::Limb(limb) if limb.robot == robot => {
                        own.capsule.gap(&placement.placed[limb.link].capsule).distance
                    }
                    Other::Limb(_) => continue,
                    Other::Obstacle(o) => obstacles[o].gap(&own.capsule).distance,
                };
                (*least, *most) = (least.min(distance), most.max(distance));
            }
        }
    }
    let mut removed = Vec::new();
    let mut ranges = ranges.into_iter();
    pairs.retain(|pair| {
        // Without a posture that was seen, least is above most.
        let why = match ranges.next() {
            Some((least, most)) if least <= most && most < 0.0 => Some(Unchecked::AlwaysOverlap),
            Some((least, most)) if least <= most && pair.is_own() && least > NEVER_NEARER => {
                Some(Unchecked::NeverMeet)
            }
            _ => None,
        };
        removed.extend(why.map(|why| (*pair, why)));
        why.is_none()
    });
    removed
}

/// A posture of the Halton sequence: evenly spread, the same in every run.
fn spread(placement: &Placement, sample: usize) -> Joints {
    const PRIMES: [usize; MAX_JOINTS] = [2, 3, 5, 7, 11, 13, 17, 19];
    placement.shape().between_limits(&|joint| {
        let prime = PRIMES[joint % MAX_JOINTS];
        let mut index = sample;
        let mut part = 0.0;
        let mut digit = 1.0;
        while index > 0 {
            digit /= prime as f64;
            part += digit * (index % prime) as f64;
            index /= prime;
        }
        part
    })
}

/// A distance \[m\] that two placed bodies keep for certain: that of the balls around them.
pub(super) fn at_least(one: &Placed, other: &Placed) -> f64 {
    (one.centre - other.centre).norm() - one.around - other.around
}
