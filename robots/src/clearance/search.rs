//! The pair of bodies that has the least distance, or the least beyond its margin.
//!
//! In: robots that stand, and groups of pairs. Out: the pair with the least of
//!
//! ```text
//! distance,    or    distance - travel - margin,
//! ```
//!
//! of several with the same the first one by the order of [`Pair`], whatever was looked at first. So the pair that was nearest in the step before
//! may begin: most others are farther away than it is. Then parts of one capsule each are looked at, in their order, and after them those of many
//! capsules by their trees, those first that may be nearest.

use super::cover::ROUNDING;
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
    /// The group and the leaves of the pair that was nearest.
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
        let last = self.last.filter(|(number, _)| is_wanted(&groups[*number]));
        if let Some((number, leaves)) = last {
            look(number).place(robots, leaves);
            look(number).look_at(robots, leaves, &mut best);
        }
        let mut count = 0;
        for (number, group) in groups.iter().enumerate() {
            if !is_wanted(group) {
                continue;
            }
            if let Some(leaves) = group.single {
                // Most are excluded by the balls around them.
                if look(number).is_near(robots, leaves, best.least) && last != Some((number, leaves)) {
                    look(number).look_at(robots, leaves, &mut best);
                }
            } else if let Some(left) = look(number).at_least(robots, best.least) {
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
            self.last = Some((found.group, found.leaves));
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
    leaves: [usize; 2],
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

    /// Places two of its leaves.
    fn place(&self, robots: &mut [Placement], leaves: [usize; 2]) {
        let PartOf { robot, part } = self.group.part;
        robots[robot].place(part, leaves[0]);
        if let Partner::Part(PartOf { robot, part }) = self.group.other {
            robots[robot].place(part, leaves[1]);
        }
    }

    /// Whether the balls around two leaves that are placed have no more than `least` \[m\] left between them.
    #[inline(always)]
    fn is_near(&self, robots: &[Placement], leaves: [usize; 2], least: f64) -> bool {
        let Group { part, since, margin, .. } = self.group;
        let is_slack = self.purpose == Purpose::Slack;
        let one = robots[part.robot].placed(leaves[0]);
        match self.group.other {
            Partner::Part(other) => {
                let other = robots[other.robot].placed(leaves[1]);
                let taken = if is_slack { one.travel[*since] + other.travel[*since] + margin } else { 0.0 };
                let reach = least + one.around + other.around + taken;
                reach >= 0.0 && (one.centre - other.centre).norm_squared() <= reach * reach
            }
            Partner::Obstacle(o) => {
                let taken = one.around + if is_slack { one.travel[0] + margin } else { 0.0 };
                self.bodies[o].distance(&one.centre, least + taken + ROUNDING) - taken <= least
            }
        }
    }

    /// Looks at one of its pairs, by leaves that are placed.
    fn look_at(&self, robots: &[Placement], leaves: [usize; 2], best: &mut Best) {
        let one = Leaf::of(&robots[self.group.part.robot], leaves[0]);
        let found = match self.group.other {
            Partner::Part(PartOf { robot, .. }) => {
                Some(self.links(robot, one, Leaf::of(&robots[robot], leaves[1])))
            }
            Partner::Obstacle(o) => self.obstacle(o, one, best.least),
        };
        if let Some(found) = found {
            best.offer(found);
        }
    }

    #[inline]
    fn links(&self, robot: usize, one: Leaf<'_>, other: Leaf<'_>) -> Found {
        let limbs = [Limb { robot: self.group.part.robot, link: one.link }, Limb { robot, link: other.link }];
        let (pair, turned) = Pair::of(limbs[0], limbs[1]);
        let [a, b] = if turned { [other, one] } else { [one, other] };
        let gap = a.placed.capsule.gap(&b.placed.capsule);
        let Group { since, margin, .. } = self.group;
        let [travel, margin] = match self.purpose {
            Purpose::Slack => [a.placed.travel[*since] + b.placed.travel[*since], *margin],
            Purpose::Distance => [0.0; 2],
        };
        Found { group: self.number, leaves: [one.at, other.at], pair, gap, travel, margin }
    }

    /// Of a link and the obstacle, if what is left between them is not more than `least` \[m\].
    fn obstacle(&self, obstacle: usize, leaf: Leaf<'_>, least: f64) -> Option<Found> {
        let Leaf { at, link, placed } = leaf;
        let [travel, margin] = match self.purpose {
            Purpose::Slack => [placed.travel[0], self.group.margin],
            Purpose::Distance => [0.0; 2],
        };
        let most = least + travel + margin;
        // One that is as near counts if it is the first.
        let gap = self.bodies[obstacle].gap_below(&placed.capsule, most + most.abs() * 1e-12 + 1e-12)?;
        let limb = Limb { robot: self.group.part.robot, link };
        let pair = Pair { limb, other: Other::Obstacle(obstacle) };
        Some(Found { group: self.number, leaves: [at; 2], pair, gap, travel, margin })
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
