//! Which bodies are checked against which.

use std::cell::Cell;
use std::sync::Arc;

use mrroc::random::halton;

use super::bits::Bits;
use super::near::{Between, PartOf};
use super::obstacle::Obstacle;
use super::placement::Placement;
use super::posture::Joints;
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Limb {
    pub(super) robot: usize,
    pub(super) link: usize,
}

/// The other side of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Other {
    Limb(Limb),
    Obstacle(usize),
}

/// Two bodies that are checked against one another. Of those that are equally near the first one counts as the nearest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Pair {
    pub(super) limb: Limb,
    pub(super) other: Other,
}

impl Pair {
    /// Of two links, the first one of one robot first; whether they have changed sides.
    pub(super) fn of(one: Limb, other: Limb) -> (Self, bool) {
        let turned = one > other;
        let [limb, other] = if turned { [other, one] } else { [one, other] };
        (Self { limb, other: Other::Limb(other) }, turned)
    }
}

/// The other side of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Partner {
    Part(PartOf),
    Obstacle(usize),
}

/// The pairs of the links of a part with those of another one, or with an obstacle.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub(super) part: PartOf,
    pub(super) other: Partner,
    /// The first motion that moves one of them alone: those before move both alike.
    pub(super) since: usize,
    pub(super) margin: f64,
    /// Where there is one pair, the places of its leaves among the nodes of their robots; with an obstacle twice that of the link.
    pub(super) single: Option<[usize; 2]>,
    /// Which of the pairs are checked; `None`: all.
    open: Option<Arc<Bits>>,
    /// All are checked nevertheless: another obstacle stands in the place of the one for which that was found.
    is_replaced: bool,
    /// The links of those of one robot that are not checked because they always overlap, in order.
    overlapping: Arc<[[usize; 2]]>,
}

impl Group {
    pub(super) fn new(part: PartOf, other: Partner, since: usize) -> Self {
        let overlapping = Arc::new([]);
        Self { part, other, since, margin: 0.0, single: None, open: None, is_replaced: false, overlapping }
    }

    /// The same pairs, of parts that have other numbers.
    pub(super) fn between(&self, part: PartOf, other: Partner) -> Self {
        Self { part, other, ..self.clone() }
    }

    /// Finds whether it has one pair, and of which leaves.
    pub(super) fn find_single(&mut self, robots: &[Placement]) {
        let leaf = |PartOf { robot, part }: PartOf| {
            let nodes = &robots[robot].parts[part].nodes;
            (nodes.len() == 1).then_some(nodes.start)
        };
        let one = leaf(self.part);
        let other = if let Partner::Part(other) = self.other { leaf(other) } else { one };
        self.single = one.zip(other).map(<[usize; 2]>::from);
    }

    /// One of its pairs, which has the names and the rank of all.
    pub(super) fn first(&self, robots: &[Placement]) -> Pair {
        let limb = |PartOf { robot, part }: PartOf| Limb { robot, link: robots[robot].parts[part].link };
        match self.other {
            Partner::Part(other) => Pair::of(limb(self.part), limb(other)).0,
            Partner::Obstacle(o) => Pair { limb: limb(self.part), other: Other::Obstacle(o) },
        }
    }

    /// Whether both are parts of one robot.
    pub(super) fn is_own(&self) -> bool {
        matches!(self.other, Partner::Part(other) if other.robot == self.part.robot)
    }

    /// Which of its pairs are checked; `None`: all.
    pub(super) fn open(&self) -> Option<&Bits> {
        self.open.as_deref().filter(|_| !self.is_replaced)
    }

    /// Whether any of its pairs is checked.
    pub(super) fn is_checked(&self) -> bool {
        self.open().is_none_or(|open| open.has(0, 0))
    }

    /// Checks all its pairs from now on.
    pub(super) fn check_all(&mut self) {
        self.is_replaced = true;
    }

    /// All its pairs, each with whether it is checked.
    pub(super) fn pairs<'a>(&'a self, robots: &'a [Placement]) -> impl Iterator<Item = (Pair, bool)> + 'a {
        let of = |PartOf { robot, part }: PartOf| {
            let robot = &robots[robot];
            let nodes = robot.parts[part].nodes.clone();
            let first = nodes.start;
            nodes.filter(|at| robot.nodes[*at].is_leaf()).map(move |at| (at - first, robot.nodes[at].link))
        };
        let limb = |robot, link| Limb { robot, link: link as usize };
        of(self.part).flat_map(move |(at, link)| {
            let one = limb(self.part.robot, link);
            let (parts, obstacle) = match self.other {
                Partner::Part(other) => (Some(other), None),
                Partner::Obstacle(o) => (None, Some((Pair { limb: one, other: Other::Obstacle(o) }, 0))),
            };
            let limbs = parts.into_iter().flat_map(move |other| {
                of(other).map(move |(at, link)| (Pair::of(one, limb(other.robot, link)).0, at))
            });
            limbs
                .chain(obstacle)
                .map(move |(pair, other)| (pair, self.open().is_none_or(|open| open.has(at, other))))
        })
    }

