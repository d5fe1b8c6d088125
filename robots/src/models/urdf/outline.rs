//! The shape of an arm read from a URDF: its collision shapes as capsules, or a capsule along each link.

use mrroc::prelude::*;
use mrroc::robot::JointKind;
use nalgebra::{SVector, Translation3, Vector3};

use super::chain::turn_of_z;
use super::document::{Element, Tree, origin, parsed, shown};
use super::error::UrdfError;
use super::places::{MOST_SEGMENTS, Place, axis, places};
use super::serial::Serial;
use crate::models::shape::{Capsule, Link, Motion, Outline};

/// A [`Serial`] arm as capsules.
///
/// **From `<collision>`** ([`SerialOutline::from_urdf`]): of the links from base to tip. A sphere is a ball, a capsule is
/// itself, a cylinder is given caps that stand out by its radius, a box is covered by four capsules along its longest edge
/// ([`Capsule::covering_box`]): all hold what is written. A mesh is refused.
///
/// **With a radius** ([`SerialOutline::new`]): one capsule along each link, from the frame of a joint to that of the next, the
/// last to the flange. The radius must be large enough to hold the links around these lines. Links whose joints' frames
/// have one origin are balls.
#[derive(Clone, Debug, PartialEq)]
pub struct SerialOutline<const N: usize> {
    robot: Serial<N>,
    shape: Shape,
}

/// The bit of the first motion, which moves nothing. Bars that end on a slide count as moved by it: they change their
/// length, so no joint moves them and the links behind the slide as one rigid body.
const STRETCHING: u32 = 1;

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    /// Bars of this radius between the frames \[m\].
    Bars(f64),
    Bodies(Vec<Bar>),
}

/// A capsule of a link.
#[derive(Clone, Debug, PartialEq)]
struct Bar {
    link: String,
    /// How many joints stand before it.
    joints: usize,
    /// In the frame of the last of them, or of the base.
    capsule: Capsule,
}

impl<const N: usize> SerialOutline<N> {
    /// The shape of `robot` with links of this radius \[m\], finite and > 0.
    #[must_use]
    pub fn new(robot: Serial<N>, radius: f64) -> Self {
        Self { robot, shape: Shape::Bars(radius) }
    }

    /// The shape of `robot` as the `<collision>` elements say of the URDF that it was read from, with the same `base` and
    /// `tip`.
    ///
    /// # Errors
    /// [`UrdfError`]: as of [`Serial::from_urdf`], a mesh, or no collision shape at all.
    pub fn from_urdf(robot: Serial<N>, text: &str, base: &str, tip: &str) -> Result<Self, UrdfError> {
        let document = parsed(text)?;
        let tree = Tree::of(&document)?;
        let mut fixed = Pose::identity();
        let mut joints = 0;
        let mut bodies = Vec::new();
        collect(&tree, base, &fixed, joints, &mut bodies)?;
        for Place { joint, X_PJ, moves } in places(&tree, base, tip)? {
            fixed *= X_PJ;
            if moves.is_some() {
                // The frame of a joint that moves has its z along the axis.
                fixed = Pose::from_parts(Translation3::identity(), turn_of_z(axis(&joint)?).inverse());
                joints += 1;
            }
            collect(&tree, joint.child, &fixed, joints, &mut bodies)?;
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
        if bodies.is_empty() {
            return Err(UrdfError::NoCollision { base: shown(base), tip: shown(tip) });
        }
        Ok(Self { robot, shape: Shape::Bodies(bodies) })
    }

    /// The base, the frames of the joints, and the flange.
    fn frames(&self, q: &SVector<f64, N>) -> ([Pose; MOST_SEGMENTS + 2], usize) {
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

/// Adds the collision shapes of a link that stands at `X_JL` in the frame of the last joint that moves it.
#[allow(non_snake_case)]
fn collect(
    tree: &Tree<'_, '_>,
    link: &str,
    X_JL: &Pose,
    joints: usize,
    bodies: &mut Vec<Bar>,
) -> Result<(), UrdfError> {
    let Some(element) = tree.link(link) else { return Ok(()) };
    for collision in element.all("collision") {
        let X_JC = X_JL * origin(&collision, tree.has_quaternions)?;
        let write = "<geometry><cylinder radius=\"..\" length=\"..\"/></geometry>";
        for capsule in capsules_of(&collision.required("geometry", write)?)? {
            bodies.push(Bar { link: shown(link), joints, capsule: capsule.moved(&X_JC) });
        }
    }
    Ok(())
}

/// The capsules that hold a shape, around its origin.
fn capsules_of(geometry: &Element<'_, '_>) -> Result<Vec<Capsule>, UrdfError> {
    let above_zero = |shape: &Element<'_, '_>, attribute: &'static str| {
        let number =
            shape.number(attribute)?.ok_or_else(|| shape.missing(attribute, "a length in metres"))?;
        if number > 0.0 { Ok(number) } else { Err(shape.bad(attribute, "a finite number above 0")) }
    };
    if let Some(sphere) = geometry.child("sphere")? {
        let radius = above_zero(&sphere, "radius")?;
        return Ok(vec![Capsule::new(Vector3::zeros(), Vector3::zeros(), radius)]);
    }
    for name in ["cylinder", "capsule"] {
        if let Some(bar) = geometry.child(name)? {
            let radius = above_zero(&bar, "radius")?;
            let half = 0.5 * above_zero(&bar, "length")?;
            return Ok(vec![Capsule::new(Vector3::z() * -half, Vector3::z() * half, radius)]);
        }
    }
    if let Some(cuboid) = geometry.child("box")? {
        let edges = cuboid.numbers::<3>("size")?.ok_or_else(|| cuboid.missing("size", "size=\"x y z\""))?;
        if edges.iter().any(|edge| *edge <= 0.0) {
            return Err(cuboid.bad("size", "three numbers above 0"));
        }
        return Ok(Capsule::covering_box(Vector3::from(edges), 2));
    }
    Err(UrdfError::UnsupportedCollision { line: geometry.line(), element: geometry.called.clone() })
}

impl<const N: usize> Outline for SerialOutline<N> {
    type Robot = Serial<N>;

    fn robot(&self) -> &Serial<N> {
        &self.robot
    }

    fn links(&self) -> Vec<Link> {
        let link =
            |name: &str, joints: usize, moved_by| Link { name: name.into(), rank: joints as u32, moved_by };
        let behind = |joints: usize| Link::first(joints as u32 + 1) & !STRETCHING;
        match &self.shape {
            Shape::Bars(_) => {
                let segments = self.robot.segments();
                let links = (0..=segments.len()).map(|i| {
                    let is_slide = segments.get(i).is_some_and(|next| next.kind == JointKind::Prismatic);
                    let moved_by = if is_slide { behind(i + 1) | STRETCHING } else { behind(i) };
                    link(&format!("link {i}"), i, moved_by)
                });
                links.collect()
            }
            Shape::Bodies(bodies) => {
                bodies.iter().map(|body| link(&body.link, body.joints, behind(body.joints))).collect()
            }
        }
    }

    fn capsules(&self, q: &SVector<f64, N>, visit: &mut dyn FnMut(Capsule)) {
        let (frames, count) = self.frames(q);
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

    fn motions(&self, q: &SVector<f64, N>, distances: &SVector<f64, N>, visit: &mut dyn FnMut(Motion)) {
        let (frames, _) = self.frames(q);
        visit(Motion::Slide { bound: 0.0 });
        for (segment, frame) in self.robot.segments().iter().zip(&frames[1..]) {
            let bound = segment.multiplier.abs() * distances[segment.leader];
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
        !STRETCHING
    }
}
