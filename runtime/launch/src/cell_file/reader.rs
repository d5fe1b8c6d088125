//! Reads a [`CellFile`].
//!
//! In: the text of the file. Out: a [`CellFile`] in which every key is known and every value has its type and range; or
//! all errors at once.

use core::ops::{Range, RangeInclusive};
use core::time::Duration;
use std::rc::Rc;

use mrroc_core::nalgebra::Translation3;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use mrroc_core::cell::AfterFault;
use mrroc_core::cell::realtime::MAX_PRIORITY;
use mrroc_core::cell::{Permission, Realtime};
use mrroc_core::fault::Name;
use mrroc_core::observe::Recording;
use mrroc_core::pose::{Pose, Zyz};
use mrroc_core::sensor::VspMode;

use super::CellFile;
use super::entry::{At, Description, RobotEntry, SensorEntry};
use super::error::{CellFileError, Source};
use mrroc_core::suggestion::suggestion;

type Value<'t> = Spanned<DeValue<'t>>;

pub(super) const CELL_KEYS: [&str; 8] =
    ["step_ms", "stop_ms", "after_fault", "robots", "sensors", "realtime", "dry_run", "recording"];
pub(super) const RECORDING_KEYS: [&str; 3] = ["file", "robots", "sensors"];
pub(super) const ROBOT_KEYS: [&str; 11] = [
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
];
pub(super) const POSE_KEYS: [&str; 2] = ["position", "zyz"];
pub(super) const SENSOR_KEYS: [&str; 7] =
    ["of", "readers", "mode", "period_ms", "latency_ms", "every", "stale_after_ms"];
/// What to write in place of a line that is no TOML.
const TOML: &str = "write key = value, texts in \"quotes\", lists in [1.0, 2.0], tables as [robots.arm]; a bracket or a quote may be \
                    missing in the line above";
pub(super) const REALTIME_KEYS: [&str; 4] = ["priority", "lock_memory", "cores", "permission"];
const PERMISSIONS: [&str; 2] = ["required", "best effort"];
const AFTER_FAULT: [&str; 2] = ["end", "await reset"];
const MODES: [&str; 3] = ["interactive", "with delay", "free running"];

/// Reads the whole file.
pub(super) fn read(name: &str, text: &str) -> Result<CellFile, CellFileError> {
    let source = Rc::new(Source { file: name.to_owned(), text: text.to_owned() });
    let (document, syntax) = DeTable::parse_recoverable(text);
    let mut reader = Reader { source: Rc::clone(&source), errors: Vec::new() };
    // Other errors are not reported, because they may only follow from the line that is no TOML.
    let place = |error: &toml::de::Error| error.span().unwrap_or(0..0);
    if let Some(error) = syntax.iter().min_by_key(|error| place(error).start) {
        let at = place(error);
        let word = text.get(at.clone()).filter(|word| word.starts_with(char::is_alphabetic));
        let is_value = text[..at.start.min(text.len())].trim_end_matches(' ').ends_with('=');
        match word.filter(|_| is_value) {
            Some(word) => {
                let help = format!("write a text in quotes: \"{word}\"");
                reader.complain(&at, format!("`{word}` is neither a text nor a number"), help);
            }
            None => reader.complain(&at, error.message().to_owned(), TOML.to_owned()),
        }
    }
    CellFileError::all(core::mem::take(&mut reader.errors))?;

    let table = document.get_ref();
    reader.known(table, &CELL_KEYS, "a cell has");
    let step = reader.step(table);
    let stop_time = table.get("stop_ms").and_then(|value| reader.duration(value));
    let after_fault = table.get("after_fault").and_then(|value| reader.after_fault(value));
    let robots = reader.entries(table, "robots");
    let names: Vec<_> = robots.iter().map(|entry| entry.name.value.clone()).collect();
    let robots: Vec<_> = robots.into_iter().filter_map(|entry| reader.robot(entry, &names)).collect();
    if robots.is_empty() && reader.errors.is_empty() {
        let help = "write a table [robots.arm] with the kind of a robot that you will call arm";
        reader.complain(&(0..0), "the cell has no robot".to_owned(), help.to_owned());
    }
    let robot_names = names.clone();
    let sensors: Vec<_> = reader
        .entries(table, "sensors")
        .into_iter()
        .filter_map(|entry| reader.sensor(entry, &names))
        .collect();
    let realtime = table.get("realtime").and_then(|value| reader.realtime(value));
    let names: Vec<_> = sensors.iter().map(|sensor: &SensorEntry| sensor.name.clone()).collect();
    let recording = table
        .get("recording")
        .and_then(|value| reader.recording(value, [("robots", &robot_names), ("sensors", &names)]));
    let dry_run = table.get("dry_run").and_then(|value| reader.truth(value, "true or false"));
    let dry_run = dry_run.is_some_and(|dry_run| dry_run.value);
    CellFileError::all(reader.errors)?;
    Ok(CellFile {
        dry_run,
        recording,
        source,
        step,
        stop_time,
        after_fault: after_fault.unwrap_or_default(),
        realtime,
        robots,
        sensors,
    })
}

