//! The shape of an arm read from a URDF: its collision shapes as capsules, or a capsule along each link.

use mrroc::prelude::*;
use mrroc::robot::JointKind;
use nalgebra::{SVector, Translation3, Vector3};

use super::branches;
use super::chain::{Segment, turn_of_z};
use super::collision::{LinkCapsule, Meshes, Shapes};
use super::document::{Tree, parsed, shown};
use super::error::UrdfError;
use super::places::{MOST_SEGMENTS, Place, axis, places};
use super::serial::Serial;
use crate::models::shape::{Capsule, Chain, ChainBody, ChainJoint, Link, Motion, Outline};

/// A [`Serial`] arm as capsules.
///
/// **From `<collision>`** ([`SerialOutline::from_urdf`]): of the links from base to tip, and of all that hangs on them, such as a hand with its
/// fingers. What has joints of its own there is covered wherever these may stand, unless it is
/// [left out](Meshes::without). A sphere is a ball, a capsule is
/// itself, a cylinder is given caps that stand out by its radius, a box is covered by four capsules along its longest edge
/// ([`Capsule::covering_box`]): all hold what is written. A mesh is [covered](crate::mesh::cover): the capsules hold it, and stand out
/// by at most [`Meshes::excess`].
///
/// **With a radius** ([`SerialOutline::new`]): one capsule along each link, from the frame of a joint to that of the next, the
/// last to the flange. The radius must be large enough to hold the links around these lines. Links whose joints' frames
/// have one origin are balls.
#[derive(Clone, Debug, PartialEq)]
pub struct SerialOutline<const N: usize> {
    robot: Serial<N>,
    shape: Shape,
}

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    /// Bars of this radius between the frames \[m\].
    Bars(f64),
    Bodies(Vec<LinkCapsule>),
}

impl<const N: usize> SerialOutline<N> {
    /// The shape of `robot` with links of this radius \[m\], finite and > 0.
    #[must_use]
    pub fn new(robot: Serial<N>, radius: f64) -> Self {
        Self { robot, shape: Shape::Bars(radius) }
    }

    /// The shape of `robot` as the `<collision>` elements say of the URDF that it was read from, with the same `base` and
    /// `tip`. Covering its meshes takes about a second each: not for a step.
    ///
    /// # Errors
    /// [`UrdfError`]: as of [`Serial::from_urdf`], a mesh that is not there or cannot be covered, or no collision shape at all.
    pub fn from_urdf(
        robot: Serial<N>,
        text: &str,
        base: &str,
        tip: &str,
        meshes: &Meshes,
    ) -> Result<Self, UrdfError> {
        let document = parsed(text)?;
        let tree = Tree::of(&document)?;
        let mut fixed = Pose::identity();
        let mut joints = 0;
        let mut shapes = Shapes::of(meshes);
        let places = places(&tree, base, tip)?;
        let after = |place: usize| places.get(place).map(|place: &Place<'_, '_>| place.joint.child);
        meshes.without.iter().try_for_each(|link| tree.has_link("link to leave out", link))?;
        branches::collect(&mut shapes, &tree, (base, after(0)), &fixed, joints)?;
        for (i, Place { joint, X_PJ, moves }) in places.iter().enumerate() {
            fixed *= X_PJ;
            if moves.is_some() {
                // The frame of a joint that moves has its z along the axis.
                fixed = Pose::from_parts(Translation3::identity(), turn_of_z(axis(joint)?).inverse());
                joints += 1;
            }
            branches::collect(&mut shapes, &tree, (joint.child, after(i + 1)), &fixed, joints)?;
        }
        if joints != robot.segments().len() {
            let count = joints;
            let names = "another chain than the robot's".to_owned();
            let help = "give the base and tip that the robot was read with".to_owned();
            return Err(UrdfError::WrongCount {
                base: shown(base),
                tip: shown(tip),
                count,
                names,
                asked: N,
                help,
            });
        }
        if shapes.bodies.is_empty() {
            return Err(UrdfError::NoCollision { base: shown(base), tip: shown(tip) });
        }
        Ok(Self { robot, shape: Shape::Bodies(shapes.bodies) })
    }

