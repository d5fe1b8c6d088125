//! The shape of an arm read from a URDF: a capsule along each link.

use mrroc::{JointKind, Pose, Robot};
use nalgebra::{SVector, Vector3};

use super::chain::MOST_SEGMENTS;
use super::serial::Serial;
use crate::clearance::{Capsule, Link, Motion, Outline};

/// A [`Serial`] arm as capsules: one along each link, from the frame of a joint to that of the next, the last to the flange,
/// all of one stated radius.
///
/// A URDF's `<collision>` elements, mostly meshes, are not read: the radius must be large enough to hold the links around the
/// lines between their joints. Links whose joints' frames have one origin are balls.
#[derive(Clone, Debug, PartialEq)]
pub struct SerialOutline<const N: usize> {
    robot: Serial<N>,
    radius: f64,
}

impl<const N: usize> SerialOutline<N> {
    /// The shape of `robot` with links of this radius \[m\], finite and > 0.
    #[must_use]
    pub fn new(robot: Serial<N>, radius: f64) -> Self {
        Self { robot, radius }
    }

    /// The base, the frames of the joints, and the flange.
    fn frames(&self, q: &SVector<f64, N>) -> ([Pose; MOST_SEGMENTS + 2], usize) {
        let (mut frames, mut count) = ([Pose::identity(); MOST_SEGMENTS + 2], 0);
        self.robot.frames(q, &mut |frame| {
            if let Some(place) = frames.get_mut(count) {
                *place = *frame;
                count += 1;
            }
        });
        (frames, count)
    }
}

impl<const N: usize> Outline for SerialOutline<N> {
    type Robot = Serial<N>;

    fn robot(&self) -> &Serial<N> {
        &self.robot
    }

    fn links(&self) -> Vec<Link> {
        // Link i stands behind the joints before it.
        let count = self.robot.segments().len() as u32;
        (0..=count).map(|i| Link::new(&format!("link {i}"), i, i)).collect()
    }

    fn capsules(&self, q: &SVector<f64, N>, visit: &mut dyn FnMut(Capsule)) {
        let (frames, count) = self.frames(q);
        for ends in frames[..count].windows(2) {
            visit(Capsule::new(ends[0].translation.vector, ends[1].translation.vector, self.radius));
        }
    }

    fn motions(&self, q: &SVector<f64, N>, way: &SVector<f64, N>, visit: &mut dyn FnMut(Motion)) {
        let (frames, _) = self.frames(q);
        for (segment, frame) in self.robot.segments().iter().zip(&frames[1..]) {
            let way = segment.multiplier.abs() * way[segment.leader];
            visit(match segment.kind {
                JointKind::Revolute => Motion::Turn {
                    point: frame.translation.vector,
                    axis: Some(frame.rotation * Vector3::z()),
                    way,
                },
                JointKind::Prismatic => Motion::Slide { way },
            });
        }
    }
}
