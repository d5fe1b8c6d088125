//! The clearance of a cell: which of its bodies are nearest, and whether the robots can still stop in time.

use std::sync::Arc;

use mrroc::robot::{MAX_JOINTS, RobotView};

use super::error::{CheckError, ClearanceError, Nearest, TooClose};
use super::obstacle::Obstacle;
use super::pairs::{Group, Limb, Other, Pair, Unchecked, leave_out_meaningless, possible};
use super::placement::Placement;
use super::posture::{Joints, Stretch};
use super::search::Search;
use super::stopping::{Pace, Stopping};
use crate::models::{Capsule, Link};

/// A robot or obstacle, and which of its links.
pub(super) type Owned = (Arc<str>, Arc<str>);

/// Robots, what they carry and what stands around them; made by a [`ClearanceBuilder`](super::ClearanceBuilder).
///
/// A check takes a few microseconds, with large clouds some tens of them, with links of many hundred capsules a tenth of a millisecond, and
/// allocates nothing.
#[derive(Clone)]
pub struct Clearance {
    pub(super) robots: Vec<Placement>,
    pub(super) names: Vec<Arc<str>>,
    pub(super) bodies: Vec<Obstacle>,
    /// How many of the last bodies were links of robots.
    pub(super) from_robots: usize,
    pub(super) margin: f64,
    pub(super) margins: Vec<(Arc<str>, Arc<str>, f64)>,
    pub(super) ignored: Vec<[Owned; 2]>,
    pub(super) ignored_own: Vec<Arc<str>>,
    pub(super) stopping: Stopping,
    /// The groups of pairs of which some are checked, then the others.
    pub(super) groups: Vec<Group>,
    /// The number of those of which some are checked.
    pub(super) checked: usize,
    pub(super) search: Search,
    pub(super) stopping_distances: Vec<Joints>,
    pub(super) stretches: Vec<Stretch>,
}

impl Clearance {
    /// Checks that all pairs keep their margins where the robots would stand if they were stopped now, from their demanded
    /// positions and velocities. Returns the pair that has the least distance beyond its margin.
    ///
    /// `distance - travel >= margin`, with `travel` the sum of how far either body can get (see
    /// [the module](super)): a bound that is never too small, and usually larger than necessary. Where it is too large, the middle of what the
    /// joints may pass until they stand is looked at instead, from which they get half as far: a joint that moves fast does not turn round in a
    /// stop. What is returned then is of that middle.
    ///
    /// # Errors
    /// [`CheckError`]: too close; a robot without a state; joints that give no posture.
    pub fn check(&mut self, states: &[RobotView]) -> Result<Nearest, CheckError> {
        let mut pace = Pace::default();
        for robot in &self.robots {
            let state = state_of(states, robot)?;
            pace = pace.and(robot.shape().pace(&self.stopping, &state.demanded.velocity));
        }
        for (robot, distances) in self.robots.iter_mut().zip(&mut self.stopping_distances) {
            let state = &state_of(states, robot)?.demanded;
            *distances = robot.shape().stopping_distances(&self.stopping, &state.velocity, &pace);
            let robot_name = robot.name;
            if !robot.stand(&state.joints, Some(distances)) {
                return Err(CheckError::NoPosture { robot: robot_name });
            }
        }
        let nearest = self.least_slack()?;
        if nearest.slack() >= 0.0 {
            return Ok(nearest);
        }
        let ahead = self.check_ahead(states, &pace)?;
        self.stand_at(states)?;
        ahead.ok_or_else(|| TooClose(nearest).into())
    }

    /// The check from the middle of what the joints may pass until they stand; `None` where it is not passed.
    fn check_ahead(&mut self, states: &[RobotView], pace: &Pace) -> Result<Option<Nearest>, CheckError> {
        for (robot, distances) in self.robots.iter_mut().zip(&self.stopping_distances) {
            let state = &state_of(states, robot)?.demanded;
            let back = robot.shape().backwards(&self.stopping, &state.velocity, distances, pace);
            let mut middle = state.joints;
            let mut half = *distances;
            for i in 0..middle.len() {
                middle[i] += 0.5 * (distances[i] - back[i]) * state.velocity[i].signum();
                half[i] = 0.5 * (distances[i] + back[i]);
            }
            // Joints that share limits may not be able to stand there.
            if !robot.stand(&middle, Some(&half)) {
                return Ok(None);
            }
        }
        Ok(Some(self.least_slack()?).filter(|nearest| nearest.slack() >= 0.0))
    }

