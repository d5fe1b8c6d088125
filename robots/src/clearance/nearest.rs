//! The nearest bodies of a clearance, by their names.
//!
//! In: robots that stand. Out: the pair that a [`Search`](super::search::Search) finds, with its links and points.

use super::check::Clearance;
use super::error::{CheckError, Nearest, Side};
use super::gap::Gap;
use super::pairs::{Group, Limb, Other, Pair};
use super::search::{self, Found, Purpose, World};

impl Clearance {
    /// The pair that has the least left beyond its margin.
    pub(super) fn least_slack(&mut self) -> Result<Nearest, CheckError> {
        let nearest = self.least(Purpose::Slack, |_| true, f64::INFINITY);
        nearest.ok_or(CheckError::NothingToCheck)
    }

    /// The pair with the least distance, links of one robot only where they overlap, or where there is nothing else.
    pub(super) fn least_distance(&mut self) -> Result<Nearest, CheckError> {
        let between = self.least(Purpose::Distance, |group| !group.is_own(), f64::INFINITY);
        let most = if between.is_some() { 0.0 } else { f64::INFINITY };
        let own = self.least(Purpose::Distance, Group::is_own, most);
        let nearest = match (between, own) {
            (Some(between), Some(own)) if between.distance <= own.distance => Some(between),
            (between, own) => own.or(between),
        };
        nearest.ok_or(CheckError::NothingToCheck)
    }

    /// Of the pairs of the wanted groups the one with the least left, if that is less than `least` \[m\].
    pub(super) fn least(
        &mut self,
        purpose: Purpose,
        is_wanted: impl Fn(&Group) -> bool,
        least: f64,
    ) -> Option<Nearest> {
        let world =
            World { robots: &mut self.robots, bodies: &self.bodies, groups: &self.groups[..self.checked] };
        let Found { pair, gap, travel, margin, .. } = self.search.least(world, purpose, is_wanted, least)?;
        Some(Nearest { distance: gap.distance, travel, margin, sides: self.sides(&pair, &gap) })
    }

    /// All pairs nearer than `within` \[m\] and their gaps, the nearest first.
    pub(super) fn within(&mut self, within: f64) -> Vec<(Pair, Gap)> {
        let world =
            World { robots: &mut self.robots, bodies: &self.bodies, groups: &self.groups[..self.checked] };
        let mut near = search::within(world, within);
        near.retain(|(_, gap)| gap.distance < within);
        near.sort_by(|(a, p), (b, q)| p.distance.total_cmp(&q.distance).then(a.cmp(b)));
        near
    }

    /// The gap of a pair; `None` where its robots have not stood.
    pub(super) fn gap(&self, pair: &Pair) -> Option<Gap> {
        let capsule = |limb: &Limb| self.robots[limb.robot].capsule(limb.link);
        let own = capsule(&pair.limb)?;
        Some(match &pair.other {
            Other::Limb(limb) => own.gap(&capsule(limb)?),
            Other::Obstacle(o) => self.bodies[*o].gap(&own),
        })
    }

    pub(super) fn sides(&self, pair: &Pair, gap: &Gap) -> [Side; 2] {
        let limb = |limb: &Limb, point| {
            let robot = &self.robots[limb.robot];
            Side { robot: Some(robot.name), link: robot.links[limb.link].name.clone(), point }
        };
        let other = match &pair.other {
            Other::Limb(other) => limb(other, gap.points[1]),
            Other::Obstacle(o) => Side { robot: None, link: self.names[*o].clone(), point: gap.points[1] },
        };
        [limb(&pair.limb, gap.points[0]), other]
    }
}

#[cfg(test)]
mod tests;
