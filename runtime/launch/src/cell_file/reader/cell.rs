//! What is said of the cell as a whole.

use core::time::Duration;

use mrroc_core::cell::realtime::MAX_PRIORITY;
use mrroc_core::cell::{AfterFault, Permission, Realtime};
use mrroc_core::observe::Recording;
use mrroc_core::suggestion::suggestion;
use toml::de::{DeTable, DeValue};

use super::{Reader, Value};

pub(in super::super) const CELL_KEYS: [&str; 14] = [
    "step_ms",
    "stop_ms",
    "after_fault",
    "robots",
    "cells",
    "sensors",
    "topics",
    "frames",
    "obstacles",
    "tools",
    "nodes",
    "realtime",
    "dry_run",
    "recording",
];
pub(in super::super) const REALTIME_KEYS: [&str; 4] = ["priority", "lock_memory", "cores", "permission"];
pub(in super::super) const RECORDING_KEYS: [&str; 3] = ["file", "robots", "sensors"];
const AFTER_FAULT: [&str; 2] = ["end", "await reset"];
const PERMISSIONS: [&str; 2] = ["required", "best effort"];

impl Reader {
    pub(super) fn step(&mut self, table: &DeTable<'_>) -> Duration {
        match table.get("step_ms") {
            Some(value) => self.duration(value).unwrap_or_default(),
            None => {
                let help = "write step_ms = 2 as the first line, or another step that fits the robots' servo periods";
                self.complain(&(0..0), "the cell has no `step_ms`".to_owned(), help.to_owned());
                Duration::ZERO
            }
        }
    }

    /// Reads what the cell does after a fault.
    pub(super) fn after_fault(&mut self, value: &Value<'_>) -> Option<AfterFault> {
        match self.text(value, "\"end\" or \"await reset\"")? {
            "end" => Some(AfterFault::End),
            "await reset" => Some(AfterFault::AwaitReset),
            other => {
                let help = suggestion(other, &AFTER_FAULT, "a cell can");
                self.complain(&value.span(), format!("no way to go on after a fault `{other}`"), help);
                None
            }
        }
    }

    pub(super) fn realtime(&mut self, value: &Value<'_>) -> Option<Realtime> {
        let DeValue::Table(table) = value.get_ref() else {
            self.wrong_type(value, "a table [realtime]");
            return None;
        };
        self.known(table, &REALTIME_KEYS, "[realtime] has");
        let locks = table.get("lock_memory").map(|value| self.truth(value, "true or false"));
        let cores = table.get("cores").map(|value| {
            let numbers = self.numbers(value, "a list of cores, counted from 0")?.value;
            numbers.iter().map(|core| self.whole(core, 0..=1023, "the number of a core, 0 to 1023")).collect()
        });
        let permission = match table.get("permission") {
            None => Some("required"),
            Some(value) => self.text(value, "\"required\" or \"best effort\"").filter(|text| {
                let known = PERMISSIONS.contains(text);
                if !known {
                    let help = suggestion(text, &PERMISSIONS, "there are");
                    self.complain(&value.span(), format!("no permission `{text}`"), help);
                }
                known
            }),
        };
        let Some(priority) = table.get("priority") else {
            let help = "write priority = 50, or another one from 1 to 95";
            self.complain(&value.span(), "[realtime] has no `priority`".to_owned(), help.to_owned());
            return None;
        };
        let range = "a priority from 1 to 95";
        let priority = self.number(priority, range)?;
        let priority = self.whole(&priority, 1..=usize::from(MAX_PRIORITY), range)?;
        let permission =
            if permission? == "required" { Permission::Required } else { Permission::BestEffort };
        Some(Realtime {
            permission,
            priority: u8::try_from(priority).ok()?,
            lock_memory: locks.map_or(Some(true), |locks| Some(locks?.value))?,
            cores: cores.map_or(Some(None), |cores: Option<Vec<usize>>| Some(Some(cores?)))?,
        })
    }

    pub(super) fn recording(
        &mut self,
        value: &Value<'_>,
        there: [(&str, &Vec<String>); 2],
    ) -> Option<Recording> {
        let DeValue::Table(table) = value.get_ref() else {
            self.wrong_type(value, "a table [recording]");
            return None;
        };
        self.known(table, &RECORDING_KEYS, "[recording] has");
        let [robots, sensors] = there.map(|(key, there)| {
            table
                .get(key)
                .map(|value| self.names(value, key, there))
                .map_or(Some(None), |names| Some(Some(names?)))
        });
        let Some(file) = table.get("file") else {
            let help = "write file = \"run.mcap\", or leave [recording] out";
            self.complain(&value.span(), "[recording] has no `file`".to_owned(), help.to_owned());
            return None;
        };
        let mut recording = Recording::to(self.text(file, "the name of a file, in quotes")?);
        if let Some(names) = robots? {
            recording = recording.robots(names.iter().map(String::as_str));
        }
        if let Some(names) = sensors? {
            recording = recording.sensors(names.iter().map(String::as_str));
        }
        Some(recording)
    }
}
