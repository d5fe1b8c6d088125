//! What a sample of a channel is made of: fields by their names, whatever has happened.
//!
//! In: what a [`StepEvent`](super::step_observer::StepEvent) says of itself. Out: the same to whoever writes it in a form of his own,
//! with names and schemas that others rely on.

use core::fmt;

use crate::model::name::Name;
use crate::model::shape::Shape;

/// What of a cell a channel is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// The uppermost cell, or a lower one.
    Cell(Option<Name>),
    /// A robot.
    Robot(Name),
    /// A virtual sensor, of a lower cell if that is named.
    Sensor(Option<Name>, Name),
    /// A body that the robots handle.
    Body(Name),
}

/// Its name: `arm`, `press.eye` of a lower cell; the empty text of the uppermost cell.
impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Subject::Cell(None) => Ok(()),
            Subject::Sensor(Some(cell), name) => write!(f, "{cell}.{name}"),
            Subject::Cell(Some(name))
            | Subject::Robot(name)
            | Subject::Sensor(None, name)
            | Subject::Body(name) => name.fmt(f),
        }
    }
}

/// What the schema of a channel is named after.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Schema {
    /// This: all such channels have it in common.
    Common(&'static str),
    /// This and the channel's subject, of which it is the own one.
    Own(&'static str),
    /// The type of orders.
    Payload(&'static str),
}

/// A channel, of which samples are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Topic {
    /// What it is about.
    pub subject: Subject,
    part: &'static str,
    schema: Schema,
}

impl Topic {
    /// This part of what there is to show of a subject; the empty text: what it is in the first place.
    #[must_use]
    pub const fn new(subject: Subject, part: &'static str, schema: Schema) -> Topic {
        Topic { subject, part, schema }
    }

    /// The name of its schema.
    #[must_use]
    pub fn schema(&self) -> String {
        match self.schema {
            Schema::Common(name) => format!("mrroc.{name}"),
            Schema::Own(name) => format!("mrroc.{name}.{}", self.subject),
            Schema::Payload(payload) => format!("mrroc.Order.{payload}"),
        }
    }
}

/// Its path: `/steps`, `/cells/press/steps` of a lower cell, `/robots/press.arm/currents`.
impl fmt::Display for Topic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let folder = match self.subject {
            Subject::Cell(None) => "",
            Subject::Cell(Some(_)) => "/cells/",
            Subject::Robot(_) => "/robots/",
            Subject::Sensor(..) => "/sensors/",
            Subject::Body(_) => "/bodies/",
        };
        write!(f, "{folder}{}", self.subject)?;
        if !self.part.is_empty() {
            write!(f, "/{}", self.part)?;
        }
        match self.schema {
            Schema::Payload(payload) => write!(f, "/{payload}"),
            Schema::Common(_) | Schema::Own(_) => Ok(()),
        }
    }
}

/// The fields of a sample in their order, each with its name.
pub type Fields<'a> = &'a [(&'a str, Field<'a>)];

/// A field of a sample.
#[derive(Clone, Copy)]
pub enum Field<'a> {
    /// An unsigned number.
    Integer(u64),
    /// A number.
    Number(f64),
    /// Yes or no.
    Truth(bool),
    /// A text.
    Text(&'a dyn fmt::Display),
    /// Numbers, as many words as there are.
    Numbers(&'a [u64]),
    /// What words of this shape say.
    Value(&'a Shape, &'a [u64]),
    /// The same, which not every sample has.
    Optional(&'a Shape, Option<&'a [u64]>),
    /// The same, which the schema does not name.
    Unlisted(&'a Shape, &'a [u64]),
    /// Further fields.
    Fields(Fields<'a>),
}

impl<'a> Field<'a> {
    /// All fields of a plain value of this shape.
    #[must_use]
    pub fn all(shape: &'a Shape, words: &'a [u64]) -> Vec<(&'a str, Field<'a>)> {
        let Shape::Fields(fields) = shape else { return Vec::new() };
        let mut rest = words;
        let field = |(name, shape): &(&'static str, &'static Shape)| {
            let (own, behind) = rest.split_at(shape.len());
            rest = behind;
            (*name, Field::Value(shape, own))
        };
        fields.iter().map(field).collect()
    }
}