    /// Stands all robots at the demanded positions.
    fn stand_at(&mut self, states: &[RobotView]) -> Result<(), CheckError> {
        for robot in &mut self.robots {
            let joints = state_of(states, robot)?.demanded.joints;
            let robot_name = robot.name;
            if !robot.stand(&joints, None) {
                return Err(CheckError::NoPosture { robot: robot_name });
            }
        }
        Ok(())
    }

    /// The two bodies that are nearest to one another at the demanded positions, whatever the margins and velocities. Links
    /// of one robot count where they overlap, or where there is nothing else.
    ///
    /// # Errors
    /// [`CheckError`] except [`CheckError::TooClose`].
    pub fn nearest(&mut self, states: &[RobotView]) -> Result<Nearest, CheckError> {
        self.stand_at(states)?;
        self.least_distance()
    }

    /// As [`nearest`](Clearance::nearest), of joint positions [rad or m] of the robots in the order in which they were added.
    ///
    /// # Errors
    /// [`CheckError`] except [`CheckError::TooClose`].
    pub fn nearest_at(&mut self, positions: &[&[f64]]) -> Result<Nearest, CheckError> {
        self.nearest_of(|robot| positions.get(robot).copied())
    }

    pub(super) fn nearest_of<'a>(
        &mut self,
        joints_of: impl Fn(usize) -> Option<&'a [f64]>,
    ) -> Result<Nearest, CheckError> {
        self.place_at(joints_of)?;
        self.least_distance()
    }

    /// Stands all robots at joint positions [rad or m].
    pub(super) fn place_at<'a>(
        &mut self,
        joints_of: impl Fn(usize) -> Option<&'a [f64]>,
    ) -> Result<(), CheckError> {
        for (i, robot) in self.robots.iter_mut().enumerate() {
            let mut joints = [0.0; MAX_JOINTS];
            let robot_name = robot.name;
            let given = joints_of(i).ok_or(CheckError::Missing { robot: robot_name })?;
            joints.iter_mut().zip(given).for_each(|(place, value)| *place = *value);
            if !robot.stand(&joints, None) {
                return Err(CheckError::NoPosture { robot: robot_name });
            }
        }
        Ok(())
    }

    /// Fixes a body to a robot's flange: capsules in the flange's frame F. It is checked against everything but what is
    /// rigidly joined to it. When the clearance is built, exclude what the body lies on and who else holds it
    /// ([`ClearanceBuilder::ignore`](super::ClearanceBuilder::ignore)). It allocates: call it between motions.
    ///
    /// # Errors
    /// [`ClearanceError::NoRobot`], [`ClearanceError::BadBody`].
    pub fn grasp(&mut self, robot: &str, body: &str, capsules: &[Capsule]) -> Result<(), ClearanceError> {
        self.fix(robot, body, capsules)?;
        self.pair();
        Ok(())
    }

    /// Takes a body off a robot's flange again.
    ///
    /// # Errors
    /// [`ClearanceError::NoRobot`], [`ClearanceError::NoLink`].
    pub fn release(&mut self, robot: &str, body: &str) -> Result<(), ClearanceError> {
        let found = self.robot_mut(robot)?;
        if !found.drop_carried(body) {
            let carried = found.links[found.own()..].iter().map(|link| link.name.to_string());
            let known = carried.collect::<Vec<_>>().join(", ");
            return Err(ClearanceError::NoLink { owner: robot.into(), link: body.into(), known });
        }
        self.pair();
        Ok(())
    }

    /// How the robots stop.
    #[must_use]
    pub const fn stopping(&self) -> &Stopping {
        &self.stopping
    }

    /// Number of pairs that are checked.
    #[must_use]
    pub fn pairs(&self) -> usize {
        let pairs = self.checked().iter().flat_map(|group| group.pairs(&self.robots));
        pairs.filter(|(_, is_checked)| *is_checked).count()
    }

    /// The pairs that are not checked because they overlap in all postures or, being links of one robot, never meet, in
    /// 2000 postures spread over the joints' ranges. As text: `"irp6 postument - table: always overlap"`.
    pub fn unchecked(&self) -> impl Iterator<Item = String> + '_ {
        let unchecked = self.groups.iter().flat_map(|group| group.unchecked(&self.robots));
        unchecked.map(|(pair, why)| {
            let [(a, link_a), (b, link_b)] = self.owners(&pair);
            let why = match why {
                Unchecked::AlwaysOverlap => "always overlap",
                Unchecked::NeverMeet => "never meet",
            };
            let obstacle = matches!(pair.other, Other::Obstacle(_));
            if obstacle {
                format!("{a} {link_a} - {b}: {why}")
            } else {
                format!("{a} {link_a} - {b} {link_b}: {why}")
            }
        })
    }

    /// Visits the capsules of all robots, and of what they carry, where they stood in the last check: for pictures.
    pub fn capsules(&self, visit: &mut dyn FnMut(&str, &Link, &Capsule)) {
        for robot in &self.robots {
            for (i, link) in robot.links.iter().enumerate() {
                if let Some(capsule) = robot.capsule(i) {
                    visit(robot.name.as_str(), link, &capsule);
                }
            }
        }
    }

    /// Number of robots.
    pub(super) fn robot_count(&self) -> usize {
        self.robots.len()
    }

    /// The place of a robot in the order in which they were added.
    pub(super) fn place_of(&self, robot: &str) -> Option<usize> {
        self.robots.iter().position(|known| known.name.as_str() == robot)
    }

    pub(super) fn robot_mut(&mut self, robot: &str) -> Result<&mut Placement, ClearanceError> {
        let found = self.robots.iter_mut().find(|known| known.name.as_str() == robot);
        found.ok_or_else(|| ClearanceError::NoRobot { robot: robot.into() })
    }

    pub(super) fn fix(
        &mut self,
        robot: &str,
        body: &str,
        capsules: &[Capsule],
    ) -> Result<(), ClearanceError> {
        let name: Arc<str> = body.into();
        if !capsules.iter().all(Capsule::is_valid) {
            return Err(ClearanceError::BadBody { body: name });
        }
        let found = self.robot_mut(robot)?;
        let rank = found.links[..found.own()].iter().map(|link| link.rank).max().unwrap_or_default() + 1;
        let moved_by = found.shape().flange_motions();
        found.carry(&Link { name, rank, moved_by }, capsules);
        Ok(())
    }

    /// The groups of which pairs are checked.
    pub(super) fn checked(&self) -> &[Group] {
        &self.groups[..self.checked]
    }

    /// Finds the pairs to be checked.
    pub(super) fn pair(&mut self) {
        let mut groups = possible(&self.robots, self.bodies.len());
        groups.retain(|group| !self.is_ignored(group));
        for group in &mut groups {
            let [(a, _), (b, _)] = self.owners(&group.first(&self.robots));
            let between = |(x, y): (&str, &str)| (x, y) == (&*a, &*b) || (y, x) == (&*a, &*b);
            let special = self.margins.iter().rev().find(|(x, y, _)| between((x, y)));
            // Links of one robot have no margin, unless one was stated for them.
            let usual = if a == b { 0.0 } else { self.margin };
            group.margin = special.map_or(usual, |(_, _, margin)| *margin);
        }
        let fixed = self.bodies.len() - self.from_robots;
        leave_out_meaningless(&mut groups, &mut self.robots, &self.bodies[..fixed]);
        self.set_groups(groups);
    }

    pub(super) fn set_groups(&mut self, mut groups: Vec<Group>) {
        groups.iter_mut().for_each(|group| group.find_single(&self.robots));
        groups.sort_by_key(|group| !group.is_checked());
        self.checked = groups.iter().filter(|group| group.is_checked()).count();
        self.search = Search::among(&groups);
        self.groups = groups;
    }

    fn is_ignored(&self, group: &Group) -> bool {
        let owners = self.owners(&group.first(&self.robots));
        let is_own = group.is_own() && self.ignored_own.contains(&owners[0].0);
        let is_pair = |[a, b]: &[Owned; 2]| {
            (*a == owners[0] && *b == owners[1]) || (*a == owners[1] && *b == owners[0])
        };
        is_own || self.ignored.iter().any(is_pair)
    }

    /// Both bodies by name; an obstacle is its own link.
    fn owners(&self, pair: &Pair) -> [Owned; 2] {
        let limb = |limb: &Limb| {
            let robot = &self.robots[limb.robot];
            (robot.name.as_str().into(), robot.links[limb.link].name.clone())
        };
        let other = match &pair.other {
            Other::Limb(other) => limb(other),
            Other::Obstacle(o) => (self.names[*o].clone(), self.names[*o].clone()),
        };
        [limb(&pair.limb), other]
    }
}

fn state_of<'a>(states: &'a [RobotView], robot: &Placement) -> Result<&'a RobotView, CheckError> {
    states.iter().find(|state| state.name == robot.name).ok_or(CheckError::Missing { robot: robot.name })
}
