//! The pair of bodies that has the least distance, or the least beyond its margin.
//!
//! In: robots that stand, and groups of pairs. Out: the pair with the least of
//!
//! ```text
//! distance,    or    distance - travel - margin,
//! ```
//!
//! of several with the same the first one by the order of [`Pair`], whatever was looked at first. So the pair that was nearest in the step before
//! may begin: most others are farther away than it is. Parts of robots with many capsules are looked at by their trees, those first that
//! may be nearest.

use super::gap::Gap;
use super::near::{Beside, Between, Leaf, PartOf};
use super::obstacle::Obstacle;
use super::pairs::{Group, Limb, Other, Pair, Partner};
use super::placement::Placement;

/// Which distance is computed.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Purpose {
    /// The distance as it is.
    Distance,
    /// The distance less the stopping distance and the margin.
    Slack,
}

/// What a search looks at.
pub(super) struct World<'a> {
    pub(super) robots: &'a mut [Placement],
    pub(super) bodies: &'a [Obstacle],
    pub(super) groups: &'a [Group],
}

/// What a search needs to allocate nothing, and what the last one found.
#[derive(Clone, Default)]
pub(super) struct Search {
    /// Groups that are left to look at, with how much is left between their bodies at least.
    later: Vec<(f64, usize)>,
    /// The group and the links of the pair that was nearest.
    last: Option<(usize, [usize; 2])>,
}

impl Search {
    pub(super) fn among(groups: &[Group]) -> Self {
        Self { later: vec![(0.0, 0); groups.len()], last: None }
    }

    /// Where groups have changed their numbers.
    pub(super) fn forget(&mut self) {
        self.last = None;
    }

    /// Of the pairs of the wanted groups the one with the least left, if that is less than `least` \[m\].
    pub(super) fn least(
        &mut self,
        world: World<'_>,
        purpose: Purpose,
        is_wanted: impl Fn(&Group) -> bool,
        least: f64,
    ) -> Option<Found> {
        let World { robots, bodies, groups } = world;
        let look = |number: usize| Look { number, group: &groups[number], bodies, purpose };
        let mut best = Best { least, found: None };
        if let Some((group, links)) = self.last.filter(|(group, _)| is_wanted(&groups[*group])) {
            look(group).look_at(robots, links, &mut best);
        }
        let mut count = 0;
        for number in (0..groups.len()).filter(|number| is_wanted(&groups[*number])) {
            let look = look(number);
            if look.look_at_single(robots, &mut best) {
                continue;
            }
            if let Some(left) = look.at_least(robots, best.least) {
                self.later[count] = (left, number);
                count += 1;
            }
        }
        let later = &mut self.later[..count];
        later.sort_unstable_by(|(a, i), (b, j)| a.total_cmp(b).then(i.cmp(j)));
        for (left, number) in later {
            if *left > best.least {
                break;
            }
            look(*number).look(robots, best.least, &mut |found| best.offer(found));
        }
        if let Some(found) = &best.found {
            self.last = Some((found.group, found.links));
        }
        best.found
    }
}

/// The nearest pair so far.
struct Best {
    /// What is left between it, or the most that is looked for \[m\].
    least: f64,
    found: Option<Found>,
}

/// A pair, and what is taken off its distance.
pub(super) struct Found {
    group: usize,
    links: [usize; 2],
    pub(super) pair: Pair,
    pub(super) gap: Gap,
    pub(super) travel: f64,
    pub(super) margin: f64,
}

impl Best {
    /// Takes a pair that is nearer than the best so far; what is least then.
    fn offer(&mut self, found: Found) -> f64 {
        let left = found.gap.distance - (found.travel + found.margin);
        let is_first = || self.found.as_ref().is_some_and(|best| found.pair < best.pair);
        if left < self.least || (left == self.least && is_first()) {
            self.least = left;
            self.found = Some(found);
        }
        self.least
    }
}

/// A group that is looked at.
struct Look<'a> {
    number: usize,
    group: &'a Group,
    bodies: &'a [Obstacle],
    purpose: Purpose,
}

