//! Entries `[sensors.NAME]`.

use core::time::Duration;

use mrroc_core::sensor::VspMode;
use mrroc_core::suggestion::suggestion;

use super::super::entry::SensorEntry;
use super::external::Around;
use super::{Entry, Reader};

pub(in super::super) const SENSOR_KEYS: [&str; 9] =
    ["of", "readers", "mode", "period_ms", "latency_ms", "every", "stale_after_ms", "node", "external"];
const MODES: [&str; 3] = ["interactive", "with delay", "free running"];

impl Reader {
    pub(super) fn sensor(
        &mut self,
        Entry { name, table }: Entry<'_>,
        robots: &[String],
        step: Duration,
    ) -> Option<SensorEntry> {
        self.known(table, &SENSOR_KEYS, "a sensor has");
        let of = table.get("of").and_then(|value| {
            let robot = self.text(value, "the name of a robot, in quotes")?.to_owned();
            if !robots.contains(&robot) {
                let known: Vec<_> = robots.iter().map(String::as_str).collect();
                let what = format!("sensor `{}` belongs to robot `{robot}`, which is not there", name.value);
                self.complain(&value.span(), what, suggestion(&robot, &known, "the robots are"));
            }
            Some(robot)
        });
        let readers = table.get("readers").and_then(|value| self.names(value, "robots", robots));
        let stale_after = table.get("stale_after_ms").and_then(|value| self.duration(value));
        let every = table.get("every").and_then(|value| {
            let range = "a whole number of steps from 1 to 1000";
            let every = self.number(value, range)?;
            self.whole(&every, 1..=1000, range)
        });
        let every = every.and_then(|steps| u32::try_from(steps).ok());
        let latency = table.get("latency_ms").and_then(|value| self.duration(value));
        let period = table.get("period_ms").map(|value| (value, self.duration(value)));
        let mode = match table.get("mode") {
            None => Some("interactive"),
            Some(value) => self.text(value, "the name of a mode, in quotes").filter(|mode| {
                let known = MODES.contains(mode);
                if !known {
                    let what = format!("no mode `{mode}`");
                    self.complain(&value.span(), what, suggestion(mode, &MODES, "a sensor's modes are"));
                }
                known
            }),
        };
        let mode = match (mode?, period) {
            ("free running", Some((_, period))) => VspMode::NonInteractive(period?),
            ("free running", None) => {
                let what = format!("sensor `{}` runs freely and has no `period_ms`", name.value);
                self.complain(&name.span, what, "write period_ms = 5 or another period".to_owned());
                return None;
            }
            (_, Some((value, _))) => {
                let what = "only a free-running sensor has a period".to_owned();
                self.complain(
                    &value.span(),
                    what,
                    "leave it out, or write mode = \"free running\"".to_owned(),
                );
                return None;
            }
            ("with delay", None) => VspMode::WithDelay,
            (_, None) => VspMode::Interactive,
        };
        let node = table.get("node").and_then(|value| self.node(value));
        let external = match table.get("external") {
            Some(value) => {
                let around = Around { name: &name, mode, stale_after, step };
                Some(self.external(value, &around)?)
            }
            None => None,
        };
        let latency = latency.unwrap_or_default();
        Some(SensorEntry { name: name.value, of, readers, every, stale_after, mode, latency, node, external })
    }
}