    /// Its pairs that are not checked because a check would mean nothing.
    pub(super) fn unchecked<'a>(
        &'a self,
        robots: &'a [Placement],
    ) -> impl Iterator<Item = (Pair, Unchecked)> + 'a {
        let pairs = self.pairs(robots).filter(|(_, is_checked)| !is_checked);
        pairs.map(|(pair, _)| {
            let overlaps = match pair.other {
                Other::Limb(other) => self.overlapping.binary_search(&[pair.limb.link, other.link]).is_ok(),
                Other::Obstacle(_) => true,
            };
            (pair, if overlaps { Unchecked::AlwaysOverlap } else { Unchecked::NeverMeet })
        })
    }
}

/// The first motion that moves only one of two links of a robot; `None` when none does.
fn first_apart(a: &Link, b: &Link) -> Option<usize> {
    let apart = a.moved_by ^ b.moved_by;
    (apart != 0).then_some(apart.trailing_zeros() as usize)
}

/// All pairs that can meet: links of different robots, links and obstacles, links of one robot that no joint connects.
pub(super) fn possible(robots: &[Placement], obstacles: usize) -> Vec<Group> {
    let mut groups = Vec::new();
    for (robot, one) in robots.iter().enumerate() {
        for (i, part) in one.parts.iter().enumerate() {
            let (here, link) = (PartOf { robot, part: i }, &one.links[part.link]);
            for (j, behind) in one.parts.iter().enumerate().skip(i + 1) {
                let behind = &one.links[behind.link];
                let connected = link.rank.abs_diff(behind.rank) < 2;
                if let Some(since) = first_apart(link, behind).filter(|_| !connected) {
                    groups.push(Group::new(here, Partner::Part(PartOf { robot, part: j }), since));
                }
            }
            for (robot, another) in robots.iter().enumerate().skip(robot + 1) {
                let parts = (0..another.parts.len()).map(|part| PartOf { robot, part });
                groups.extend(parts.map(|part| Group::new(here, Partner::Part(part), 0)));
            }
            groups.extend((0..obstacles).map(|o| Group::new(here, Partner::Obstacle(o), 0)));
        }
    }
    groups
}

/// Leaves out pairs of which a check would mean nothing, as 2000 postures spread over the joints' ranges show.
///
/// Those of a robot with itself or with obstacles that overlap in all postures: what is mounted there, or modelled too
/// stout. And links of one robot that stay 10 mm apart in all of them, such as cranks in planes side by side: the way to
/// a standstill, which knows no directions, would stop the robot for nothing. Pairs of two robots stay whatever they do, and so do
/// those with bodies that are not among the `obstacles`, which were robots.
pub(super) fn leave_out_meaningless(groups: &mut [Group], robots: &mut [Placement], obstacles: &[Obstacle]) {
    for robot in 0..robots.len() {
        let mut own: Vec<(usize, Seen)> = Vec::new();
        // What has been apart from an obstacle is checked: it needs no further posture.
        let mut overlapping: Vec<(usize, Vec<usize>)> = Vec::new();
        for (g, group) in groups.iter().enumerate().filter(|(_, group)| group.part.robot == robot) {
            match group.other {
                Partner::Part(other) if other.robot == robot => own.push((g, Seen::of(group, other, robots))),
                Partner::Obstacle(o) if o < obstacles.len() => {
                    let links = group.pairs(robots).map(|(pair, _)| pair.limb.link).collect();
                    overlapping.push((g, links));
                }
                Partner::Part(_) | Partner::Obstacle(_) => {}
            }
        }
        let mut stood = 0;
        for sample in 1..=TRIES {
            if stood == POSTURES || (own.is_empty() && overlapping.is_empty()) {
                break;
            }
            let placement = &mut robots[robot];
            let q = spread(placement, sample);
            if !placement.shape().is_possible(&q) || !placement.stand(&q, None) {
                continue;
            }
            stood += 1;
            overlapping.retain_mut(|(g, links)| {
                if let Partner::Obstacle(o) = groups[*g].other {
                    let overlaps = |link: &usize| {
                        let capsule = placement.capsule(*link);
                        capsule.is_none_or(|capsule| obstacles[o].gap(&capsule).distance < 0.0)
                    };
                    // How near obstacles come does not matter.
                    links.retain(overlaps);
                }
                !links.is_empty()
            });
            for (g, seen) in &mut own {
                seen.look(&groups[*g], robots);
            }
        }
        if stood == 0 {
            continue;
        }
        for (g, links) in overlapping {
            let Group { part, open, .. } = &mut groups[g];
            let placement = &robots[robot];
            let nodes = &placement.nodes[placement.parts[part.part].nodes.clone()];
            let is_checked = |link: u32, _| !links.contains(&(link as usize));
            *open = Some(Arc::new(Bits::of(nodes, &nodes[nodes.len() - 1..], is_checked)));
        }
        for (g, seen) in own {
            seen.leave_out(&mut groups[g], robots, stood);
        }
    }
}