impl Look<'_> {
    fn between(&self, robots: &[Placement], other: PartOf) -> Between<'_> {
        let taken = (self.purpose == Purpose::Slack).then_some((self.group.since, self.group.margin));
        Between::new(robots, [self.group.part, other], taken, self.group.open())
    }

    fn beside(&self, obstacle: usize) -> Beside<'_> {
        let margin = (self.purpose == Purpose::Slack).then_some(self.group.margin);
        Beside { side: self.group.part, obstacle: &self.bodies[obstacle], margin, open: self.group.open() }
    }

    /// How much is left between its bodies at least \[m\], if it is not more than `least`.
    fn at_least(&self, robots: &mut [Placement], least: f64) -> Option<f64> {
        match self.group.other {
            Partner::Part(other) => {
                let left = self.between(robots, other).left(robots, least);
                Some(left).filter(|left| *left <= least && *left < f64::INFINITY)
            }
            Partner::Obstacle(o) => {
                let PartOf { robot, part } = self.group.part;
                let root = robots[robot].parts[part].nodes.start;
                self.beside(o).at_least(robots, root, least)
            }
        }
    }

    /// Looks at its pair, if it has one; whether it has.
    #[inline]
    fn look_at_single(&self, robots: &mut [Placement], best: &mut Best) -> bool {
        let root = |robots: &[Placement], PartOf { robot, part }: PartOf| {
            let nodes = &robots[robot].parts[part].nodes;
            (nodes.len() == 1).then_some(nodes.start)
        };
        let Some(at) = root(robots, self.group.part) else { return false };
        let link = robots[self.group.part.robot].nodes[at].link as usize;
        match self.group.other {
            Partner::Part(other) => {
                let Some(beside) = root(robots, other) else { return false };
                if self.group.open().is_none_or(|open| open.has(0, 0)) {
                    let beside = robots[other.robot].nodes[beside].link as usize;
                    self.look_at(robots, [link, beside], best);
                }
            }
            Partner::Obstacle(o) => {
                if self.beside(o).at_least(robots, at, best.least).is_some() {
                    self.look_at(robots, [link; 2], best);
                }
            }
        }
        true
    }

    /// Looks at all its pairs.
    fn look(&self, robots: &mut [Placement], least: f64, offer: &mut impl FnMut(Found) -> f64) {
        let PartOf { robot, part } = self.group.part;
        match self.group.other {
            Partner::Part(other) => {
                self.between(robots, other).visit(robots, least, &mut |one, another, _| {
                    let found = self.links(other.robot, one, another);
                    (found.gap, offer(found))
                });
            }
            Partner::Obstacle(o) => {
                let root = robots[robot].parts[part].nodes.start;
                self.beside(o).visit(robots, root, least, &mut |leaf, least| {
                    self.obstacle(o, leaf, least).map_or(least, &mut *offer)
                });
            }
        }
    }

    /// Looks at one of its pairs.
    fn look_at(&self, robots: &mut [Placement], links: [usize; 2], best: &mut Best) {
        let part = self.group.part;
        let leaf = |robot: &Placement, link: usize| robot.leaf(link);
        let at = leaf(&robots[part.robot], links[0]);
        robots[part.robot].place(part.part, at);
        match self.group.other {
            Partner::Part(other) => {
                let beside = leaf(&robots[other.robot], links[1]);
                robots[other.robot].place(other.part, beside);
                let leaves = [Leaf::of(&robots[part.robot], at), Leaf::of(&robots[other.robot], beside)];
                if self.balls_left(leaves) <= best.least {
                    best.offer(self.links(other.robot, leaves[0], leaves[1]));
                }
            }
            Partner::Obstacle(o) => {
                let leaf = Leaf::of(&robots[part.robot], at);
                if let Some(found) = self.obstacle(o, leaf, best.least) {
                    best.offer(found);
                }
            }
        }
    }

    /// How much is left between the balls around two capsules \[m\].
    #[inline]
    fn balls_left(&self, [one, other]: [Leaf<'_>; 2]) -> f64 {
        let Group { since, margin, .. } = self.group;
        let [a, b] = [one.placed, other.placed];
        let taken = match self.purpose {
            Purpose::Slack => a.travel[*since] + b.travel[*since] + margin,
            Purpose::Distance => 0.0,
        };
        (a.centre - b.centre).norm() - a.around - b.around - taken
    }

    #[inline]
    fn links(&self, robot: usize, one: Leaf<'_>, other: Leaf<'_>) -> Found {
        let Group { since, margin, part, .. } = self.group;
        let (links, [one, other]) = ([one.link, other.link], [one.placed, other.placed]);
        let limbs = [Limb { robot: part.robot, link: links[0] }, Limb { robot, link: links[1] }];
        let (pair, turned) = Pair::of(limbs[0], limbs[1]);
        let [a, b] = if turned { [other, one] } else { [one, other] };
        let gap = a.capsule.gap(&b.capsule);
        let [travel, margin] = match self.purpose {
            Purpose::Slack => [a.travel[*since] + b.travel[*since], *margin],
            Purpose::Distance => [0.0; 2],
        };
        Found { group: self.number, links, pair, gap, travel, margin }
    }

    /// Of a link and the obstacle, if what is left between them is not more than `least` \[m\].
    fn obstacle(&self, obstacle: usize, leaf: Leaf<'_>, least: f64) -> Option<Found> {
        let Leaf { link, placed, .. } = leaf;
        let [travel, margin] = match self.purpose {
            Purpose::Slack => [placed.travel[0], self.group.margin],
            Purpose::Distance => [0.0; 2],
        };
        let most = least + travel + margin;
        // One that is as near counts if it is the first.
        let gap = self.bodies[obstacle].gap_below(&placed.capsule, most + most.abs() * 1e-12 + 1e-12)?;
        let limb = Limb { robot: self.group.part.robot, link };
        let pair = Pair { limb, other: Other::Obstacle(obstacle) };
        Some(Found { group: self.number, links: [link; 2], pair, gap, travel, margin })
    }
}

/// All pairs of the groups that may be nearer than `within` \[m\], and their gaps.
pub(super) fn within(world: World<'_>, within: f64) -> Vec<(Pair, Gap)> {
    let World { robots, bodies, groups } = world;
    let mut near = Vec::new();
    for (number, group) in groups.iter().enumerate() {
        let look = Look { number, group, bodies, purpose: Purpose::Distance };
        if look.at_least(robots, within).is_some() {
            look.look(robots, within, &mut |found| {
                near.push((found.pair, found.gap));
                within
            });
        }
    }
    near
}
