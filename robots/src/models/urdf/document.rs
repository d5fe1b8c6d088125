//! The XML of a URDF: text in, elements with their lines out.
//!
//! Values are read as they are used, and strictly: text where a number must stand, or an attribute that URDF does not
//! have, is an error and never a default: `docs/decisions/0003-own-code-or-a-crate.md`.

use std::collections::HashMap;

use mrroc::console::quoted;
use mrroc::pose::Pose;
use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use roxmltree::{Document, Node, ParsingOptions};

use super::error::UrdfError;
use crate::models::xml::check_xml;

/// Longest text that is read \[bytes\].
pub(super) const LONGEST: usize = 8 << 20;

/// Most elements, comments and texts that are read.
const MOST_NODES: u32 = 400_000;

/// The XML tree of a robot.
///
/// # Errors
/// See [`UrdfError`]: too long, not XML, xacro, or not `<robot>`.
pub(super) fn parsed(text: &str) -> Result<Document<'_>, UrdfError> {
    if text.len() > LONGEST {
        return Err(UrdfError::TooLarge { limit: LONGEST });
    }
    // Elements may be nested as deep as they like: neither the reader nor the robot goes down level by level.
    check_xml(text, usize::MAX)?;
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|why| refused(text, &why))?;
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        let found = shown(root.tag_name().name());
        return Err(UrdfError::NotRobot { line: line(root), found });
    }
    let foreign = |node: &Node<'_, '_>| node.tag_name().namespace().is_some_and(|uri| uri.contains("xacro"));
    if let Some(node) = root.descendants().find(foreign) {
        let what = format!("<xacro:{}>", shown(node.tag_name().name()));
        return Err(UrdfError::Xacro { line: line(node), what });
    }
    Ok(document)
}

/// What the XML reader refused.
fn refused(text: &str, why: &roxmltree::Error) -> UrdfError {
    let place = why.pos();
    let line = place.row as usize;
    let column = place.col as usize;
    match why {
        // The reader does not say where.
        roxmltree::Error::DtdDetected => {
            let before = text.find("<!DOCTYPE").map_or("", |at| &text[..at]);
            UrdfError::Doctype { line: before.bytes().filter(|byte| *byte == b'\n').count() + 1 }
        }
        roxmltree::Error::NodesLimitReached => UrdfError::TooLarge { limit: LONGEST },
        roxmltree::Error::UnknownNamespace(prefix, _) if prefix == "xacro" => {
            UrdfError::Xacro { line, what: "the prefix xacro:".to_owned() }
        }
        roxmltree::Error::UnexpectedEndOfStream | roxmltree::Error::UnclosedRootNode => {
            let line = text.lines().count().max(1);
            let column = text.lines().last().map_or(0, str::len) + 1;
            UrdfError::Xml { line, column, what: "it ends inside an element".to_owned() }
        }
        other => {
            let message = other.to_string();
            // It quotes names of the file.
            let what = quoted(message.split(" at ").next().unwrap_or(&message), 120);
            UrdfError::Xml { line, column, what }
        }
    }
}

/// The line where an element begins, from 1.
pub(super) fn line(node: Node<'_, '_>) -> usize {
    node.document().text_pos_at(node.range().start).row as usize
}

/// The elements called `name` directly inside `parent`.
fn children<'a, 'i>(parent: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    parent.children().filter(move |node| node.is_element() && node.tag_name().name() == name)
}

/// An element with what errors call it, such as `joint "elbow" <limit>`.
#[derive(Clone)]
pub(super) struct Element<'a, 'i> {
    pub(super) node: Node<'a, 'i>,
    pub(super) called: String,
}

impl<'a, 'i> Element<'a, 'i> {
    /// The line where it begins, from 1.
    pub(super) fn line(&self) -> usize {
        line(self.node)
    }

    /// The only element called `name` inside, if there is one.
    pub(super) fn child(&self, name: &'static str) -> Result<Option<Self>, UrdfError> {
        let mut found = children(self.node, name);
        let first = found.next();
        if let Some(second) = found.next() {
            let element = self.called.clone();
            return Err(UrdfError::RepeatedElement { line: line(second), element, child: name });
        }
        Ok(first.map(|node| Element { node, called: format!("{} <{name}>", self.called) }))
    }

