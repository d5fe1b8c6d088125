//! An arm from a URDF of the user's: what its project must know of it before mrroc reads it.
//!
//! In: the file and the link that is the flange. Out: the number of joints, a bent posture to start from, and accelerations.
//! mrroc reads the file more strictly, when the project runs.

use std::collections::HashMap;
use std::path::Path;

use roxmltree::{Document, Node};

use crate::choices::Chosen;
use crate::error::Error;
use crate::suggestion;

/// A posture that is singular for hardly any arm \[rad\].
const BENT: [f64; 8] = [0.3, 0.6, -0.9, 0.5, 0.7, 0.2, 0.4, -0.3];

/// Seconds in which a joint shall be able to brake: with the time to notice a fault that is within the 600 ms of a cell.
const BRAKING: f64 = 0.5;

/// An arm of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    /// The text of the file.
    pub text: String,
    /// Of each joint, from the base on, where it starts [rad or m] and how it may be accelerated [rad/s² or m/s²].
    pub joints: Vec<(f64, f64)>,
}

impl Arm {
    /// The arm that was chosen, if one from a file was.
    ///
    /// # Errors
    /// [`Error::Refused`]: the file cannot be read, it is no URDF, or no arm ends at the flange.
    pub fn of(chosen: &Chosen) -> Result<Option<Arm>, Error> {
        let text =
            |wanted: &str| chosen.iter().find(|(name, _)| name == wanted).map(|(_, value)| value.to_string());
        match (text("urdf"), text("tip")) {
            (Some(file), Some(tip)) => Arm::read(Path::new(&file), &tip).map(Some),
            _ => Ok(None),
        }
    }

    fn read(file: &Path, tip: &str) -> Result<Arm, Error> {
        let refused =
            |what: String, help: &str| Error::refused(format!("{}: {what}", file.display()), help.to_owned());
        let text = std::fs::read_to_string(file).map_err(|error| {
            refused(format!("it cannot be read: {error}"), "give a URDF by `--define urdf=FILE`")
        })?;
        let expand = "expand xacro first: xacro robot.urdf.xacro > robot.urdf";
        let document =
            Document::parse(&text).map_err(|error| refused(format!("not a URDF: {error}"), expand))?;
        let robot = document.root_element();
        let is_xacro =
            |node: &Node<'_, '_>| node.tag_name().namespace().is_some_and(|uri| uri.contains("xacro"));
        if robot.descendants().any(|node| is_xacro(&node)) {
            return Err(refused("it is xacro, not a URDF".to_owned(), expand));
        }
        let named = |node: Node<'_, '_>, child: &str| {
            node.children()
                .find(|n| n.has_tag_name(child))
                .and_then(|n| n.attribute("link"))
                .map(str::to_owned)
        };
        let links: Vec<_> = children(robot, "link").filter_map(|link| link.attribute("name")).collect();
        if !links.contains(&tip) {
            let help = suggestion::help(
                tip,
                "choose the flange by `--define tip=..`; its links are",
                links.iter().copied(),
            );
            return Err(refused(format!("it has no link `{tip}`"), &help));
        }
        let above: HashMap<_, _> =
            children(robot, "joint").filter_map(|joint| Some((named(joint, "child")?, joint))).collect();
        let mut joints = Vec::new();
        let mut at = tip.to_owned();
        // No more joints than there are, in case they close a loop.
        for _ in 0..above.len() {
            let Some(joint) = above.get(&at) else { break };
            let follows = children(*joint, "mimic").next().is_some();
            if joint.attribute("type") != Some("fixed") && !follows {
                joints.push(*joint);
            }
            at = named(*joint, "parent").unwrap_or_default();
        }
        if joints.is_empty() || joints.len() > BENT.len() {
            let what = format!("{} joints move link `{tip}`, a robot has 1 to {}", joints.len(), BENT.len());
            return Err(refused(what, "choose another link as the flange by `--define tip=..`"));
        }
        let joints = joints.iter().rev().zip(BENT).map(|(joint, bent)| start(*joint, bent)).collect();
        Ok(Arm { text, joints })
    }

    /// What the template is told of it: lists for cell.toml.
    #[must_use]
    pub fn values(&self) -> [(String, String); 2] {
        let list = |of: fn(&(f64, f64)) -> f64| {
            let numbers: Vec<_> =
                self.joints.iter().map(|joint| format!("{:?}", (of(joint) * 1e3).round() / 1e3)).collect();
            format!("[{}]", numbers.join(", "))
        };
        [
            ("joints_start".to_owned(), list(|joint| joint.0)),
            ("joints_acceleration".to_owned(), list(|joint| joint.1)),
        ]
    }
}

fn children<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

/// Where a joint starts, within its limits, and an acceleration by which it can brake in time.
fn start(joint: Node<'_, '_>, bent: f64) -> (f64, f64) {
    let limit = children(joint, "limit").next();
    let number =
        |name: &str| limit?.attribute(name)?.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    let (lower, upper) = match joint.attribute("type") {
        Some("continuous") => (f64::NEG_INFINITY, f64::INFINITY),
        _ => (number("lower").unwrap_or(0.0), number("upper").unwrap_or(0.0)),
    };
    let middle = 0.5 * (lower + upper);
    let start = if joint.attribute("type") == Some("prismatic") || lower >= upper {
        middle
    } else {
        // A joint that cannot bend in this direction bends as far in the other, or stands in its middle.
        [bent, -bent].into_iter().find(|q| (lower..=upper).contains(q)).unwrap_or(middle)
    };
    let acceleration = number("acceleration").unwrap_or_else(|| number("velocity").unwrap_or(1.0) / BRAKING);
    (start, acceleration)
}
