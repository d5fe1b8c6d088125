//! A robot of a clearance as obstacles: where it stands, or all that it may pass through.

use std::sync::Arc;

use super::check::Clearance;
use super::error::ClearanceError;
use super::near::PartOf;
use super::obstacle::{Bodies, Obstacle};
use super::pairs::{Group, Partner};
use crate::models::Capsule;

impl Clearance {
    /// The same clearance, in which a robot is no robot any more. Instead there is an obstacle for each of its links, called by the robot's
    /// name and the link's, of those of the `capsules` (in the world) that are given with the number of the link in
    /// [`RobotPart::links`](super::RobotPart::links); of links that are called alike there is one. The other robots keep the margins to it
    /// that they keep to the link, and pairs that are not checked stay so. A link without capsules is not there.
    ///
    /// # Errors
    /// [`ClearanceError::NoRobot`]; [`ClearanceError::BadBody`]: a capsule that is not finite, or too many of a link.
    pub fn with_robot_as_obstacles(
        &self,
        robot: &str,
        capsules: &[(usize, Capsule)],
    ) -> Result<Clearance, ClearanceError> {
        let gone = self.place_of(robot).ok_or_else(|| ClearanceError::NoRobot { robot: robot.into() })?;
        let mut clearance = self.clone();
        let Clearance { robots, names, bodies, from_robots, .. } = &mut clearance;
        let links = robots.remove(gone).links;
        // The obstacle that each link is now.
        let mut places: Vec<Option<usize>> = vec![None; links.len()];
        for (i, link) in links.iter().enumerate() {
            let first = links.iter().position(|other| other.name == link.name).unwrap_or(i);
            if first < i {
                places[i] = places[first];
                continue;
            }
            let is_of = |at: usize| links.get(at).is_some_and(|other| other.name == link.name);
            let own: Vec<Capsule> =
                capsules.iter().filter(|(at, _)| is_of(*at)).map(|(_, capsule)| *capsule).collect();
            if own.is_empty() {
                continue;
            }
            let name: Arc<str> = format!("{robot} {}", link.name).into();
            let bad = |_| ClearanceError::BadBody { body: Arc::clone(&name) };
            let body = Obstacle::Bodies(Arc::new(Bodies::new(&own).map_err(bad)?));
            places[i] = Some(bodies.len());
            names.push(name);
            bodies.push(body);
            *from_robots += 1;
        }
        let new_names: Vec<(Arc<str>, Arc<str>)> = links
            .iter()
            .zip(&places)
            .filter_map(|(link, place)| Some((Arc::clone(&link.name), Arc::clone(&names[(*place)?]))))
            .collect();
        clearance.rename(robot, &new_names);
        let gone_part = |part: PartOf| places[self.robots[gone].parts[part.part].link];
        let kept = |part: PartOf| PartOf { robot: part.robot - usize::from(part.robot > gone), ..part };
        let moved = |group: &Group| -> Option<Group> {
            let (part, other) = match group.other {
                Partner::Part(other) if group.is_own() => {
                    (group.part.robot != gone).then(|| (kept(group.part), Partner::Part(kept(other))))?
                }
                Partner::Part(other) if group.part.robot == gone => {
                    (kept(other), Partner::Obstacle(gone_part(group.part)?))
                }
                Partner::Part(other) if other.robot == gone => {
                    (kept(group.part), Partner::Obstacle(gone_part(other)?))
                }
                Partner::Part(other) => (kept(group.part), Partner::Part(kept(other))),
                Partner::Obstacle(_) => {
                    (group.part.robot != gone).then(|| (kept(group.part), group.other))?
                }
            };
            Some(group.between(part, other))
        };
        let mut groups: Vec<Group> = Vec::new();
        for group in self.groups.iter().filter_map(moved) {
            // Links that are called alike are one obstacle.
            let same = |known: &Group| (known.part, known.other) == (group.part, group.other);
            if !groups.iter().any(same) {
                groups.push(group);
            }
        }
        clearance.set_groups(groups);
        clearance.stretches.remove(gone);
        clearance.stopping_distances.remove(gone);
        Ok(clearance)
    }

    /// Says of the obstacles, by the names of links and theirs, what was said of the robot: it counts again when a body is grasped.
    fn rename(&mut self, robot: &str, obstacles: &[(Arc<str>, Arc<str>)]) {
        let margins = core::mem::take(&mut self.margins);
        for (a, b, margin) in margins {
            match (&*a == robot, &*b == robot) {
                (false, false) => self.margins.push((a, b, margin)),
                (true, true) => {}
                (true, false) | (false, true) => {
                    let other = if &*a == robot { b } else { a };
                    let named = obstacles.iter().map(|(_, name)| (other.clone(), Arc::clone(name), margin));
                    self.margins.extend(named);
                }
            }
        }
        let of_obstacle = |(owner, link): &super::check::Owned| {
            if &**owner != robot {
                return Some((owner.clone(), link.clone()));
            }
            let (_, name) = obstacles.iter().find(|(known, _)| known == link)?;
            Some((Arc::clone(name), Arc::clone(name)))
        };
        self.ignored =
            self.ignored.iter().filter_map(|[a, b]| Some([of_obstacle(a)?, of_obstacle(b)?])).collect();
        self.ignored_own.retain(|owner| &**owner != robot);
    }
}