    /// The only element called `name` inside, which must be there.
    pub(super) fn required(&self, name: &'static str, write: &'static str) -> Result<Self, UrdfError> {
        self.child(name)?.ok_or_else(|| UrdfError::MissingElement {
            line: self.line(),
            element: self.called.clone(),
            child: name,
            write,
        })
    }

    /// The elements called `name` inside.
    pub(super) fn all(&self, name: &'static str) -> impl Iterator<Item = Self> {
        let called = format!("{} <{name}>", self.called);
        children(self.node, name).map(move |node| Element { node, called: called.clone() })
    }

    /// The text of an attribute, without the blanks around it.
    pub(super) fn text(&self, attribute: &str) -> Result<Option<&'a str>, UrdfError> {
        let Some(text) = self.node.attribute(attribute) else { return Ok(None) };
        if text.contains("${") || text.contains("$(") {
            return Err(UrdfError::Xacro {
                line: self.line(),
                what: format!("{attribute}=\"{}\"", shown(text)),
            });
        }
        Ok(Some(text.trim()))
    }

    /// The text of an attribute that must be there, and not be empty.
    pub(super) fn required_text(
        &self,
        attribute: &'static str,
        write: &'static str,
    ) -> Result<&'a str, UrdfError> {
        self.text(attribute)?.filter(|text| !text.is_empty()).ok_or_else(|| self.missing(attribute, write))
    }

    /// The error of an attribute that is not there.
    pub(super) fn missing(&self, attribute: &'static str, write: &'static str) -> UrdfError {
        UrdfError::MissingAttribute { line: self.line(), element: self.called.clone(), attribute, write }
    }

    /// The error of an attribute whose value will not do.
    pub(super) fn bad(&self, attribute: &'static str, expected: &'static str) -> UrdfError {
        let text = shown(self.node.attribute(attribute).unwrap_or_default());
        UrdfError::BadValue { line: self.line(), element: self.called.clone(), attribute, text, expected }
    }

    /// The `C` finite numbers of an attribute.
    pub(super) fn numbers<const C: usize>(
        &self,
        attribute: &'static str,
    ) -> Result<Option<[f64; C]>, UrdfError> {
        let expected = match C {
            1 => "a finite number",
            3 => "three finite numbers",
            _ => "four finite numbers",
        };
        let Some(text) = self.text(attribute)? else { return Ok(None) };
        let mut numbers = [0.0; C];
        let mut words = text.split_ascii_whitespace();
        for number in &mut numbers {
            let read = words.next().and_then(|word| word.parse::<f64>().ok());
            *number = read.filter(|n| n.is_finite()).ok_or_else(|| self.bad(attribute, expected))?;
        }
        if words.next().is_some() {
            return Err(self.bad(attribute, expected));
        }
        Ok(Some(numbers))
    }

    /// The finite number of an attribute.
    pub(super) fn number(&self, attribute: &'static str) -> Result<Option<f64>, UrdfError> {
        Ok(self.numbers::<1>(attribute)?.map(|[number]| number))
    }

    /// Refuses attributes other than these: a misspelt one would silently change the robot.
    pub(super) fn only(&self, known: &[&str]) -> Result<(), UrdfError> {
        let strange = |name: &str| !known.contains(&name);
        match self.node.attributes().find(|a| a.namespace().is_none() && strange(a.name())) {
            None => Ok(()),
            Some(attribute) => Err(UrdfError::UnknownAttribute {
                line: self.line(),
                element: self.called.clone(),
                attribute: shown(attribute.name()),
                known: known.join(", "),
            }),
        }
    }
}

