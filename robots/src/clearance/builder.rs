//! Puts a clearance together.

use std::sync::Arc;

use mrroc::fault::Name;
use mrroc::robot::MAX_JOINTS;

use super::check::{Clearance, Owned};
use super::error::ClearanceError;
use super::obstacle::Obstacle;
use super::placement::{MOTIONS, Placement};
use super::posture::{Joints, Stretch};
use super::search::Search;
use super::stopping::{Stop, Stopping};
use crate::models::{Capsule, DisabledPair, Outline};

/// A [`Clearance`] being put together.
#[must_use = "a clearance is made by build"]
pub struct ClearanceBuilder {
    clearance: Clearance,
    /// Bodies that are ignored by name, which must be known when it is built.
    named: Vec<Owned>,
    /// Bodies that robots will grasp.
    later: Vec<Owned>,
}

impl Clearance {
    /// A clearance whose bodies must keep `margin` \[m\], finite and >= 0, from one another: it covers the
    /// errors of the capsules and the drives. Links of one robot must only not meet: their margin is 0.
    pub fn with_margin(margin: f64) -> ClearanceBuilder {
        let stopping = Stopping { reaction: 0.0, stop: Stop::Braking };
        ClearanceBuilder {
            clearance: Clearance {
                robots: Vec::new(),
                names: Vec::new(),
                bodies: Vec::new(),
                from_robots: 0,
                margin,
                margins: Vec::new(),
                ignored: Vec::new(),
                ignored_own: Vec::new(),
                stopping,
                groups: Vec::new(),
                checked: 0,
                search: Search::default(),
                stopping_distances: Vec::new(),
                stretches: Vec::new(),
            },
            named: Vec::new(),
            later: Vec::new(),
        }
    }
}

impl ClearanceBuilder {
    /// Adds a robot under the name that it has in the cell, its base where it stands.
    ///
    /// # Errors
    /// [`ClearanceError::Name`], [`ClearanceError::SecondRobot`], [`ClearanceError::BadBody`] for a link without a radius above 0, [`ClearanceError::BadOutline`],
    /// [`ClearanceError::TooManyMotions`].
    pub fn robot(mut self, name: &str, outline: impl Outline) -> Result<Self, ClearanceError> {
        let robot = Name::new(name)?;
        if self.clearance.place_of(name).is_some() {
            return Err(ClearanceError::SecondRobot { robot });
        }
        let placement = Placement::new(robot, Arc::new(outline));
        let (shape, links) = (placement.shape(), placement.links.len());
        if shape.rigid().is_some_and(|rigid| rigid.len() != links) {
            return Err(ClearanceError::BadOutline { robot, links });
        }
        let mut motions = 0;
        shape.motions(&shape.between_limits(&|_| 0.5), &Joints::default(), &mut |_| motions += 1);
        if motions > MOTIONS {
            return Err(ClearanceError::TooManyMotions { robot, motions });
        }
        // Radii are the same in all postures.
        let mut radii = Vec::new();
        shape.capsules(&shape.between_limits(&|_| 0.5), &mut |capsule| radii.push(capsule.radius));
        let thin = radii.iter().zip(&placement.links).find(|(r, _)| !(r.is_finite() && **r > 0.0));
        if let Some((_, link)) = thin {
            return Err(ClearanceError::BadBody { body: format!("{robot} {}", link.name).into() });
        }
        self.clearance.robots.push(placement);
        Ok(self)
    }

    /// Fixes a tool to a robot's flange: capsules in the flange's frame F, called "tool".
    ///
    /// # Errors
    /// [`ClearanceError::NoRobot`], [`ClearanceError::BadBody`].
    pub fn tool(mut self, robot: &str, capsules: &[Capsule]) -> Result<Self, ClearanceError> {
        self.clearance.fix(robot, "tool", capsules)?;
        Ok(self)
    }

    /// Adds an obstacle that stands in the cell.
    ///
    /// # Errors
    /// [`ClearanceError::BadBody`].
    pub fn obstacle(mut self, name: &str, obstacle: Obstacle) -> Result<Self, ClearanceError> {
        let name: Arc<str> = name.into();
        if !obstacle.is_valid() {
            return Err(ClearanceError::BadBody { body: name });
        }
        self.clearance.names.push(name);
        self.clearance.bodies.push(obstacle);
        Ok(self)
    }