/// How near the links of two parts of a robot came in the postures that were tried.
struct Seen {
    /// The place of the root of each part, and how many nodes the second one has.
    roots: [usize; 2],
    width: usize,
    /// In how many postures each pair overlapped, with [`NEAR`] where it was nearer than [`NEVER_NEARER`] in one; by their leaves.
    pairs: Vec<u16>,
}

const NEAR: u16 = 1 << 15;

impl Seen {
    fn of(group: &Group, other: PartOf, robots: &[Placement]) -> Self {
        let parts = &robots[group.part.robot].parts;
        let nodes = [&parts[group.part.part].nodes, &parts[other.part].nodes];
        let [height, width] = nodes.map(|nodes| nodes.len());
        Self { roots: nodes.map(|nodes| nodes.start), width, pairs: vec![0; width * height] }
    }

    /// The number of a pair of links among the pairs.
    fn at(&self, robot: &Placement, one: usize, other: usize) -> usize {
        (robot.leaf(one) - self.roots[0]) * self.width + robot.leaf(other) - self.roots[1]
    }

    /// Looks at the pairs in one more posture.
    fn look(&mut self, group: &Group, robots: &mut [Placement]) {
        let Partner::Part(other) = group.other else { return };
        let mut between = Between::new(robots, [group.part, other], None, None);
        if between.left(robots, NEVER_NEARER) > NEVER_NEARER {
            return;
        }
        let Self { roots, width, pairs } = self;
        between.visit(robots, NEVER_NEARER, &mut |one, other, least| {
            let gap = one.placed.capsule.gap(&other.placed.capsule);
            if gap.distance <= NEVER_NEARER {
                let seen = &mut pairs[(one.at - roots[0]) * *width + other.at - roots[1]];
                *seen = (*seen | NEAR) + u16::from(gap.distance < 0.0);
            }
            (gap, least)
        });
    }

    fn leave_out(&self, group: &mut Group, robots: &[Placement], postures: usize) {
        let Partner::Part(other) = group.other else { return };
        let overlaps = |seen: u16| usize::from(seen & !NEAR) == postures;
        let is_checked = |seen: u16| seen & NEAR != 0 && !overlaps(seen);
        let robot = &robots[group.part.robot];
        let nodes = |part: usize| &robot.nodes[robot.parts[part].nodes.clone()];
        let of = |a: u32, b: u32| self.pairs[self.at(robot, a as usize, b as usize)];
        let is_whole = Cell::new(true);
        let open = Bits::of(nodes(group.part.part), nodes(other.part), |a, b| {
            let is_checked = is_checked(of(a, b));
            is_whole.set(is_whole.get() && is_checked);
            is_checked
        });
        if is_whole.get() {
            return;
        }
        let links = group.pairs(robots).filter_map(|(pair, _)| match pair.other {
            Other::Limb(other) => Some([pair.limb.link, other.link]),
            Other::Obstacle(_) => None,
        });
        // Pairs are in the order of links, which that of the parts need not be.
        let mut overlapping: Vec<[usize; 2]> = links
            .filter(|&[a, b]| {
                let [a, b] = if robot.part_of(a) == group.part.part { [a, b] } else { [b, a] };
                overlaps(self.pairs[self.at(robot, a, b)])
            })
            .collect();
        overlapping.sort_unstable();
        (group.open, group.overlapping) = (Some(Arc::new(open)), overlapping.into());
    }
}

/// A posture of the Halton sequence: evenly spread, the same in every run.
fn spread(placement: &Placement, sample: usize) -> Joints {
    placement.shape().between_limits(&|joint| halton(sample, joint))
}

#[cfg(test)]
mod tests;
