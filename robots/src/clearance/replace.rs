//! Puts another body in the place of an obstacle, while robots move.
//!
//! In: the name of an obstacle, and the body that is there now. Out: the one that was there. Which pairs are checked was found for that one, by
//! postures; those of them that were left out are checked from then on.

use super::check::Clearance;
use super::error::ClearanceError;
use super::obstacle::Obstacle;
use super::pairs::{Group, Partner};
use super::placement::Placement;

impl Clearance {
    /// Puts another body in the place of an obstacle, of the same name, and gives back the one that stood there. It allocates nothing,
    /// so a guard may do so in a step. Plans are not made anew by it.
    ///
    /// From then on all pairs of this obstacle are checked, also with links that always overlapped with it where it stood. Still left out are
    /// those that are ignored by name, and those of links that overlapped and that no joint moves, such as the base that stands on it.
    ///
    /// # Errors
    /// [`ClearanceError::BadBody`], [`ClearanceError::NoLink`] where no obstacle has this name.
    pub fn replace_obstacle(&mut self, name: &str, obstacle: Obstacle) -> Result<Obstacle, ClearanceError> {
        let Some(place) = self.place_of_obstacle(name) else {
            let known = self.names.iter().map(|name| &**name).collect::<Vec<_>>().join(", ");
            return Err(ClearanceError::NoLink { owner: "the cell".into(), link: name.into(), known });
        };
        if !obstacle.is_valid() {
            return Err(ClearanceError::BadBody { body: name.into() });
        }
        for i in 0..self.groups.len() {
            let group = &mut self.groups[i];
            if group.other != Partner::Obstacle(place) || !is_moved(&self.robots, group) {
                continue;
            }
            group.check_all();
            if i >= self.checked {
                self.groups.swap(i, self.checked);
                self.checked += 1;
                self.search.forget();
            }
        }
        Ok(core::mem::replace(&mut self.bodies[place], obstacle))
    }

    /// The number of an obstacle, in the order in which they were added.
    #[must_use]
    pub fn place_of_obstacle(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| &**known == name)
    }
}

/// Whether a joint moves the links of a group.
fn is_moved(robots: &[Placement], group: &Group) -> bool {
    let robot = &robots[group.part.robot];
    robot.links[robot.parts[group.part.part].link].moved_by != 0
}
