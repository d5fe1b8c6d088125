//! A recording, as a page plays it.
//!
//! In: an MCAP file that `--record` has written. Out: the history of its run; what a page does not show is passed over.

use std::path::Path;

use mrroc_core::nalgebra::{Quaternion, Translation3, UnitQuaternion};
use mrroc_core::observe::layout::{Layout, SignalLayout};
use mrroc_core::observe::step_observer::StepRecord;
use mrroc_core::operator::state::InstructionKind;
use mrroc_core::pose::Pose;
use mrroc_core::robot::{Signals, Value as Signal};
use serde_json::Value;

use crate::readings::of_json;
use crate::run_history::RunHistory;

/// The largest file that is played \[bytes\].
const LARGEST: u64 = 1 << 30;

/// Reads a recording of a cell of this layout; of one that was cut off, what there is.
///
/// # Errors
/// What is wrong with the file.
pub fn read(file: &Path, layout: &Layout) -> Result<RunHistory, String> {
    let named = |what: &str| format!("{}: {what}", file.display());
    if file.metadata().is_ok_and(|about| about.len() > LARGEST) {
        return Err(named("is larger than 1 GiB\n help: record a shorter run, or fewer robots"));
    }
    let mut history = RunHistory::of(layout);
    let (mut start, mut last) = (None, 0);
    let read = mrroc_recording::each_message(file, |topic, at, data| {
        let time = at.saturating_sub(*start.get_or_insert(at));
        last = last.max(time);
        take(&mut history, layout, time, topic, data);
    });
    read.map_err(|wrong| wrong.to_string())?;
    history.end(last, None);
    if history.lasts() == 0.0 {
        let help = "give a file that --record has written, of this cell";
        return Err(named(&format!("shows no robot of this cell\n help: {help}")));
    }
    Ok(history)
}

fn take(history: &mut RunHistory, layout: &Layout, time: u64, topic: &str, data: &[u8]) {
    let json = || serde_json::from_slice::<Value>(data).ok();
    if topic == "/steps" {
        let Some(json) = json() else { return };
        let is = |name: &str| json[name].as_bool().unwrap_or(false);
        let number = |name: &str| json[name].as_f64().unwrap_or(0.0);
        history.step(
            time,
            &StepRecord {
                step: json["step"].as_u64().unwrap_or(0),
                dt: number("dt"),
                duration: number("duration"),
                speed: number("speed"),
                suspended: is("suspended"),
                reduced: is("reduced"),
                aborting: is("aborting"),
                stopping: is("stopping"),
                resetting: is("resetting"),
            },
        );
    } else if topic == "/instructions" {
        let Some(json) = json() else { return };
        let (process, by) = (json["process"].as_str().unwrap_or(""), json["by"].as_str().unwrap_or(""));
        let word = json["doing"].as_str().unwrap_or("");
        if let Some(doing) = InstructionKind::ALL.into_iter().find(|doing| doing.word() == word) {
            history.instruction(process, doing, by);
        }
    } else if topic == "/events" {
        let Some(json) = json() else { return };
        let text = json["text"].as_str().unwrap_or("").to_owned();
        let is_mp = json["process"].as_str() == Some("mp");
        if matches!(json["what"].as_str(), Some("fault" | "end")) && is_mp && !text.is_empty() {
            history.fault(text, None);
        }
    } else if let Some(name) = topic.strip_prefix("/bodies/") {
        let place = layout.bodies.iter().position(|body| body.name == name);
        if let (Some(place), Some(pose)) = (place, json().and_then(|json| pose(&json["pose"]))) {
            history.body(place, pose);
        }
    } else if let Some(name) = topic.strip_prefix("/sensors/") {
        let known = layout.sensors.iter().enumerate().find(|(_, sensor)| sensor.name == name);
        if let (Some((place, sensor)), Some(json)) = (known, json()) {
            match json["state"].as_str() {
                Some("there") => {
                    history.reading(time, place, Some(of_json(sensor.reading, &json["reading"])))
                }
                Some("fault") => history.reading(time, place, None),
                _ => {}
            }
        }
    } else if let Some(name) = topic.strip_prefix("/robots/").and_then(|rest| rest.strip_suffix("/signals")) {
        let robot = layout.robots.iter().find(|robot| robot.name == name);
        if let (Some(robot), Some(json)) = (robot, json()) {
            history.signals(name, signals(&robot.signals, &json));
        }
    } else if let Some(name) = topic.strip_prefix("/robots/").filter(|name| !name.contains('/'))
        && history.is_due(time)
        && let Some(json) = json()
        && let (Some(tool), Some(in_force)) = (pose(&json["measured"]["pose"]), pose(&json["tool"]))
    {
        let joints = |of: &str| {
            let joints = json[of]["joints"].as_array().map(Vec::as_slice).unwrap_or_default();
            joints.iter().map(|q| q.as_f64().unwrap_or(f64::NAN)).collect::<Vec<_>>()
        };
        history.robot(time, name, [&joints("demanded"), &joints("measured")], [tool, in_force]);
    }
}

/// Reads what inputs read and outputs are; one that is not there is off.
fn signals(known: &[SignalLayout], json: &Value) -> Signals {
    let mut signals = Signals::OFF;
    for SignalLayout { name, channel, is_output, .. } in known {
        let (of, values) = match is_output {
            true => ("outputs", &mut signals.outputs),
            false => ("inputs", &mut signals.inputs),
        };
        let value = &json[of][name];
        let digital = || value.as_bool().map(Signal::Digital);
        if let Some(value) = value.as_f64().map(Signal::Analog).or_else(digital) {
            values.set(*channel, value);
        }
    }
    signals
}

/// Reads a pose.
fn pose(value: &Value) -> Option<Pose> {
    let of = |part: &str, name: &str| value[part][name].as_f64();
    let (at, turn) = (|name: &str| of("position", name), |name: &str| of("orientation", name));
    let turned = Quaternion::new(turn("w")?, turn("x")?, turn("y")?, turn("z")?);
    let turned = UnitQuaternion::try_new(turned, 1e-6)?;
    Some(Pose::from_parts(Translation3::new(at("x")?, at("y")?, at("z")?), turned))
}
