//! A robot's URDF, as `robot_description` publishes it: the names of its joints, and where they put its links.
//!
//! In: the URDF that the robot writes of itself, and joint positions. Out: the transforms of `/tf` and `/tf_static`, between the same frames as
//! `robot_state_publisher` makes of that URDF with the prefix `NAME/`.

use mrroc_core::pose::Pose;
use nalgebra::{Translation3, Unit, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

use crate::messages::{Stamp, TransformStamped};

/// The link of every URDF in which the robot stands: the world, or the flange of the robot that carries it.
pub const WORLD: &str = "world";

/// A robot's URDF.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// As it is published.
    pub urdf: String,
    /// The names of its joints, in the order of its joint positions.
    pub joints: Vec<String>,
    moving: Vec<Moving>,
    fixed: Vec<Transform>,
}

/// A link in its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct Transform {
    /// The frame that the link stands in.
    pub parent: String,
    /// The link's own frame.
    pub child: String,
    /// The pose of the link in its parent \[m\].
    pub pose: Pose,
}

impl Transform {
    /// As a message of this stamp.
    pub fn stamped(&self, stamp: Stamp) -> TransformStamped {
        TransformStamped::of(stamp, &self.parent, &self.child, &self.pose)
    }
}

/// A joint that moves.
#[derive(Clone, Debug, PartialEq)]
struct Moving {
    /// The link in its parent at joint position zero.
    at_zero: Transform,
    axis: Unit<Vector3<f64>>,
    is_prismatic: bool,
    /// The joint whose position it has, times `factor`, plus `offset` [rad or m].
    of: usize,
    factor: f64,
    offset: f64,
}

/// A URDF that cannot be published.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoDescription {
    /// It is no XML.
    #[error("its URDF is no XML: {0}")]
    Xml(String),
    /// Something that is needed is missing or no number.
    #[error("in its URDF, joint `{joint}` has no {what}")]
    Joint {
        /// The joint.
        joint: String,
        /// What it lacks.
        what: &'static str,
    },
    /// It has another number of joints than the robot.
    #[error("its URDF has {found} joints that move by themselves, the robot has {expected}")]
    Count {
        /// Those of the URDF.
        found: usize,
        /// Those of the robot.
        expected: usize,
    },
}

/// The names of a robot's joints: those of its description, or `joint1`, `joint2` .. where it has none.
pub fn joint_names(description: Option<&Description>, joints: usize) -> Vec<String> {
    match description {
        Some(description) => description.joints.clone(),
        None => (1..=joints).map(|joint| format!("joint{joint}")).collect(),
    }
}

impl Description {
    /// Of a robot of this name with so many joints.
    ///
    /// # Errors
    /// [`NoDescription`]
    pub fn read(urdf: String, name: &str, joints: usize) -> Result<Description, NoDescription> {
        let text = urdf.clone();
        let document = Document::parse(&text).map_err(|error| NoDescription::Xml(error.to_string()))?;
        let frame = |link: &str| format!("{name}/{link}");
        let (mut names, mut moving, mut fixed) = (Vec::new(), Vec::new(), Vec::new());
        let mut mimics = Vec::new();
        for joint in document.root_element().children().filter(|node| node.has_tag_name("joint")) {
            let called = joint.attribute("name").unwrap_or_default();
            let lacks = |what| NoDescription::Joint { joint: called.to_owned(), what };
            let link = |tag| child(joint, tag).and_then(|node| node.attribute("link")).map(frame);
            let at_zero = Transform {
                parent: link("parent").ok_or_else(|| lacks("parent"))?,
                child: link("child").ok_or_else(|| lacks("child"))?,
                pose: origin(joint).ok_or_else(|| lacks("origin of numbers"))?,
            };
            let kind = joint.attribute("type").unwrap_or_default();
            if kind == "fixed" {
                fixed.push(at_zero);
                continue;
            }
            let axis = match child(joint, "axis") {
                Some(axis) => numbers(axis, "xyz").ok_or_else(|| lacks("axis of numbers"))?,
                None => Vector3::x(),
            };
            let mimic = child(joint, "mimic");
            let number = |name, default: f64| {
                let text = mimic.and_then(|mimic| mimic.attribute(name));
                text.map_or(Some(default), |text| text.parse().ok())
            };
            let (factor, offset) = number("multiplier", 1.0)
                .zip(number("offset", 0.0))
                .ok_or_else(|| lacks("mimic of numbers"))?;
            let leader = mimic.map(|mimic| mimic.attribute("joint").unwrap_or_default().to_owned());
            if leader.is_none() {
                names.push(called.to_owned());
            }
            mimics.push(leader.unwrap_or_else(|| called.to_owned()));
            moving.push(Moving {
                at_zero,
                axis: Unit::try_new(axis, 1e-9).ok_or_else(|| lacks("axis"))?,
                is_prismatic: kind == "prismatic",
                of: 0,
                factor,
                offset,
            });
        }
        for (moving, leader) in moving.iter_mut().zip(&mimics) {
            let lacks = || NoDescription::Joint { joint: leader.clone(), what: "axis of its own" };
            moving.of = names.iter().position(|name| name == leader).ok_or_else(lacks)?;
        }
        if names.len() != joints {
            return Err(NoDescription::Count { found: names.len(), expected: joints });
        }
        Ok(Description { joints: names, moving, fixed, urdf })
    }

    /// The transforms that never change.
    pub fn fixed(&self) -> impl Iterator<Item = &Transform> {
        self.fixed.iter()
    }