/// Where a joint stands in its parent link, or a centre of mass in its own: `<origin>`, by definition the identity where it
/// is not written.
pub(super) fn origin(of: &Element<'_, '_>, has_quaternions: bool) -> Result<Pose, UrdfError> {
    let Some(origin) = of.child("origin")? else { return Ok(Pose::identity()) };
    origin.only(&["xyz", "rpy", "quat_xyzw"])?;
    let position = origin.numbers::<3>("xyz")?.unwrap_or_default();
    let angles = origin.numbers::<3>("rpy")?;
    let rotation = match (angles, origin.numbers::<4>("quat_xyzw")?) {
        (Some(_), Some(_)) => {
            return Err(UrdfError::TwoOrientations { line: origin.line(), element: origin.called });
        }
        (_, Some(_)) if !has_quaternions => {
            return Err(UrdfError::QuaternionBeforeItsTime { line: origin.line(), element: origin.called });
        }
        (None, Some([x, y, z, w])) => {
            let quaternion = Quaternion::new(w, x, y, z);
            if (quaternion.norm() - 1.0).abs() > 1e-3 {
                return Err(origin.bad("quat_xyzw", "a quaternion x y z w of length 1"));
            }
            UnitQuaternion::new_normalize(quaternion)
        }
        (Some([roll, pitch, yaw]), None) => UnitQuaternion::from_euler_angles(roll, pitch, yaw),
        (None, None) => UnitQuaternion::identity(),
    };
    Ok(Pose::from_parts(Translation3::from(position), rotation))
}

/// The beginning of a text, for a message.
pub(super) fn shown(text: &str) -> String {
    quoted(text, 60)
}

/// The links and joints of a robot by their names, each of which stands once.
pub(super) struct Tree<'a, 'i> {
    /// Whether the file declares `version` 1.1 or later, which has `quat_xyzw`.
    pub(super) has_quaternions: bool,
    links: HashMap<&'a str, Node<'a, 'i>>,
    /// The joint whose child is the link of this name.
    parents: HashMap<&'a str, Joint<'a, 'i>>,
    /// The links that hang on the link of this name, in the order of the file.
    children: HashMap<&'a str, Vec<&'a str>>,
}

/// A joint and the links that it connects.
#[derive(Clone)]
pub(super) struct Joint<'a, 'i> {
    pub(super) name: &'a str,
    pub(super) parent: &'a str,
    pub(super) child: &'a str,
    pub(super) element: Element<'a, 'i>,
}

impl<'a, 'i> Tree<'a, 'i> {
    /// The tree of the links.
    ///
    /// # Errors
    /// A name that is missing or stands twice, a joint between links that are not there, a link with two parents.
    pub(super) fn of(document: &'a Document<'i>) -> Result<Self, UrdfError> {
        let robot = document.root_element();
        let mut links = HashMap::new();
        for node in children(robot, "link") {
            let element = Element { node, called: "a link".to_owned() };
            let name = element.required_text("name", "<link name=\"..\">")?;
            if let Some(first) = links.insert(name, node) {
                return Err(duplicate("link", name, first, node));
            }
        }
        let mut names = HashMap::new();
        let mut parents: HashMap<&str, Joint<'a, 'i>> = HashMap::new();
        let mut children_of: HashMap<&str, Vec<&str>> = HashMap::new();
        for node in children(robot, "joint") {
            let joint = joint(node)?;
            if let Some(first) = names.insert(joint.name, node) {
                return Err(duplicate("joint", joint.name, first, node));
            }
            for (role, link) in [("parent", joint.parent), ("child", joint.child)] {
                if !links.contains_key(link) {
                    return Err(UrdfError::UnknownLink {
                        line: line(node),
                        joint: shown(joint.name),
                        role,
                        link: shown(link),
                        help: alternatives(link, links.keys().copied()),
                    });
                }
            }
            if let Some(first) = parents.get(joint.child) {
                return Err(UrdfError::TwoParents {
                    line: line(node),
                    link: shown(joint.child),
                    first: shown(first.name),
                    second: shown(joint.name),
                });
            }
            children_of.entry(joint.parent).or_default().push(joint.child);
            parents.insert(joint.child, joint);
        }
        let version = robot.attribute("version").unwrap_or("1.0").trim();
        let has_quaternions = version.parse::<f64>().is_ok_and(|version| version >= 1.1);
        Ok(Self { has_quaternions, links, parents, children: children_of })
    }

    /// The link of this name.
    pub(super) fn link(&self, name: &str) -> Option<Element<'a, 'i>> {
        let node = *self.links.get(name)?;
        Some(Element { node, called: format!("link \"{}\"", shown(name)) })
    }