    /// The same shape with its base link at `X_WB` in the world. Meshes are not covered anew.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn with_base(mut self, X_WB: Pose) -> Self {
        self.robot = self.robot.with_base(X_WB);
        self
    }

    /// Whether the bar before a joint ends on a slide, and so changes its length. A slide is then two motions: the first moves the end
    /// of the bar, the second what is behind. So no motion moves both as one rigid body.
    fn is_stretched_by(&self, segment: &Segment) -> bool {
        matches!(self.shape, Shape::Bars(_)) && segment.kind == JointKind::Prismatic
    }

    /// Which motions move what is behind the first `joints` joints, and the number of the next.
    fn motions_before(&self, joints: usize) -> (u32, u32) {
        self.robot.segments().iter().take(joints).fold((0, 0), |(bits, next), segment| {
            let next = next + u32::from(self.is_stretched_by(segment));
            (bits | 1 << next, next + 1)
        })
    }

    /// The base, the frames of the joints, and the flange.
    fn all_frames(&self, q: &SVector<f64, N>) -> ([Pose; MOST_SEGMENTS + 2], usize) {
        let mut frames = [Pose::identity(); MOST_SEGMENTS + 2];
        let mut count = 0;
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
        match &self.shape {
            Shape::Bars(_) => {
                let segments = self.robot.segments();
                let links = (0..=segments.len()).map(|i| {
                    let (bits, next) = self.motions_before(i);
                    let ends_on_slide = segments.get(i).is_some_and(|segment| self.is_stretched_by(segment));
                    let moved_by = if ends_on_slide { bits | 1 << next } else { bits };
                    Link { name: format!("link {i}").into(), rank: i as u32, moved_by }
                });
                links.collect()
            }
            Shape::Bodies(bodies) => {
                let links = bodies.iter().map(|LinkCapsule { link, joints, .. }| Link {
                    name: link.as_str().into(),
                    rank: *joints as u32,
                    moved_by: self.motions_before(*joints).0,
                });
                links.collect()
            }
        }
    }

    fn capsules(&self, q: &SVector<f64, N>, visit: &mut dyn FnMut(Capsule)) {
        let (frames, count) = self.all_frames(q);
        match &self.shape {
            Shape::Bars(radius) => {
                for ends in frames[..count].windows(2) {
                    visit(Capsule::new(ends[0].translation.vector, ends[1].translation.vector, *radius));
                }
            }
            Shape::Bodies(bodies) => {
                let placed =
                    bodies.iter().filter_map(|body| Some(body.capsule.moved(frames.get(body.joints)?)));
                placed.for_each(visit);
            }
        }
    }

    fn rigid(&self) -> Option<Vec<(usize, Capsule)>> {
        match &self.shape {
            Shape::Bars(_) => None,
            Shape::Bodies(bodies) => Some(bodies.iter().map(|body| (body.joints, body.capsule)).collect()),
        }
    }

    fn link_frames(&self, q: &SVector<f64, N>, visit: &mut dyn FnMut(&Pose)) {
        self.robot.frames(q, visit);
    }

    fn motions(&self, q: &SVector<f64, N>, distances: &SVector<f64, N>, visit: &mut dyn FnMut(Motion)) {
        let (frames, _) = self.all_frames(q);
        for (segment, frame) in self.robot.segments().iter().zip(&frames[1..]) {
            let bound = segment.multiplier.abs() * distances[segment.leader];
            if self.is_stretched_by(segment) {
                visit(Motion::Slide { bound });
            }
            visit(match segment.kind {
                JointKind::Revolute => Motion::Turn {
                    point: frame.translation.vector,
                    axis: Some(frame.rotation * Vector3::z()),
                    bound,
                },
                JointKind::Prismatic => Motion::Slide { bound },
            });
        }
    }

    fn flange_motions(&self) -> u32 {
        self.motions_before(self.robot.segments().len()).0
    }

    /// `None` where a bar changes its length, or where the arm has a [local correction](crate::LocalCorrection): its joints then
    /// do not stand where a multiplier and an offset say.
    #[allow(non_snake_case)]
    fn chain(&self) -> Option<Chain> {
        let segments = self.robot.segments();
        if self.robot.has_local_correction() {
            return None;
        }
        let joint = |segment: &Segment| ChainJoint {
            X_before: segment.X_before,
            kind: segment.kind,
            leader: segment.leader,
            multiplier: segment.multiplier,
            offset: segment.offset,
        };
        let X_WB = self.robot.X_WB();
        let in_frame = |joints: usize, capsule: &Capsule| ChainBody {
            joints,
            capsule: if joints == 0 { capsule.moved(&X_WB) } else { *capsule },
        };
        let bodies = match &self.shape {
            Shape::Bars(radius) => {
                if segments.iter().any(|segment| segment.kind == JointKind::Prismatic) {
                    return None;
                }
                // A turn leaves the origin of its frame where it is.
                let first = segments.first().map(|first| X_WB.inverse() * first.X_before);
                let next = segments.iter().skip(1).map(|segment| segment.X_before);
                let ends = first.into_iter().chain(next).chain([self.robot.X_tip]);
                let bar = |end: Pose| Capsule::new(Vector3::zeros(), end.translation.vector, *radius);
                ends.enumerate().map(|(joints, end)| in_frame(joints, &bar(end))).collect()
            }
            Shape::Bodies(bodies) => bodies.iter().map(|body| in_frame(body.joints, &body.capsule)).collect(),
        };
        Some(Chain { joints: segments.iter().map(joint).collect(), bodies, X_tip: self.robot.X_tip })
    }
}
