//! What pages ask of taught poses.
//!
//! In: requests to teach, rename, forget, or to see the way to a pose. Out: changed files, and answers. Files may take their time: a
//! thread that is no page's waits for them, so that stops and holds of all pages go on meanwhile.

use std::sync::Arc;

use mrroc_core::fault::Name;
use serde_json::json;

use crate::desk::Shown;
use crate::rules::authority::Page;
use crate::rules::request::Asked;
use crate::server::Panel;
use crate::socket::{Answers, DoesNotRead, answer};

/// Places on the way to a pose that a page is shown.
const PLACES: usize = 60;

/// What has become of a request.
enum Told {
    /// In words, for all pages.
    Changed(String),
    /// The way of a robot's tool \[m\].
    Way(Vec<[f64; 3]>),
}

/// Begins to do what a page asks for of a cell that showed this; the page is answered when that is done.
///
/// # Errors
/// [`DoesNotRead`]
pub fn begin(
    panel: &Arc<Panel>,
    page: Page,
    number: u64,
    asked: Asked,
    shown: Shown,
    answers: &Answers,
) -> Result<(), DoesNotRead> {
    let Ok(place) = Arc::clone(&panel.files).try_acquire_owned() else {
        return answer(answers, number, "refused", "the files of the poses do not answer: ask again");
    };
    let (panel, answers) = (Arc::clone(panel), answers.clone());
    tokio::spawn(async move {
        let of = Arc::clone(&panel);
        let work = move || {
            let outcome = work(&of, &asked, &shown);
            if let Ok(Told::Changed(_)) = &outcome {
                of.tell_taught();
            }
            drop(place);
            outcome
        };
        let outcome = match tokio::task::spawn_blocking(work).await {
            Ok(outcome) => outcome,
            Err(_) => Err("the panel is ending".to_owned()),
        };
        // A page that does not read is disconnected by what reads it.
        let _ = match outcome {
            Ok(Told::Changed(told)) => {
                panel.note(&format!("page {page}: {told}"));
                answer(&answers, number, "done", &told)
            }
            Ok(Told::Way(way)) => {
                let said = json!({"kind": "answer", "n": number, "outcome": "done", "text": "", "way": way});
                answers.try_send(said.to_string().into()).map_err(|_| DoesNotRead)
            }
            Err(why) => answer(&answers, number, "refused", &why),
        };
    });
    Ok(())
}

/// Teaches a robot that stands its pose, changes what it was taught, or finds the way to it; it may take its time.
fn work(panel: &Panel, asked: &Asked, shown: &Shown) -> Result<Told, String> {
    let poses = panel.poses.as_ref().ok_or("this panel keeps no poses")?;
    let known = |robot: &Name| match panel.looks.robots().any(|known| known == robot.as_str()) {
        true => Ok(()),
        false => Err(format!("there is no robot `{robot}`")),
    };
    match asked {
        Asked::Teach(robot, name, _) => {
            let now = shown.robots.iter().find(|now| now.name == robot.as_str());
            let now = now.ok_or_else(|| format!("there is no robot `{robot}`"))?;
            if shown.moves {
                return Err("robots move: let them come to rest, and teach then".to_owned());
            }
            let file = poses.teach(robot.as_str(), *name, &now.demanded)?;
            Ok(Told::Changed(format!("taught {robot} `{name}`: {}", file.display())))
        }
        Asked::Rename(robot, name, to) => {
            known(robot)?;
            poses.rename(robot.as_str(), *name, *to)?;
            Ok(Told::Changed(format!("{robot}: `{name}` is now `{to}`")))
        }
        Asked::Forget(robot, name) => {
            known(robot)?;
            poses.forget(robot.as_str(), *name)?;
            Ok(Told::Changed(format!("{robot}: `{name}` is forgotten")))
        }
        Asked::Way(robot, name) => {
            let poses = poses.of_robot(robot.as_str())?;
            let pose = poses.iter().find(|pose| pose.name == *name);
            let pose = pose.ok_or_else(|| format!("there is no pose `{name}`"))?;
            panel.looks.way(&shown.robots, robot.as_str(), &pose.joints, PLACES).map(Told::Way)
        }
        _ => Err("that is no teaching".to_owned()),
    }
}
