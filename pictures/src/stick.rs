//! A robot as a stick figure: its links as lines, and a gripper that shows where the tool points.
//!
//! In: a sample. Out: points in the world \[m\]. The gripper's tips lie at the tool's origin when the tool stands off the
//! flange by its length or more, and its palm does when there is no tool.

use nalgebra::Vector3;

use crate::history::History;
use crate::sample::Sample;

/// A pose of a robot.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Stick {
    /// From the base over the links to the flange and the tool's palm \[m\].
    pub links: Vec<Vector3<f64>>,
    /// Finger, palm, palm, finger \[m\].
    pub gripper: [Vector3<f64>; 4],
}

impl Stick {
    /// Of a sample, with a gripper of this size \[m\].
    pub fn of(sample: &Sample, size: f64) -> Stick {
        let tool = sample.tool.translation.vector;
        let [across, along] = [Vector3::x(), Vector3::z()].map(|axis| sample.tool.rotation * axis);
        let mut links: Vec<Vector3<f64>> = Vec::with_capacity(sample.links.len() + 1);
        for link in &sample.links {
            // Frames of one place, such as a column's and a shoulder's, are one joint to the eye.
            if links.last().is_none_or(|last| (last - link).norm() > 1e-6) {
                links.push(*link);
            }
        }
        let reach = links.last().map_or(0.0, |flange| (tool - flange).norm());
        let palm = tool - along * reach.min(size);
        if links.last().is_none_or(|last| (last - palm).norm() > 1e-6) {
            links.push(palm);
        }
        let half = across * (0.45 * size);
        let finger = along * size;
        Stick { links, gripper: [palm - half + finger, palm - half, palm + half, palm + half + finger] }
    }

    /// Every point.
    pub fn points(&self) -> impl Iterator<Item = Vector3<f64>> + '_ {
        self.links.iter().chain(&self.gripper).copied()
    }

    /// Between this and another pose, `share` 0 to 1.
    fn towards(&self, other: &Stick, share: f64) -> Stick {
        let mixed = |a: &Vector3<f64>, b: &Vector3<f64>| a + (b - a) * share;
        if self.links.len() != other.links.len() {
            return if share < 0.5 { self.clone() } else { other.clone() };
        }
        let mut gripper = self.gripper;
        gripper.iter_mut().zip(&other.gripper).for_each(|(a, b)| *a = mixed(a, b));
        Stick { links: self.links.iter().zip(&other.links).map(|(a, b)| mixed(a, b)).collect(), gripper }
    }

    /// The farthest that any point is from its place in another pose \[m\].
    pub fn distance(&self, other: &Stick) -> f64 {
        self.points().zip(other.points()).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    }
}

/// All poses of a robot over time.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    /// Times \[s\], increasing.
    pub times: Vec<f64>,
    /// The pose at each.
    pub sticks: Vec<Stick>,
    /// Where the tool is at each \[m\].
    pub tool: Vec<Vector3<f64>>,
    /// Whether the robot is mounted on another one, and not on the floor.
    pub is_mounted: bool,
}

impl Motion {
    /// Of a history, with a gripper of this size \[m\].
    pub fn of(history: &History, size: f64) -> Motion {
        let samples = history.samples();
        Motion {
            times: samples.iter().map(|sample| sample.time).collect(),
            sticks: samples.iter().map(|sample| Stick::of(sample, size)).collect(),
            tool: samples.iter().map(|sample| sample.tool.translation.vector).collect(),
            is_mounted: history.is_mounted,
        }
    }

    /// The pose at a time \[s\], between samples on a straight line; at rest before the first and after the last.
    pub fn at(&self, time: f64) -> Option<Stick> {
        let after = self.times.partition_point(|t| *t < time);
        match (after.checked_sub(1), self.sticks.get(after)) {
            (Some(before), Some(next)) => {
                let from = self.times[before];
                let to = self.times[after];
                Some(self.sticks[before].towards(next, (time - from) / (to - from)))
            }
            (None, Some(only)) => Some(only.clone()),
            (_, None) => self.sticks.last().cloned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::history::tests::slide;
    use mrroc::pose::Pose;
    use mrroc::robot::JointKind;

    #[test]
    fn the_gripper_ends_at_the_tool_or_begins_there_without_one() {
        let mut sample = slide(0.0, 0.2, 0.2);
        let stick = Stick::of(&sample, 0.05);
        assert_eq!(stick.links, sample.links);
        let palm = 0.5 * (stick.gripper[1] + stick.gripper[2]);
        assert!((palm - sample.tool.translation.vector).norm() < 1e-15);
        // A tool 0.2 m ahead along z.
        sample.tool = Pose::translation(0.2, 0.0, 0.7);
        let stick = Stick::of(&sample, 0.05);
        let tips = 0.5 * (stick.gripper[0] + stick.gripper[3]);
        assert!((tips - Vector3::new(0.2, 0.0, 0.7)).norm() < 1e-15);
        assert_eq!(stick.links.len(), 3);
    }

    #[test]
    fn between_samples_the_pose_is_between_and_outside_it_rests() {
        let mut history = History::new("slide", "slide", &[JointKind::Prismatic]);
        history.add(slide(1.0, 0.0, 0.0));
        history.add(slide(2.0, 0.4, 0.4));
        let motion = Motion::of(&history, 0.05);
        let x = |time| motion.at(time).unwrap().links[1].x;
        for (time, expected) in [(0.0, 0.0), (1.0, 0.0), (1.25, 0.1), (2.0, 0.4), (9.0, 0.4)] {
            assert!((x(time) - expected).abs() < 1e-12, "{time}");
        }
    }
}
