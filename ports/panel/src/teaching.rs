//! What pages ask of taught poses.
//!
//! In: requests to teach, rename, forget, or to see the path to a pose. Out: changed files, and answers. Files may take their time: a
//! thread that is no page's waits for them, so that stops and holds of all pages go on meanwhile.

use axum::extract::ws::Utf8Bytes;
use mrroc_core::fault::Name;
use serde_json::json;

use crate::console_session::CellSnapshot;
use crate::now::Appearance;
use crate::poses::{Pose, Poses};
use crate::rules::request::PageRequest;

/// Places on the path to a pose that a page is shown.
const PLACES: usize = 60;

/// What has become of a request.
#[derive(Debug)]
pub enum WorkOutcome {
    /// In words, for all pages.
    Changed(String),
    /// The path of a robot's tool \[m\].
    ToolPath(Vec<[f64; 3]>),
}

/// Which poses the robots of a cell were taught, as the files say, which may take their time.
pub fn taught(poses: &Poses, looks: &Appearance) -> Utf8Bytes {
    let of = |robot: &str| match poses.of_robot(robot) {
        Ok(poses) => {
            let pose = |pose: &Pose| json!({"name": pose.name.as_str(), "joints": pose.joints});
            json!({"poses": poses.iter().map(pose).collect::<Vec<_>>()})
        }
        Err(why) => json!({"poses": [], "why": why}),
    };
    let robots: serde_json::Map<_, _> = looks.robots().map(|robot| (robot.to_owned(), of(robot))).collect();
    json!({"kind": "poses", "robots": robots}).to_string().into()
}

/// Does what a page asks for of a cell that showed this; and which poses robots were taught, if that has changed. It may take its time.
pub fn carry_out(
    poses: Option<&Poses>,
    looks: &Appearance,
    asked: &PageRequest,
    shown: &CellSnapshot,
) -> (Result<WorkOutcome, String>, Option<Utf8Bytes>) {
    let Some(poses) = poses else { return (Err("this panel keeps no poses".to_owned()), None) };
    let outcome = work(poses, looks, asked, shown);
    let has_changed = matches!(outcome, Ok(WorkOutcome::Changed(_)));
    (outcome, has_changed.then(|| taught(poses, looks)))
}

/// Teaches a robot that stands its pose, changes what it was taught, or finds the path to it.
fn work(
    poses: &Poses,
    looks: &Appearance,
    asked: &PageRequest,
    shown: &CellSnapshot,
) -> Result<WorkOutcome, String> {
    let known = |robot: &Name| match looks.robots().any(|known| known == robot.as_str()) {
        true => Ok(()),
        false => Err(format!("there is no robot `{robot}`")),
    };
    match asked {
        PageRequest::Teach(robot, name, _) => {
            let now = shown.robots.iter().find(|now| now.name == robot.as_str());
            let now = now.ok_or_else(|| format!("there is no robot `{robot}`"))?;
            if shown.moves {
                return Err("robots move: let them come to rest, and teach then".to_owned());
            }
            let file = poses.teach(robot.as_str(), *name, &now.demanded)?;
            Ok(WorkOutcome::Changed(format!("taught {robot} `{name}`: {}", file.display())))
        }
        PageRequest::Rename(robot, name, to) => {
            known(robot)?;
            poses.rename(robot.as_str(), *name, *to)?;
            Ok(WorkOutcome::Changed(format!("{robot}: `{name}` is now `{to}`")))
        }
        PageRequest::Forget(robot, name) => {
            known(robot)?;
            poses.forget(robot.as_str(), *name)?;
            Ok(WorkOutcome::Changed(format!("{robot}: `{name}` is forgotten")))
        }
        PageRequest::ToolPath(robot, name) => {
            let poses = poses.of_robot(robot.as_str())?;
            let pose = poses.iter().find(|pose| pose.name == *name);
            let pose = pose.ok_or_else(|| format!("there is no pose `{name}`"))?;
            looks.tool_path(&shown.robots, robot.as_str(), &pose.joints, PLACES).map(WorkOutcome::ToolPath)
        }
        _ => Err("that is no teaching".to_owned()),
    }
}
