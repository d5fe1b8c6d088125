//! Readings of virtual sensors as topics: numbers have one each, and lists of numbers, and wrenches.
//!
//! In: the shape of a reading, and readings as a recording writes them. Out: messages of `std_msgs`, and `geometry_msgs/WrenchStamped`, which every tool of
//! ROS 2 knows.

use mrroc_core::payload::{Shape, Wire as _};
use mrroc_core::pose::Wrench;
use mrroc_recording::as_number;
use serde_json::Value;

use crate::messages::{Dimension, Flag, Header, Number, Numbers, Stamp, Text, Vector, WrenchStamped};
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
    /// A force and a torque: `geometry_msgs/WrenchStamped`, in this frame.
    Wrench(O::Topic<WrenchStamped>, String),
    /// A list of something else: a place for each.
    Items(Vec<ReadingTopics<O>>),
    /// Fields by their names in the recording.
    Fields(Vec<(&'static str, ReadingTopics<O>)>),
    /// It says nothing that a message has.
    Nothing,
}

impl<O: Outlet> ReadingTopics<O> {
    /// Of readings of this shape, below a topic of this name; wrenches are in this frame.
    ///
    /// # Errors
    /// Why a topic cannot be had.
    pub fn open(outlet: &mut O, name: &str, shape: &Shape, frame: &str) -> Result<Self, String> {
        if shape == Wrench::SHAPE {
            return Ok(ReadingTopics::Wrench(outlet.topic(name, Durability::Volatile)?, frame.to_owned()));
        }
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
                    let items = (0..*count).map(|k| Self::open(outlet, &below(&k.to_string()), item, frame));
                    ReadingTopics::Items(items.collect::<Result<_, _>>()?)
                }
            },
            Shape::Fields(fields) => {
                let fields = fields
                    .iter()
                    .map(|(field, shape)| Ok((*field, Self::open(outlet, &below(field), shape, frame)?)));
                ReadingTopics::Fields(fields.collect::<Result<_, String>>()?)
            }
            Shape::Variants(variants) => {
                let choice = ReadingTopics::Choice(outlet.topic(&below("choice"), Durability::Volatile)?);
                let chosen = variants.iter().filter(|(_, shape)| !shape.is_empty());
                let chosen = chosen
                    .map(|(field, shape)| Ok((*field, Self::open(outlet, &below(field), shape, frame)?)));
                let fields = core::iter::once(Ok(("choice", choice))).chain(chosen);
                ReadingTopics::Fields(fields.collect::<Result<_, String>>()?)
            }
            Shape::Demand | Shape::Words(_) => ReadingTopics::Nothing,
        })
    }

    /// Publishes a reading that was taken at this date; of one with other fields, those that there are.
    pub fn put(&self, stamp: Stamp, reading: &Value) {
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
            ReadingTopics::Wrench(topic, frame) => {
                if let (Some(force), Some(torque)) = (vector(&reading["force"]), vector(&reading["torque"])) {
                    topic.put(WrenchStamped {
                        header: Header { stamp, frame_id: frame.clone() },
                        force,
                        torque,
                    });
                }
            }
            ReadingTopics::Items(items) => {
                let values = reading.as_array().into_iter().flatten();
                items.iter().zip(values).for_each(|(item, value)| item.put(stamp, value));
            }
            ReadingTopics::Fields(fields) => {
                fields.iter().for_each(|(name, field)| field.put(stamp, &reading[*name]));
            }
            ReadingTopics::Nothing => {}
        }
    }
}

fn vector(value: &Value) -> Option<Vector> {
    let mut numbers = Vec::new();
    flatten(value, &mut numbers)?;
    let &[x, y, z] = numbers.as_slice() else { return None };
    Some(Vector { x, y, z })
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
