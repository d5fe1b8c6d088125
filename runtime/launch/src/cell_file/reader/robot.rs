//! Entries `[robots.NAME]`.

use std::io::Read;
use std::path::Path;
use std::rc::Rc;

use mrroc_core::pose::Pose;
use mrroc_core::robot::{Load, Tool};
use mrroc_core::suggestion::suggestion;
use toml::de::DeTable;

use crate::files;

use super::super::entry::{Description, RobotEntry};
use super::super::error::{At, CellFileError, Source};
use super::pose::{IN_CELL, ON_FLANGE};
use super::{Entry, Reader, Value};

pub(in super::super) const ROBOT_KEYS: [&str; 21] = [
    "kind",
    "start",
    "homed",
    "base",
    "tool",
    "mounted_on",
    "stop_ms",
    "node",
    "plant",
    "inputs",
    "outputs",
    "file",
    "base_link",
    "tip",
    "acceleration",
    "address",
    "listen",
    "period_ms",
    "corrections",
    "calibration",
    "coupled",
];

/// The largest file with a base \[bytes\].
const MOST: u64 = 1 << 20;

/// Farther from the world's origin a base is not \[m\].
const FARTHEST: f64 = 1e3;

/// Reads the table `[frames.base]` of a file that a calibration has written.
fn read_base(path: &Path) -> Result<Pose, String> {
    let name = path.display().to_string();
    let unreadable = |why| format!("the base in {name}: it cannot be read: {why}");
    let mut text = String::new();
    let file = files::open(path).map_err(|why| unreadable(why.to_string()))?;
    file.take(MOST).read_to_string(&mut text).map_err(|why| unreadable(why.to_string()))?;
    let table = DeTable::parse(&text).map_err(|_| format!("the base in {name}: it is no TOML"))?;
    let frame = table.get_ref().get("frames").and_then(|frames| frames.get_ref().get("base"));
    let frame = frame.ok_or_else(|| format!("the base in {name}: it has no table [frames.base]"))?;
    let mut reader = Reader::of(Rc::new(Source { file: name.clone(), text: text.clone() }));
    let base = reader.pose(frame, FARTHEST);
    // Nobody would answer a question about a number that a program has written.
    reader.errors.append(&mut reader.questions);
    CellFileError::all(reader.errors).map_err(|wrong| format!("the base in {}", wrong.causes()))?;
    base.ok_or_else(|| format!("the base in {name}: [frames.base] is no pose"))
}

impl Reader {
    pub(super) fn robot(
        &mut self,
        Entry { name, table }: Entry<'_>,
        robots: &[String],
        tools: &[(String, Tool)],
    ) -> Option<RobotEntry> {
        self.known(table, &ROBOT_KEYS, "a robot has");
        let start =
            table.get("start").and_then(|value| self.numbers(value, "a list of joint positions [rad or m]"));
        let homed = table.get("homed").and_then(|value| self.truth(value, "true or false"));
        let farthest = if table.contains_key("mounted_on") { ON_FLANGE } else { IN_CELL };
        let base = table.get("base").and_then(|value| match value.get_ref().as_str() {
            Some(file) => self.calibrated_base(value, file),
            None => self.pose(value, farthest),
        });
        let tool = table.get("tool").and_then(|value| self.tool_of_robot(value, tools));
        let inputs = table.get("inputs").map_or_else(Vec::new, |value| self.inputs(value));
        let outputs = table.get("outputs").map_or_else(Vec::new, |value| self.outputs(value));
        let mounted_on = table.get("mounted_on").and_then(|value| self.carrier(value, &name.value, robots));
        let stop_time = table.get("stop_ms").and_then(|value| self.duration(value));
        let node = table.get("node").and_then(|value| self.node(value));
        let plant = table.get("plant").and_then(|value| self.plant(value, &name.value));
        let description = self.description(table);
        let Some(kind) = table.get("kind") else {
            let what = format!("robot `{}` has no `kind`", name.value);
            self.complain(&name.span, what, "write kind = \"irp6\" or another kind".to_owned());
            return None;
        };
        let text = self.text(kind, "the name of a kind of robot, in quotes")?.to_owned();
        let kind = At { value: text, span: kind.span() };
        let source = Rc::clone(&self.source);
        Some(RobotEntry {
            source,
            name,
            kind,
            start,
            homed,
            base,
            tool,
            mounted_on,
            stop_time,
            node,
            inputs,
            outputs,
            plant,
            description,
        })
    }