    /// Another margin \[m\] between two robots, a robot and an obstacle, or, `a` and `b` the same, the links of one robot.
    pub fn margin_between(mut self, a: &str, b: &str, margin: f64) -> Self {
        self.clearance.margins.push((a.into(), b.into(), margin));
        self
    }

    /// Two bodies, each a robot and its link, tool or body, that are not checked against one another: who holds the same
    /// body, what lies on the table. An obstacle stands for its own link: `("table", "table")`.
    pub fn ignore(mut self, a: (&str, &str), b: (&str, &str)) -> Self {
        let pair = [owned(a), owned(b)];
        self.named.extend_from_slice(&pair);
        self.clearance.ignored.push(pair);
        self
    }

    /// A body that this robot will [grasp](Clearance::grasp), so that [`ignore`](Self::ignore) may name it.
    pub fn will_grasp(mut self, robot: &str, body: &str) -> Self {
        self.later.push(owned((robot, body)));
        self
    }

    /// Pairs of links of a robot that an SRDF says not to check. Its links must have the names of the URDF; those without a shape are passed over.
    pub fn ignore_disabled(mut self, robot: &str, pairs: &[DisabledPair]) -> Self {
        let pairs =
            pairs.iter().map(|DisabledPair { links: [a, b], .. }| [owned((robot, a)), owned((robot, b))]);
        self.clearance.ignored.extend(pairs);
        self
    }

    /// The links of a robot, its tool and what it carries are not checked against one another: for an arm whose own limits
    /// keep them apart. RNT is such an arm: several joints move each of its bars, so the bounds for them are wide.
    pub fn ignore_own(mut self, robot: &str) -> Self {
        self.clearance.ignored_own.push(robot.into());
        self
    }

    /// The clearance, which checks the robots by where they would stand after such a stop.
    ///
    /// # Errors
    /// [`ClearanceError`]: margins, stopping, names in [`margin_between`](Self::margin_between) and in
    /// [`ignore`](Self::ignore).
    pub fn build(mut self, stopping: Stopping) -> Result<Clearance, ClearanceError> {
        let margins = self.clearance.margins.iter().map(|(_, _, margin)| *margin);
        for margin in margins.chain([self.clearance.margin]) {
            if !(margin.is_finite() && margin >= 0.0) {
                return Err(ClearanceError::BadMargin { margin });
            }
        }
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let sound = match stopping.stop {
            Stop::Braking => true,
            Stop::OnPath { rate_change, step } => positive(rate_change) && positive(step),
        };
        if !(sound && stopping.reaction.is_finite() && stopping.reaction >= 0.0) {
            return Err(ClearanceError::BadStopping);
        }
        let named = self.clearance.margins.iter().flat_map(|(a, b, _)| [a, b]);
        let owners = self.clearance.ignored.iter().flatten().map(|(owner, _)| owner);
        for owner in named.chain(owners).chain(&self.clearance.ignored_own) {
            let is_known = self.clearance.place_of(owner).is_some() || self.clearance.names.contains(owner);
            if !is_known {
                return Err(ClearanceError::NoRobot { robot: owner.clone() });
            }
        }
        for body in self.named.iter().filter(|body| !self.later.contains(body)) {
            self.known(body)?;
        }
        self.clearance.stopping = stopping;
        self.clearance.stopping_distances = vec![[0.0; MAX_JOINTS]; self.clearance.robots.len()];
        self.clearance.stretches = vec![Stretch::default(); self.clearance.robots.len()];
        self.clearance.pair();
        Ok(self.clearance)
    }

    /// Whether there is such a link, tool or obstacle.
    fn known(&self, (owner, link): &Owned) -> Result<(), ClearanceError> {
        let mut names: Vec<&Arc<str>> = match self.clearance.place_of(owner) {
            Some(robot) => self.clearance.robots[robot].links.iter().map(|link| &link.name).collect(),
            None => vec![owner],
        };
        if names.contains(&link) {
            return Ok(());
        }
        names.dedup();
        let known = names.iter().map(|name| &***name).collect::<Vec<_>>().join(", ");
        Err(ClearanceError::NoLink { owner: owner.clone(), link: link.clone(), known })
    }
}

fn owned((owner, link): (&str, &str)) -> Owned {
    (owner.into(), link.into())
}
