//! The topics of a cell file.
//!
//! In: the tables `[sensors.NAME.external.topic]`, and what the cell is made of. Out: of each topic, which sensor it is, and what is read of its messages.

use mrroc_core::cell::CellError;
use mrroc_core::observe::layout::{Layout, SensorLayout};
use mrroc_launch::cell_file::{CellFile, ExternalEntry, TopicEntry};

use super::mapping::Mapping;

/// A topic as the cell file describes it, with the sensor that it is, and what is read of its messages.
#[derive(Debug)]
pub struct Mapped<'a> {
    pub of: &'a ExternalEntry,
    pub topic: &'a TopicEntry,
    pub sensor: &'a SensorLayout,
    pub mapping: Mapping,
}

/// Reads the topics of a cell file, for the sensors of a cell of this layout.
///
/// # Errors
/// All that is wrong with the file.
pub fn mapped<'a>(layout: &'a Layout, file: &'a CellFile) -> Result<Vec<Mapped<'a>>, Vec<CellError>> {
    let read: Vec<_> = file.topics().map(|(of, topic)| map(layout, of, topic)).collect();
    let errors: Vec<_> = read.iter().filter_map(|mapped| mapped.as_ref().err().cloned()).collect();
    if errors.is_empty() { Ok(read.into_iter().flatten().collect()) } else { Err(errors) }
}

/// What is read of the messages of a topic.
fn map<'a>(
    layout: &'a Layout,
    of: &'a ExternalEntry,
    topic: &'a TopicEntry,
) -> Result<Mapped<'a>, CellError> {
    let sensor = layout.sensors.iter().find(|sensor| sensor.name == of.name());
    let missing = || {
        let what = format!("the cell has no sensor `{}`", of.name());
        topic.refuse(topic.name().place(), what, ADDED.to_owned())
    };
    let sensor = sensor.ok_or_else(missing)?;
    Ok(Mapped { of, topic, sensor, mapping: Mapping::of(topic, sensor)? })
}

const ADDED: &str =
    "add it in the function that makes the cell, by `External::in_cell`, or leave its table out";
