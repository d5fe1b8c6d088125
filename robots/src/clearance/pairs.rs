//! Which bodies are checked against which.

use mrroc::random::halton;

use super::clusters::{Clusters, Group, Numbered};
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
/// a standstill, which knows no directions, would stop the robot for nothing. Pairs of two robots stay whatever they do, and so do
/// those with bodies that are not among the `obstacles`, which were robots.
pub(super) fn without_meaningless(
    pairs: &mut Vec<Pair>,
    robots: &mut [Placement],
    obstacles: &[Obstacle],
) -> Vec<(Pair, Unchecked)> {
    let mut seen = vec![Seen::default(); pairs.len()];
    for (robot, placement) in robots.iter_mut().enumerate() {
        // A pair that has been both apart and near stays: it needs no further posture.
        let mut open: Vec<usize> = Vec::new();
        let mut own: Vec<Numbered> = Vec::new();
        for (i, pair) in pairs.iter().enumerate().filter(|(_, pair)| pair.limb.robot == robot) {
            match pair.other {
                Other::Limb(limb) if limb.robot == robot => own.push((i, [pair.limb.link, limb.link])),
                Other::Obstacle(o) if o < obstacles.len() => open.push(i),
                Other::Limb(_) | Other::Obstacle(_) => {}
            }
        }
        // Of links that are covered by hundreds of capsules nearly all pairs are far apart, which clusters of them show.
        let mut groups: Option<(Clusters, Vec<Group>)> = None;
        let mut stood = 0;
        for sample in 1..=TRIES {
            let no_own = groups.as_ref().map_or(own.is_empty(), |(_, groups)| groups.is_empty());
            if stood == POSTURES || (open.is_empty() && no_own) {
                break;
            }
            let q = spread(placement, sample);
            if !placement.shape().is_possible(&q) || !placement.stand(&q, None) {
                continue;
            }
            stood += 1;
            let placed = &placement.placed;
            open.retain(|&i| {
                if let Other::Obstacle(o) = pairs[i].other {
                    seen[i].add(obstacles[o].gap(&placed[pairs[i].limb.link].capsule).distance);
                }
                // How near obstacles come does not matter.
                !seen[i].apart
            });
            let (clusters, groups) = groups.get_or_insert_with(|| {
                let clusters = Clusters::new(placement);
                let groups = clusters.groups(&own);
                (clusters, groups)
            });
            let around = clusters.around(placed);
            groups.retain_mut(|Group { sides, pairs: left, all_apart }| {
                let [(a, r), (b, s)] = sides.map(|side| around[side]);
                if (a - b).norm() - r - s > NEVER_NEARER {
                    if !core::mem::replace(all_apart, true) {
                        left.iter().for_each(|(i, _)| seen[*i].apart = true);
                    }
                    return true;
                }
                left.retain(|&(i, links)| {
                    let (seen, [one, other]) = (&mut seen[i], links.map(|link| &placed[link]));
                    // Most are far apart, which the balls around them show.
                    if at_least(one, other) > NEVER_NEARER {
                        seen.apart = true;
                    } else {
                        seen.add(one.capsule.gap(&other.capsule).distance);
                    }
                    !(seen.apart && seen.near)
                });
                !left.is_empty()
            });
        }
    }
    let mut removed = Vec::new();
    let mut seen = seen.into_iter();
    pairs.retain(|pair| {
        let why = match seen.next() {
            Some(Seen { overlapped: true, apart: false, .. }) => Some(Unchecked::AlwaysOverlap),
            Some(Seen { apart: true, near: false, .. }) if pair.is_own() => Some(Unchecked::NeverMeet),
            _ => None,
        };
        removed.extend(why.map(|why| (*pair, why)));
        why.is_none()
    });
    removed
}

/// How near two bodies came in the postures that were tried.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// They overlapped in one.
    overlapped: bool,
    /// They did not overlap in one.
    apart: bool,
    /// They were nearer than [`NEVER_NEARER`] in one.
    near: bool,
}

impl Seen {
    fn add(&mut self, distance: f64) {
        self.overlapped |= distance < 0.0;
        self.apart |= distance >= 0.0;
        self.near |= distance <= NEVER_NEARER;
    }
}

/// A posture of the Halton sequence: evenly spread, the same in every run.
fn spread(placement: &Placement, sample: usize) -> Joints {
    placement.shape().between_limits(&|joint| halton(sample, joint))
}

/// A distance \[m\] that two placed bodies keep for certain: that of the balls around them.
pub(super) fn at_least(one: &Placed, other: &Placed) -> f64 {
    (one.centre - other.centre).norm() - one.around - other.around
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use mrroc::fault::Name;
    use mrroc::random::Random;
    use nalgebra::Vector3;

    use super::*;
    use crate::Irp6;
    use crate::models::Capsule;

    #[test]
    fn clusters_leave_out_the_pairs_that_each_pair_alone_leaves_out_in_all_postures() {
        let mut arm = Placement::new(Name::new("arm").expect("a name"), Arc::new(Irp6::nominal()));
        let rank = arm.links.iter().map(|link| link.rank).max().expect("links") + 1;
        let mut random = Random::seeded(3);
        for _ in 0..100 {
            let mut point = |size: f64| Vector3::from_fn(|_, _| random.within(size));
            let end = point(0.4);
            let capsule = Capsule::new(end, end + point(0.05), 0.03);
            arm.carry(Link { name: "tool".into(), rank, moved_by: arm.shape().flange_motions() }, capsule);
        }
        let mut robots = [arm];
        let mut pairs = possible(&robots, 0);
        let mut seen = vec![Seen::default(); pairs.len()];
        let mut stood = 0;
        for sample in 1.. {
            let q = spread(&robots[0], sample);
            if !robots[0].shape().is_possible(&q) || !robots[0].stand(&q, None) {
                continue;
            }
            for (pair, seen) in pairs.iter().zip(&mut seen) {
                let Other::Limb(other) = pair.other else { panic!("no obstacles here") };
                let [one, other] = [pair.limb.link, other.link].map(|link| robots[0].placed[link].capsule);
                seen.add(one.gap(&other).distance);
            }
            stood += 1;
            if stood == POSTURES {
                break;
            }
        }
        let all = pairs.clone();
        let removed = without_meaningless(&mut pairs, &mut robots, &[]);
        let (mut overlap, mut apart) = (0, 0);
        for (pair, seen) in all.iter().zip(&seen) {
            let why = removed.iter().find(|(removed, _)| removed == pair).map(|(_, why)| *why);
            let expected = match seen {
                Seen { overlapped: true, apart: false, .. } => Some(Unchecked::AlwaysOverlap),
                Seen { apart: true, near: false, .. } => Some(Unchecked::NeverMeet),
                _ => None,
            };
            assert_eq!(why, expected, "{pair:?}");
            overlap += usize::from(why == Some(Unchecked::AlwaysOverlap));
            apart += usize::from(why == Some(Unchecked::NeverMeet));
        }
        assert_eq!(pairs.len() + removed.len(), all.len());
        assert!(apart > 20 && apart + overlap + 20 < all.len(), "{overlap} and {apart} of {}", all.len());
    }
}
