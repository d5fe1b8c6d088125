//! How distances change with the joints, for those who optimise motions.
//!
//! In: joint positions of all robots, and up to which distance pairs matter. Out: these pairs, and for each joint by how much the distance grows when
//! it moves. It is a central difference: right where the nearest points move smoothly, and the mean of both sides where they jump from one
//! edge to another.

use super::check::Clearance;
use super::error::{CheckError, Nearest};
use super::gap::Gap;
use super::pairs::Pair;

/// How far a joint moves to either side for a difference [rad or m].
const DIFFERENCE: f64 = 1e-6;

impl Clearance {
    /// All pairs nearer than `within` \[m\] at joint positions [rad or m] of the robots in the order in which they were added, the nearest first. With each
    /// pair comes the change of its distance by every joint of all robots, one behind the other [m/rad or 1]. Margins do not matter. It
    /// allocates: call it between motions.
    ///
    /// ```
    /// use mrroc_robots::clearance::{Clearance, Obstacle, Stop, Stopping};
    /// use mrroc_robots::Irp6;
    /// use nalgebra::Vector3;
    ///
    /// let mut clearance = Clearance::with_margin(0.0)
    ///     .robot("irp6", Irp6::nominal())?
    ///     .obstacle("post", Obstacle::ball(Vector3::new(0.9, 0.5, 0.8), 0.1))?
    ///     .build(Stopping { reaction: 0.0, stop: Stop::Braking })?;
    /// for (nearest, gradient) in clearance.gradients_at(&[Irp6::READY.as_slice()], 0.5)? {
    ///     println!("{nearest}, and by joint 1 {:.3} m/rad", gradient[0]);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`CheckError`] except [`CheckError::TooClose`] and [`CheckError::NothingToCheck`]: no pair within the distance is an empty list.
    pub fn gradients_at(
        &mut self,
        positions: &[&[f64]],
        within: f64,
    ) -> Result<Vec<(Nearest, Vec<f64>)>, CheckError> {
        self.place_at(|robot| positions.get(robot).copied())?;
        let near = self.within(within);
        let mut found: Vec<(Nearest, Vec<f64>)> = near
            .iter()
            .map(|(pair, gap)| {
                let sides = self.sides(pair, gap);
                (Nearest { distance: gap.distance, travel: 0.0, margin: 0.0, sides }, Vec::new())
            })
            .collect();
        for robot in 0..self.robots.len() {
            for joint in 0..self.robots[robot].shape().kinds().len() {
                let before = self.distances(&near, positions, robot, joint, -DIFFERENCE)?;
                let after = self.distances(&near, positions, robot, joint, DIFFERENCE)?;
                for ((_, gradient), (before, after)) in found.iter_mut().zip(before.iter().zip(after)) {
                    gradient.push((after - before) / (2.0 * DIFFERENCE));
                }
            }
        }
        Ok(found)
    }

    /// The distances of pairs where one joint is off its position.
    fn distances(
        &mut self,
        pairs: &[(Pair, Gap)],
        positions: &[&[f64]],
        robot: usize,
        joint: usize,
        off: f64,
    ) -> Result<Vec<f64>, CheckError> {
        let mut moved = positions.get(robot).map_or_else(Vec::new, |q| q.to_vec());
        if let Some(q) = moved.get_mut(joint) {
            *q += off;
        }
        self.place_at(|i| if i == robot { Some(moved.as_slice()) } else { positions.get(i).copied() })?;
        let distance = |(pair, _): &(Pair, Gap)| self.gap(pair).map_or(f64::INFINITY, |gap| gap.distance);
        Ok(pairs.iter().map(distance).collect())
    }
}