    /// The joints whose parent is the link of this name, in the order of the file.
    pub(super) fn below(&self, link: &str) -> impl Iterator<Item = &Joint<'a, 'i>> {
        self.children.get(link).into_iter().flatten().filter_map(|child| self.parents.get(child))
    }

    /// Whether there is a link of this name.
    ///
    /// # Errors
    /// There is none: what it was asked for as, and names that look like it.
    pub(super) fn has_link(&self, role: &'static str, name: &str) -> Result<(), UrdfError> {
        if self.links.contains_key(name) {
            return Ok(());
        }
        let help = alternatives(name, self.links.keys().copied());
        Err(UrdfError::NoSuchLink { role, name: shown(name), help })
    }

    /// The link that hangs on no other.
    ///
    /// # Errors
    /// There is none, or there are several.
    pub(super) fn root(&self) -> Result<&'a str, UrdfError> {
        let mut roots: Vec<_> =
            self.links.keys().copied().filter(|link| !self.parents.contains_key(link)).collect();
        roots.sort_unstable();
        match roots.as_slice() {
            [root] => Ok(root),
            roots => Err(UrdfError::NoRoot { roots: roots.iter().map(|root| shown(root)).collect() }),
        }
    }

    /// The joints from `base` to `tip`, in that order.
    ///
    /// # Errors
    /// A link that is not there, a tip that does not hang on the base, a loop.
    pub(super) fn path(&self, base: &str, tip: &str) -> Result<Vec<Joint<'a, 'i>>, UrdfError> {
        for (role, name) in [("base", base), ("tip", tip)] {
            self.has_link(role, name)?;
        }
        let mut path = self.upwards(tip, base)?;
        let top = path.last().map_or(tip, |joint| joint.parent);
        if top != base {
            let swapped = self.upwards(base, tip).is_ok_and(|p| p.last().is_some_and(|j| j.parent == tip));
            let help = if swapped {
                "it is the other way round: swap base and tip".to_owned()
            } else {
                format!("its topmost link is \"{}\": write that as base, or one below it", shown(top))
            };
            return Err(UrdfError::NotBelow { base: shown(base), tip: shown(tip), help });
        }
        path.reverse();
        Ok(path)
    }

    /// The joints from `link` upwards, to `end` or to the root.
    fn upwards(&self, link: &str, end: &str) -> Result<Vec<Joint<'a, 'i>>, UrdfError> {
        let (mut path, mut at) = (Vec::new(), link);
        while at != end
            && let Some(joint) = self.parents.get(at)
        {
            if path.len() > self.links.len() {
                return Err(UrdfError::Loop {
                    line: joint.element.line(),
                    joint: shown(joint.name),
                    link: shown(at),
                });
            }
            path.push(joint.clone());
            at = joint.parent;
        }
        Ok(path)
    }
}

/// A joint by its name, with the links that it names.
fn joint<'a, 'i>(node: Node<'a, 'i>) -> Result<Joint<'a, 'i>, UrdfError> {
    let nameless = Element { node, called: "a joint".to_owned() };
    let name = nameless.required_text("name", "<joint name=\"..\" type=\"..\">")?;
    let element = Element { node, called: format!("joint \"{}\"", shown(name)) };
    let parent = element.required("parent", "<parent link=\"..\"/>")?.required_text("link", "link=\"..\"")?;
    let child = element.required("child", "<child link=\"..\"/>")?.required_text("link", "link=\"..\"")?;
    Ok(Joint { name, parent, child, element })
}

fn duplicate(kind: &'static str, name: &str, first: Node<'_, '_>, second: Node<'_, '_>) -> UrdfError {
    UrdfError::DuplicateName { line: line(second), first: line(first), kind, name: shown(name) }
}

/// The names that look like `name`, else some that there are.
fn alternatives<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> String {
    let alike = |other: &str| other.chars().zip(name.chars()).filter(|(a, b)| a == b).count();
    let mut known: Vec<&str> = known.collect();
    known.sort_unstable();
    known.sort_by_key(|other| core::cmp::Reverse(alike(other)));
    let some: Vec<String> = known.iter().take(4).map(|other| shown(other)).collect();
    match some.as_slice() {
        [] => "the file has no links: write <link name=\"..\"/>".to_owned(),
        some => format!("write one of its {} links, such as {}", known.len(), some.join(", ")),
    }
}
