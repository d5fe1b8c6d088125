//! Reads a [`CellFile`].
//!
//! In: the text of the file. Out: a [`CellFile`] in which every key is known and every value has its type and range; or
//! all errors at once.

pub(super) mod cell;
pub(super) mod external;
pub(super) mod lower;
pub(super) mod node;
pub(super) mod obstacle;
pub(super) mod plant;
pub(super) mod pose;
pub(super) mod robot;
pub(super) mod sensor;
pub(super) mod signal;
pub(super) mod tool;
pub(super) mod topic;
pub(super) mod value;

use core::ops::Range;
use std::net::SocketAddr;
use std::rc::Rc;

use mrroc_core::fault::Name;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::CellFile;
use super::entry::SensorEntry;
use super::error::{At, CellFileError, Source};

use cell::CELL_KEYS;

type Value<'t> = Spanned<DeValue<'t>>;

/// What to write in place of a line that is no TOML.
const TOML: &str = "write key = value, texts in \"quotes\", lists in [1.0, 2.0], tables as [robots.arm]; a bracket or a quote may be \
                    missing in the line above";

/// Reads the whole file.
pub(super) fn read(name: &str, text: &str) -> Result<CellFile, CellFileError> {
    let source = Rc::new(Source { file: name.to_owned(), text: text.to_owned() });
    let (document, syntax) = DeTable::parse_recoverable(text);
    let mut reader = Reader::of(Rc::clone(&source));
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
    let tools: Vec<_> =
        reader.entries(table, "tools").into_iter().filter_map(|entry| reader.tool(entry)).collect();
    let frames: Vec<_> =
        reader.entries(table, "frames").into_iter().filter_map(|entry| reader.frame(entry)).collect();
    let obstacles = reader.entries(table, "obstacles").into_iter();
    let obstacles = obstacles.filter_map(|entry| reader.obstacle(entry, &names, &frames)).collect();
    let mut robots: Vec<_> =
        robots.into_iter().filter_map(|entry| reader.robot(entry, &names, &tools)).collect();
    plant::introduce(&mut robots);
    let cells: Vec<_> =
        reader.entries(table, "cells").into_iter().filter_map(|entry| reader.lower(entry, &names)).collect();
    if robots.is_empty() && cells.is_empty() && reader.errors.is_empty() {
        let help = "write a table [robots.arm] with the kind of a robot that you will call arm";
        reader.complain(&(0..0), "the cell has no robot".to_owned(), help.to_owned());
    }
    let robot_names = names.clone();
    let sensors: Vec<_> = reader
        .entries(table, "sensors")
        .into_iter()
        .filter_map(|entry| reader.sensor(entry, &names, step))
        .collect();
    let published = reader.published(table);
    let realtime = table.get("realtime").and_then(|value| reader.realtime(value));
    let names: Vec<_> = sensors.iter().map(|sensor: &SensorEntry| sensor.name.clone()).collect();
    let recording = table
        .get("recording")
        .and_then(|value| reader.recording(value, [("robots", &robot_names), ("sensors", &names)]));
    let nodes = reader.nodes(table, &robots, &sensors);
    let dry_run = table.get("dry_run").and_then(|value| reader.truth(value, "true or false"));
    let dry_run = dry_run.is_some_and(|dry_run| dry_run.value);
    CellFileError::all(reader.errors)?;
    Ok(CellFile {
        questions: CellFileError::all(reader.questions).err(),
        dry_run,
        nodes,
        recording,
        source,
        step,
        stop_time,
        after_fault: after_fault.unwrap_or_default(),
        realtime,
        robots,
        cells,
        sensors,
        published,
        frames,
        obstacles,
        tools,
    })
}

struct Reader {
    source: Rc<Source>,
    errors: Vec<CellFileError>,
    /// What is allowed and improbable.
    questions: Vec<CellFileError>,
    /// Sensors whose programs are on other machines, and where those call.
    gateways: Vec<(String, SocketAddr)>,
}

/// A named table: `[robots.NAME]`.
struct Entry<'t> {
    name: At<String>,
    table: &'t DeTable<'t>,
}

impl Reader {
    fn of(source: Rc<Source>) -> Self {
        Self { source, errors: Vec::new(), questions: Vec::new(), gateways: Vec::new() }
    }

    fn complain(&mut self, at: &Range<usize>, what: String, help: String) {
        self.errors.push(self.source.complain(at, what, help));
    }

    fn ask(&mut self, at: &Range<usize>, what: String, help: &str) {
        self.questions.push(self.source.complain(at, what, help.to_owned()));
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
}
