//! Readings of virtual sensors as topics: numbers have one each, and lists of numbers.
//!
//! In: the shape of a reading, and readings of a recording. Out: messages of `std_msgs` alone, which every tool of ROS 2 knows.

use mrroc_core::payload::Shape;
use mrroc_recording::as_number;
use serde_json::Value;

use crate::messages::{Dimension, Flag, Number, Numbers, Text};
use crate::node::topic_name;
use crate::outlet::{Durability, Outlet, Put};

/// The topics of a reading, or of a field of it.
pub enum ReadingTopics<O: Outlet> {
    /// `std_msgs/Float64`.
    Number(O::Topic<Number>),
    /// `std_msgs/Bool`.
    Truth(O::Topic<Flag>),
    /// One of several names: `std_msgs/String`.
    Choice(O::Topic<Text>),
    /// A list of numbers, or a list of lists: `std_msgs/Float64MultiArray`, with the field's name and the lengths as its dimensions.
    Numbers(O::Topic<Numbers>, Vec<Dimension>),
    /// A list of something else: a place for each.
    Items(Vec<ReadingTopics<O>>),
    /// Fields by their names in the recording.
    Fields(Vec<(&'static str, ReadingTopics<O>)>),
    /// It says nothing that a message has.
    Nothing,
}

impl<O: Outlet> ReadingTopics<O> {
    /// Of readings of this shape, below a topic of this name.
    ///
    /// # Errors
    /// Why a topic cannot be had.
    pub fn open(outlet: &mut O, name: &str, shape: &Shape) -> Result<Self, String> {
        let below = |field: &str| format!("{name}/{}", topic_name(field));
        Ok(match shape {
            Shape::Float | Shape::Single | Shape::Unsigned | Shape::Signed => {
                ReadingTopics::Number(outlet.topic(name, Durability::Volatile)?)
            }
            Shape::Truth => ReadingTopics::Truth(outlet.topic(name, Durability::Volatile)?),
            Shape::Choice(_) => ReadingTopics::Choice(outlet.topic(name, Durability::Volatile)?),
            Shape::Array(item, count) => match lengths(shape) {
                Some(lengths) => {
                    let label = name.rsplit('/').next().unwrap_or_default();
                    ReadingTopics::Numbers(
                        outlet.topic(name, Durability::Volatile)?,
                        dimensions(label, &lengths),
                    )
                }
                None => {
                    let items = (0..*count).map(|k| Self::open(outlet, &below(&k.to_string()), item));
                    ReadingTopics::Items(items.collect::<Result<_, _>>()?)
                }
            },
            Shape::Fields(fields) => {
                let fields = fields
                    .iter()
                    .map(|(field, shape)| Ok((*field, Self::open(outlet, &below(field), shape)?)));
                ReadingTopics::Fields(fields.collect::<Result<_, String>>()?)
            }
            Shape::Variants(variants) => {
                let choice = ReadingTopics::Choice(outlet.topic(&below("choice"), Durability::Volatile)?);
                let chosen = variants.iter().filter(|(_, shape)| !shape.is_empty());
                let chosen =
                    chosen.map(|(field, shape)| Ok((*field, Self::open(outlet, &below(field), shape)?)));
                let fields = core::iter::once(Ok(("choice", choice))).chain(chosen);
                ReadingTopics::Fields(fields.collect::<Result<_, String>>()?)
            }
            Shape::Demand | Shape::Words(_) => ReadingTopics::Nothing,
        })
    }

    /// Publishes a reading; of one with other fields, those that there are.
    pub fn put(&self, reading: &Value) {
        match self {
            ReadingTopics::Number(topic) => {
                if let Some(data) = as_number(reading) {
                    topic.put(Number { data });
                }
            }
            ReadingTopics::Truth(topic) => {
                if let Some(data) = reading.as_bool() {
                    topic.put(Flag { data });
                }
            }
            ReadingTopics::Choice(topic) => {
                if let Some(data) = reading.as_str() {
                    topic.put(Text { data: data.to_owned() });
                }
            }
            ReadingTopics::Numbers(topic, dimensions) => {
                let mut data = Vec::new();
                if flatten(reading, &mut data).is_some() {
                    topic.put(Numbers { dim: dimensions.clone(), data_offset: 0, data });
                }
            }
            ReadingTopics::Items(items) => {
                let values = reading.as_array().into_iter().flatten();
                items.iter().zip(values).for_each(|(item, value)| item.put(value));
            }
            ReadingTopics::Fields(fields) => {
                fields.iter().for_each(|(name, field)| field.put(&reading[*name]));
            }
            ReadingTopics::Nothing => {}
        }
    }
}

/// The lengths of lists in lists of numbers; `None`: it is none.
fn lengths(shape: &Shape) -> Option<Vec<usize>> {
    match shape {
        Shape::Float | Shape::Single | Shape::Unsigned | Shape::Signed => Some(Vec::new()),
        Shape::Array(item, count) => {
            let mut lengths = lengths(item)?;
            lengths.insert(0, *count);
            Some(lengths)
        }
        Shape::Truth
        | Shape::Choice(_)
        | Shape::Variants(_)
        | Shape::Fields(_)
        | Shape::Demand
        | Shape::Words(_) => None,
    }
}

/// Dimensions of these lengths, the outermost first.
fn dimensions(label: &str, lengths: &[usize]) -> Vec<Dimension> {
    let stride = |from: usize| lengths[from..].iter().product::<usize>() as u32;
    let of = |(k, &size): (usize, &usize)| Dimension {
        label: if k == 0 { label.to_owned() } else { format!("{label}{}", "[]".repeat(k)) },
        size: size as u32,
        stride: stride(k),
    };
    lengths.iter().enumerate().map(of).collect()
}

fn flatten(value: &Value, numbers: &mut Vec<f64>) -> Option<()> {
    match value.as_array() {
        Some(items) => items.iter().try_for_each(|item| flatten(item, numbers)),
        None => {
            numbers.push(as_number(value)?);
            Some(())
        }
    }
}
