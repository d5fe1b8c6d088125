//! Entries `[robots.NAME]`.

use std::rc::Rc;

use mrroc_core::suggestion::suggestion;
use toml::de::DeTable;

use super::super::entry::{At, Description, RobotEntry};
use super::{Entry, Reader, Value};

pub(in super::super) const ROBOT_KEYS: [&str; 13] = [
    "kind",
    "start",
    "homed",
    "base",
    "tool",
    "mounted_on",
    "stop_ms",
    "file",
    "base_link",
    "tip",
    "acceleration",
    "address",
    "listen",
];

impl Reader {
    pub(super) fn robot(
        &mut self,
        Entry { name, table }: Entry<'_>,
        robots: &[String],
    ) -> Option<RobotEntry> {
        self.known(table, &ROBOT_KEYS, "a robot has");
        let start =
            table.get("start").and_then(|value| self.numbers(value, "a list of joint positions [rad or m]"));
        let homed = table.get("homed").and_then(|value| self.truth(value, "true or false"));
        let base = table.get("base").and_then(|value| self.pose(value));
        let tool = table.get("tool").and_then(|value| self.pose(value));
        let mounted_on = table.get("mounted_on").and_then(|value| self.carrier(value, &name.value, robots));
        let stop_time = table.get("stop_ms").and_then(|value| self.duration(value));
        let description = self.description(table);
        let Some(kind) = table.get("kind") else {
            let what = format!("robot `{}` has no `kind`", name.value);
            self.complain(&name.span, what, "write kind = \"irp6\" or another kind".to_owned());
            return None;
        };
        let text = self.text(kind, "the name of a kind of robot, in quotes")?.to_owned();
        let kind = At { value: text, span: kind.span() };
        let source = Rc::clone(&self.source);
        Some(RobotEntry { source, name, kind, start, homed, base, tool, mounted_on, stop_time, description })
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
        let acceleration = table
            .get("acceleration")
            .and_then(|value| self.numbers(value, "a list of accelerations [rad/s² or m/s²]"));
        Description { file, base_link, tip, acceleration, address, listen, asked: Rc::default() }
    }
}
