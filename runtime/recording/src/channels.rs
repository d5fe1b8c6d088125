//! The channels of a recording: each thing that a process shows becomes a message of one channel.
//!
//! In: records of the ring. Out: for each record a JSON text on its channel, which is made when it is first needed.

use core::fmt::{Display, Write};
use std::io;

use serde_json::{Value, json};

use super::json::{number, numbers, object, schema, value};
use mrroc_core::link::Nanos;
use mrroc_core::observe::layout::Layout;
use mrroc_core::observe::ring::Record;
use mrroc_core::observe::sample::{Field, Fields, Topic};
use mrroc_core::payload::Shape;

/// Where the messages go.
pub(super) trait Outlet {
    /// Makes a channel for a topic, with a schema of this name and text; returns the number of the channel.
    fn open(&mut self, topic: &str, schema: &str, text: &str) -> io::Result<u16>;

    /// Writes a message at a time of the cell.
    fn write(&mut self, channel: u16, time: Nanos, json: &str) -> io::Result<()>;

    /// Hands on what was written, so that a reader can have it now.
    fn flush(&mut self) -> io::Result<()>;

    /// Ends the recording: this many records were dropped.
    fn finish(&mut self, dropped: u64) -> io::Result<()>;
}

/// The channels made so far.
pub(super) struct Channels {
    layout: Layout,
    open: Vec<(Topic, u16)>,
    text: String,
}

impl Channels {
    pub fn of(layout: Layout) -> Channels {
        Channels { layout, open: Vec::new(), text: String::new() }
    }

    /// Writes a record as a message; nothing if its words make no sense.
    pub fn put(&mut self, record: &Record, outlet: &mut dyn Outlet) -> io::Result<()> {
        let Channels { layout, open, text } = self;
        let topic = record.what.topic(record.by);
        let known = open.iter().find(|(known, _)| *known == topic);
        let mut channel: Option<io::Result<u16>> = known.map(|(_, channel)| Ok(*channel));
        text.clear();
        record.what.sample(record.time, record.by, record.words(), layout, &mut |fields| {
            write_fields(text, fields);
            channel.get_or_insert_with(|| {
                let schema = schema_of_fields(fields).to_string();
                let channel = outlet.open(&topic.to_string(), &topic.schema(), &schema)?;
                open.push((topic, channel));
                Ok(channel)
            });
        });
        match channel {
            Some(channel) if !text.is_empty() => outlet.write(channel?, record.time, text),
            Some(_) | None => Ok(()),
        }
    }
}

/// The schema of fields.
fn schema_of_fields(fields: Fields<'_>) -> Value {
    let listed = fields.iter().filter_map(|(name, field)| Some((*name, schema_of(field)?)));
    let mut schema = object(listed);
    let is_optional = |field: &Field<'_>| matches!(field, Field::Optional(..) | Field::Unlisted(..));
    if fields.iter().any(|(_, field)| is_optional(field)) {
        let required = fields.iter().filter(|(_, field)| !is_optional(field)).map(|(name, _)| *name);
        schema["required"] = required.collect();
    }
    schema
}

fn schema_of(field: &Field<'_>) -> Option<Value> {
    Some(match field {
        Field::Integer(_) => schema(&Shape::Unsigned),
        Field::Number(_) => schema(&Shape::Float),
        Field::Truth(_) => schema(&Shape::Truth),
        Field::Text(_) => json!({"type": "string"}),
        Field::Numbers(_) => json!({"type": "array", "items": {"type": "number"}}),
        Field::Value(shape, _) | Field::Optional(shape, _) => schema(shape),
        Field::Unlisted(..) => return None,
        Field::Fields(fields) => schema_of_fields(fields),
    })
}

/// Writes those fields that the sample has.
pub(super) fn write_fields(out: &mut String, fields: Fields<'_>) {
    out.push('{');
    let has = |field: &Field<'_>| !matches!(field, Field::Optional(_, None));
    for (i, (name, field)) in fields.iter().filter(|(_, field)| has(field)).enumerate() {
        // Writing to a text cannot fail.
        let _ = write!(out, "{}\"{name}\":", if i == 0 { "" } else { "," });
        write_field(out, field);
    }
    out.push('}');
}

fn write_field(out: &mut String, field: &Field<'_>) {
    let _ = match field {
        Field::Integer(integer) => write!(out, "{integer}"),
        Field::Number(x) => return number(out, *x),
        Field::Truth(truth) => write!(out, "{truth}"),
        Field::Text(text) => return write_text(out, text),
        Field::Numbers(words) => return numbers(out, words),
        Field::Value(shape, words) | Field::Optional(shape, Some(words)) | Field::Unlisted(shape, words) => {
            return value(out, shape, words);
        }
        Field::Optional(_, None) => Ok(()),
        Field::Fields(fields) => return write_fields(out, fields),
    };
}

/// Writes a text as JSON; most have no character that JSON writes otherwise.
fn write_text(out: &mut String, text: &dyn Display) {
    let begin = out.len();
    let _ = write!(out, "\"{text}\"");
    let plain = &out[begin + 1..out.len() - 1];
    if plain.contains(|c: char| c == '"' || c == '\\' || c.is_ascii_control()) {
        let escaped = Value::from(plain).to_string();
        out.replace_range(begin.., &escaped);
    }
}