struct Reader {
    source: Rc<Source>,
    errors: Vec<CellFileError>,
}

/// A named table: `[robots.NAME]`.
struct Entry<'t> {
    name: At<String>,
    table: &'t DeTable<'t>,
}

impl Reader {
    fn complain(&mut self, at: &Range<usize>, what: String, help: String) {
        self.errors.push(self.source.complain(at, what, help));
    }

    /// Reports the keys that are not known.
    fn known(&mut self, table: &DeTable<'_>, keys: &[&str], owner_has: &str) {
        for key in table.keys() {
            if !keys.contains(&key.get_ref().as_ref()) {
                let what = format!("unknown key `{}`", key.get_ref());
                self.complain(&key.span(), what, suggestion(key.get_ref(), keys, owner_has));
            }
        }
    }

    fn wrong_type(&mut self, value: &Value<'_>, expected: &str) {
        let what = format!("a {} where {expected} is due", value.get_ref().type_str());
        self.complain(&value.span(), what, format!("write {expected}"));
    }

    fn number(&mut self, value: &Value<'_>, expected: &str) -> Option<At<f64>> {
        let parsed = match value.get_ref() {
            DeValue::Integer(integer) => {
                i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|integer| integer as f64)
            }
            DeValue::Float(float) => float.as_str().parse::<f64>().ok(),
            DeValue::String(_)
            | DeValue::Boolean(_)
            | DeValue::Datetime(_)
            | DeValue::Array(_)
            | DeValue::Table(_) => {
                self.wrong_type(value, expected);
                return None;
            }
        };
        let finite = parsed.filter(|number| number.is_finite());
        if finite.is_none() {
            let help = format!("write {expected}");
            self.complain(&value.span(), "not a finite number".to_owned(), help);
        }
        finite.map(|number| At { value: number, span: value.span() })
    }

    fn numbers(&mut self, value: &Value<'_>, expected: &str) -> Option<At<Vec<At<f64>>>> {
        let DeValue::Array(array) = value.get_ref() else {
            self.wrong_type(value, expected);
            return None;
        };
        let numbers: Vec<_> = array.iter().map(|number| self.number(number, "a number")).collect();
        let numbers: Option<Vec<_>> = numbers.into_iter().collect();
        numbers.map(|numbers| At { value: numbers, span: value.span() })
    }

    fn text<'t>(&mut self, value: &'t Value<'_>, expected: &str) -> Option<&'t str> {
        let text = value.get_ref().as_str();
        if text.is_none() {
            self.wrong_type(value, expected);
        }
        text
    }

    fn truth(&mut self, value: &Value<'_>, expected: &str) -> Option<At<bool>> {
        let truth = value.get_ref().as_bool();
        if truth.is_none() {
            self.wrong_type(value, expected);
        }
        truth.map(|truth| At { value: truth, span: value.span() })
    }

    /// Reads a time in milliseconds, from 0.1 ms to a minute.
    fn duration(&mut self, value: &Value<'_>) -> Option<Duration> {
        const RANGE: &str = "a number of milliseconds from 0.1 to 60000";
        let ms = self.number(value, RANGE)?;
        if (0.1..=60e3).contains(&ms.value) {
            // Rounded to whole nanoseconds, in which the cell's clock counts.
            return Some(Duration::from_nanos((ms.value * 1e6).round() as u64));
        }
        self.complain(&ms.span, format!("{} ms", ms.value), format!("write {RANGE}"));
        None
    }

    fn step(&mut self, table: &DeTable<'_>) -> Duration {
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
    fn after_fault(&mut self, value: &Value<'_>) -> Option<AfterFault> {
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

    /// Reads the named tables below a key.
    fn entries<'t>(&mut self, table: &'t DeTable<'t>, key: &str) -> Vec<Entry<'t>> {
        let Some(value) = table.get(key) else { return Vec::new() };
        let DeValue::Table(named) = value.get_ref() else {
            self.wrong_type(value, &format!("tables [{key}.NAME]"));
            return Vec::new();
        };
        let mut entries = Vec::new();
        for (name, value) in named {
            let span = name.span();
            if let Err(bad) = Name::new(name.get_ref()) {
                self.complain(&span, bad.to_string(), format!("write [{key}.NAME] with such a name"));
            } else if let DeValue::Table(table) = value.get_ref() {
                entries.push(Entry { name: At { value: name.get_ref().to_string(), span }, table });
            } else {
                let expected = format!("a table [{key}.NAME]");
                self.wrong_type(value, &expected);
            }
        }
        // Sorted into the order of the file, because the map is sorted by names.
        entries.sort_by_key(|entry| entry.name.span.start);
        entries
    }

    fn robot(&mut self, Entry { name, table }: Entry<'_>, robots: &[String]) -> Option<RobotEntry> {
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
    fn carrier(&mut self, value: &Value<'_>, robot: &str, robots: &[String]) -> Option<At<String>> {
        let on = self.text(value, "the name of a robot, in quotes")?.to_owned();
        let others: Vec<_> = robots.iter().map(String::as_str).filter(|other| *other != robot).collect();
        if !others.contains(&on.as_str()) {
            let what = format!("robot `{robot}` is mounted on `{on}`, which is no other robot of the cell");
            self.complain(&value.span(), what, suggestion(&on, &others, "the others are"));
            return None;
        }
        Some(At { value: on, span: value.span() })
    }

    /// Reads what an entry says of a robot that another file describes.
    fn description(&mut self, table: &DeTable<'_>) -> Description {
        let mut text = |key: &str, expected: &str| {
            let value = table.get(key)?;
            let text = self.text(value, expected)?.to_owned();
            Some(At { value: text, span: value.span() })
        };
        let file = text("file", "the name of a file, in quotes");
        let base_link = text("base_link", "the name of a link, in quotes");
        let tip = text("tip", "the name of a link, in quotes");
        let acceleration = table
            .get("acceleration")
            .and_then(|value| self.numbers(value, "a list of accelerations [rad/s² or m/s²]"));
        Description { file, base_link, tip, acceleration, asked: Rc::default() }
    }

    /// Reads `{ position = [x, y, z], zyz = [a, b, c] }` [m, rad]; each is zero by default.
    fn pose(&mut self, value: &Value<'_>) -> Option<Pose> {
        const FORM: &str = "{ position = [x, y, z], zyz = [a, b, c] } [m, rad]";
        let DeValue::Table(table) = value.get_ref() else {
            self.wrong_type(value, FORM);
            return None;
        };
        self.known(table, &POSE_KEYS, "a pose has");
        let mut three = |key: &str| {
            let Some(value) = table.get(key) else { return Some([0.0; 3]) };
            let numbers = self.numbers(value, "three numbers")?;
            if let [x, y, z] = numbers.value.as_slice() {
                return Some([x.value, y.value, z.value]);
            }
            let what = format!("`{key}` has {} numbers", numbers.value.len());
            self.complain(&numbers.span, what, format!("write three: {FORM}"));
            None
        };
        let ([x, y, z], [alpha, beta, gamma]) = (three("position")?, three("zyz")?);
        Some(Pose::from_parts(Translation3::new(x, y, z), Zyz { alpha, beta, gamma }.rotation()))
    }

    fn realtime(&mut self, value: &Value<'_>) -> Option<Realtime> {
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

    fn recording(&mut self, value: &Value<'_>, there: [(&str, &Vec<String>); 2]) -> Option<Recording> {
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

    /// Reads a list of names, each of which must be among `there`.
    fn names(&mut self, value: &Value<'_>, of: &str, there: &[String]) -> Option<Vec<String>> {
        let expected = format!("a list of names of {of}, in quotes");
        let DeValue::Array(array) = value.get_ref() else {
            self.wrong_type(value, &expected);
            return None;
        };
        let known: Vec<_> = there.iter().map(String::as_str).collect();
        let names: Vec<_> = array
            .iter()
            .map(|value| {
                let name = self.text(value, &expected)?;
                if !known.contains(&name) {
                    let what = format!("`{name}` is none of the {of}");
                    self.complain(&value.span(), what, suggestion(name, &known, "there are"));
                    return None;
                }
                Some(name.to_owned())
            })
            .collect();
        names.into_iter().collect()
    }

    /// Reads a whole number in a range.
    fn whole(&mut self, number: &At<f64>, range: RangeInclusive<usize>, expected: &str) -> Option<usize> {
        let found = range.into_iter().find(|&whole| whole as f64 == number.value);
        if found.is_none() {
            self.complain(&number.span, format!("{} is not", number.value), format!("write {expected}"));
        }
        found
    }

    fn sensor(&mut self, Entry { name, table }: Entry<'_>, robots: &[String]) -> Option<SensorEntry> {
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
        let latency = latency.unwrap_or_default();
        Some(SensorEntry { name: name.value, of, readers, every, stale_after, mode, latency })
    }
}
