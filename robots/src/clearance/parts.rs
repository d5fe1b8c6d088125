//! What a clearance consists of, for planners: they plan with the bodies, pairs and margins that the guard checks.

use std::sync::Arc;

use mrroc::fault::Name;

use super::check::Clearance;
use super::obstacle::Obstacle;
use super::pairs::Other;
use super::posture::Shape;
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
    pub fn checked_pairs(&self) -> impl ExactSizeIterator<Item = CheckedPair> {
        self.pairs.iter().map(|pair| CheckedPair {
            robot: pair.limb.robot,
            link: pair.limb.link,
            partner: match pair.other {
                Other::Limb(limb) => Partner::Link(limb.robot, limb.link),
                Other::Obstacle(obstacle) => Partner::Obstacle(obstacle),
            },
            margin: pair.margin,
            since: pair.since,
        })
    }
}
