//! What a clearance consists of, for planners: they plan with the bodies, pairs and margins that the guard checks.

use std::sync::Arc;

use mrroc::fault::Name;

use super::check::Clearance;
use super::obstacle::Obstacle;
use super::pairs::{Group, Other, Pair};
use super::placement::travel;
use super::posture::{Joints, Shape};
use crate::models::{Capsule, Link};

/// A robot of a clearance.
#[derive(Clone)]
pub struct RobotPart {
    /// Its name in the cell.
    pub name: Name,
    /// Its shape.
    pub shape: Arc<dyn Shape>,
    /// Its own links, then those of what it carries.
    pub links: Vec<Link>,
    /// What it carries, in the flange's frame: the capsules of the last links.
    pub carried: Vec<Capsule>,
}

impl RobotPart {
    /// The capsules of all links at `q` [rad or m], in the world; `None` where the robot cannot stand so.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn capsules(&self, q: &Joints) -> Option<Vec<Capsule>> {
        let mut capsules = Vec::with_capacity(self.links.len());
        self.shape.capsules(q, &mut |capsule| capsules.push(capsule));
        if capsules.len() + self.carried.len() != self.links.len() {
            return None;
        }
        if !self.carried.is_empty() {
            let X_WF = self.shape.flange(q);
            capsules.extend(self.carried.iter().map(|capsule| capsule.moved(&X_WF)));
        }
        Some(capsules)
    }

    /// Visits, for each link, a capsule that holds all that the link may pass through while each joint is within `half` of `q`
    /// [rad or m, >= 0], in the world; and by how much its radius is larger than that of the link \[m\]. `false`, with nothing visited,
    /// where the robot cannot stand at `q`.
    pub fn around(&self, q: &Joints, half: &Joints, visit: &mut dyn FnMut(usize, Capsule, f64)) -> bool {
        let Some(capsules) = self.capsules(q) else { return false };
        let mut motions = Vec::new();
        self.shape.motions(q, half, &mut |motion| motions.push(motion));
        for (i, (link, capsule)) in self.links.iter().zip(capsules).enumerate() {
            let more = travel(link.moved_by, &capsule, &motions)[0];
            visit(i, Capsule { radius: capsule.radius + more, ..capsule }, more);
        }
        true
    }
}

/// The other side of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partner {
    /// A link of a robot, by their numbers.
    Link(usize, usize),
    /// An obstacle, by its number.
    Obstacle(usize),
}

/// Two bodies that are checked against one another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckedPair {
    /// The robot, by its number.
    pub robot: usize,
    /// Its link, by its number.
    pub link: usize,
    /// What is kept apart from it.
    pub partner: Partner,
    /// By how much at least \[m\], >= 0.
    pub margin: f64,
    /// The first motion that moves one of them alone.
    pub since: usize,
}

impl Clearance {
    /// The robots, in the order in which they were added.
    #[must_use]
    pub fn robot_parts(&self) -> Vec<RobotPart> {
        let parts = self.robots.iter().map(|robot| RobotPart {
            name: robot.name,
            shape: Arc::clone(robot.shape()),
            links: robot.links.clone(),
            carried: robot.carried().to_vec(),
        });
        parts.collect()
    }

    /// The obstacles and their names, in the order in which they were added.
    pub fn obstacle_parts(&self) -> impl ExactSizeIterator<Item = (&Arc<str>, &Obstacle)> {
        self.names.iter().zip(&self.bodies)
    }

    /// The pairs that are checked.
    pub fn checked_pairs(&self) -> impl Iterator<Item = CheckedPair> {
        let of = |group: &Group, pair: Pair| CheckedPair {
            robot: pair.limb.robot,
            link: pair.limb.link,
            partner: match pair.other {
                Other::Limb(limb) => Partner::Link(limb.robot, limb.link),
                Other::Obstacle(obstacle) => Partner::Obstacle(obstacle),
            },
            margin: group.margin,
            since: group.since,
        };
        self.checked().iter().flat_map(move |group| {
            let pairs = group.pairs(&self.robots).filter(|(_, is_checked)| *is_checked);
            pairs.map(move |(pair, _)| of(group, pair))
        })
    }
}