    /// Reads the base from a file that a calibration has written.
    fn calibrated_base(&mut self, value: &Value<'_>, file: &str) -> Option<Pose> {
        let path = Path::new(&self.source.file).parent().unwrap_or(Path::new("")).join(file);
        match read_base(&path) {
            Ok(base) => Some(base),
            Err(what) => {
                let help =
                    "name a file that `calibrate` has written, or write { xyz = [x, y, z], rpy = [..] }";
                self.complain(&value.span(), what, help.to_owned());
                None
            }
        }
    }

    /// Reads the tool at the start: a pose, or the name of one of the cell's tools.
    fn tool_of_robot(&mut self, value: &Value<'_>, tools: &[(String, Tool)]) -> Option<Tool> {
        let Some(name) = value.get_ref().as_str() else {
            return self.pose(value, ON_FLANGE).map(|frame| Tool { frame, load: Load::NONE });
        };
        let found = tools.iter().find(|(known, _)| known == name);
        if found.is_none() {
            let names: Vec<_> = tools.iter().map(|(name, _)| name).collect();
            let help = match names.is_empty() {
                true => format!("write a table [tools.{name}], or a pose"),
                false => suggestion(name, &names, "the cell has"),
            };
            self.complain(&value.span(), format!("no tool `{name}`"), help);
        }
        found.map(|(_, tool)| *tool)
    }

    /// Reads the name of the robot on which `robot` is mounted.
    pub(super) fn carrier(
        &mut self,
        value: &Value<'_>,
        robot: &str,
        robots: &[String],
    ) -> Option<At<String>> {
        let on = self.text(value, "the name of a robot, in quotes")?.to_owned();
        let others: Vec<_> = robots.iter().map(String::as_str).filter(|other| *other != robot).collect();
        if !others.contains(&on.as_str()) {
            let what = format!("robot `{robot}` is mounted on `{on}`, which is no other robot of the cell");
            self.complain(&value.span(), what, suggestion(&on, &others, "the others are"));
            return None;
        }
        Some(At { value: on, span: value.span() })
    }

    /// Reads what only some kinds ask for: of a robot that another file describes, of one on a network.
    pub(super) fn description(&mut self, table: &DeTable<'_>) -> Description {
        let mut text = |key: &str, expected: &str| {
            let value = table.get(key)?;
            let text = self.text(value, expected)?.to_owned();
            Some(At { value: text, span: value.span() })
        };
        let file = text("file", "the name of a file, in quotes");
        let base_link = text("base_link", "the name of a link, in quotes");
        let tip = text("tip", "the name of a link, in quotes");
        let address = text("address", "the address of a controller, in quotes");
        let listen = text("listen", "an address of this machine and a port, in quotes");
        let corrections = text("corrections", "a word, in quotes");
        let calibration = text("calibration", "the name of a file, in quotes");
        let acceleration = table
            .get("acceleration")
            .and_then(|value| self.numbers(value, "a list of accelerations [rad/s² or m/s²]"));
        let coupled = table.get("coupled").and_then(|value| self.truth(value, "true or false"));
        let period = table
            .get("period_ms")
            .and_then(|value| Some(At { value: self.duration(value)?, span: value.span() }));
        Description {
            file,
            base_link,
            tip,
            acceleration,
            address,
            listen,
            period,
            corrections,
            calibration,
            coupled,
            asked: Rc::default(),
        }
    }
}