    /// The transforms at these joint positions [rad or m].
    pub fn moving(&self, joints: &[f64]) -> impl Iterator<Item = Transform> {
        self.moving.iter().map(|joint| {
            let q = joints.get(joint.of).copied().unwrap_or_default() * joint.factor + joint.offset;
            let by = if joint.is_prismatic {
                Pose::from(Translation3::from(joint.axis.into_inner() * q))
            } else {
                Pose::from_parts(Translation3::identity(), UnitQuaternion::from_axis_angle(&joint.axis, q))
            };
            Transform { pose: joint.at_zero.pose * by, ..joint.at_zero.clone() }
        })
    }
}

fn child<'a>(node: Node<'a, 'a>, tag: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|child| child.has_tag_name(tag))
}

/// The pose that a joint's `origin` says: the identity, if it has none.
fn origin(joint: Node<'_, '_>) -> Option<Pose> {
    let Some(origin) = joint.children().find(|child| child.has_tag_name("origin")) else {
        return Some(Pose::identity());
    };
    let of = |name| if origin.has_attribute(name) { numbers(origin, name) } else { Some(Vector3::zeros()) };
    let (xyz, rpy) = of("xyz").zip(of("rpy"))?;
    Some(Pose::from_parts(xyz.into(), UnitQuaternion::from_euler_angles(rpy.x, rpy.y, rpy.z)))
}

/// Three finite numbers of an attribute.
fn numbers(node: Node<'_, '_>, name: &str) -> Option<Vector3<f64>> {
    let read = node
        .attribute(name)?
        .split_whitespace()
        .map(|word| word.parse().ok().filter(|x: &f64| x.is_finite()));
    let read: Vec<f64> = read.collect::<Option<_>>()?;
    <[f64; 3]>::try_from(read).ok().map(Vector3::from)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use mrroc::robot::{JointVector, Robot, Tool};
    use mrroc_robots::{Irp6, Polycrank, Rnt, Serial, Six};

    use super::*;

    /// The pose of a frame in the world, by going up from parent to parent.
    fn in_world(transforms: &[Transform], frame: &str) -> Pose {
        let parents: BTreeMap<_, _> = transforms.iter().map(|one| (one.child.as_str(), one)).collect();
        let mut pose = Pose::identity();
        let mut at = frame;
        while at != "arm/world" {
            let one = parents[at];
            pose = one.pose * pose;
            at = &one.parent;
        }
        pose
    }

    fn agrees<R: Robot>(robot: &R, tool: &str) {
        let hand = Tool { frame: Pose::translation(0.01, -0.02, 0.15), load: mrroc::robot::Load::NONE };
        let urdf = robot.urdf("arm", &hand).expect("it writes one");
        let read = Description::read(urdf, "arm", R::Joints::LEN).expect("a description");
        for place in 0..100 {
            let share = |joint: usize| (0.37 * place as f64 + 0.61 * joint as f64).fract();
            let limits = robot.limits();
            let joints = R::Joints::from_joints(|i| {
                let (lower, upper) = (limits.lower[i].max(-3.0), limits.upper[i].min(3.0));
                lower + share(i) * (upper - lower)
            });
            let all: Vec<_> = read.fixed().cloned().chain(read.moving(joints.as_slice())).collect();
            let (seen, right) = (in_world(&all, tool), robot.forward(&joints) * hand.frame);
            let apart = (seen.translation.vector - right.translation.vector).norm();
            assert!(
                apart < 1e-9 && seen.rotation.angle_to(&right.rotation) < 1e-7,
                "{apart} m at {joints:?}"
            );
        }
    }

    #[test]
    fn links_are_where_the_robots_own_kinematics_put_its_tool() {
        agrees(&Irp6::nominal(), "arm/tool");
        agrees(&Polycrank::new(), "arm/tool");
        let urdf = include_str!("../../../template/sets/ur5e/ur5e.urdf");
        agrees(
            &Serial::<6>::from_urdf(urdf, "base", "tool0")
                .and_then(|arm| arm.with_acceleration(Six::repeat(8.0)))
                .expect("an arm"),
            "arm/tool",
        );
    }

    #[test]
    fn a_robot_with_closed_linkages_has_more_joints_in_its_urdf() {
        let hand = Tool { frame: Pose::identity(), load: mrroc::robot::Load::NONE };
        let urdf = Rnt::new().urdf("arm", &hand).expect("it writes one");
        // Two linear actuators and their rods, besides the shoulder and the elbow that they turn.
        let refused = Description::read(urdf, "arm", 6).expect_err("a URDF has no loops");
        assert_eq!(refused, NoDescription::Count { found: 8, expected: 6 });
    }

    #[test]
    fn what_is_no_urdf_of_the_robot_is_refused_by_what_it_lacks() {
        let refused = |urdf: &str, joints| {
            Description::read(urdf.to_owned(), "arm", joints).expect_err("refused").to_string()
        };
        assert!(refused("<robot", 1).contains("no XML"));
        let joint =
            |inside: &str| format!("<robot><joint name=\"turn\" type=\"revolute\">{inside}</joint></robot>");
        let links = "<parent link=\"base\"/><child link=\"arm\"/>";
        assert!(refused(&joint(""), 1).contains("`turn` has no parent"));
        assert!(
            refused(&joint(&format!("{links}<axis xyz=\"0 0 NaN\"/>")), 1)
                .contains("`turn` has no axis of numbers")
        );
        assert!(
            refused(&joint(&format!("{links}<origin xyz=\"0 0\"/>")), 1)
                .contains("`turn` has no origin of numbers")
        );
        assert!(refused(&joint(links), 2).contains("has 1 joints that move by themselves, the robot has 2"));
        let mimic = format!("{links}<mimic joint=\"other\"/>");
        assert!(refused(&joint(&mimic), 1).contains("`other` has no axis of its own"));
    }
}
