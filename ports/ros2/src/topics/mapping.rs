//! Which parts of a message are which parts of a reading.
//!
//! In: what `cell.toml` says of a topic, what the words of a reading say, and the definitions of messages. Out: what is read from each message; or what is wrong, where,
//! and what to write.

use std::rc::Rc;

use mrroc_core::cell::CellError;
use mrroc_core::observe::layout::SensorLayout;
use mrroc_core::payload::Shape;
use mrroc_core::suggestion::suggestion;
use mrroc_launch::cell_file::{Place, TopicEntry, TopicReading, TopicText};

use super::cdr::{self, ByteOrder, Part, Refusal, Wanted, Word};
use crate::definitions::{Count, Definitions, Field, Item, MessageType, Number, Wrong};

/// What a time consists of.
const TIME: &str = "builtin_interfaces/msg/Time";

/// What is read from the messages of a topic.
#[derive(Debug)]
pub struct Mapping {
    message: Rc<MessageType>,
    wanted: Wanted,
    /// Words of a reading. Those of the stamp, if there is one, come after them.
    len: usize,
    stamped: bool,
}

/// What a message says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Told {
    /// The words of the reading.
    pub words: Vec<u64>,
    /// The stamp, by the clock of who stamped it \[ns since 1970\].
    pub stamp: Option<i128>,
}

/// Where a path leads to: one value, or all of an array.
struct Leads<'m> {
    path: Vec<Part>,
    item: &'m Item,
    count: Count,
}

impl Mapping {
    /// Of a sensor's readings.
    ///
    /// # Errors
    /// What is wrong with what the cell file says of the topic.
    pub fn of(entry: &TopicEntry, sensor: &SensorLayout) -> Result<Mapping, CellError> {
        let folder = entry.definitions();
        if let Some((folder, place)) = folder.as_ref().filter(|(folder, _)| !folder.is_dir()) {
            let help = "write a folder of packages, with PACKAGE/msg/NAME.msg in it".to_owned();
            return Err(entry.refuse(place, format!("{} is no folder", folder.display()), help));
        }
        let name = entry.message();
        let refuse = |Wrong { what, help }| entry.refuse(name.place(), what, help);
        let mut definitions = Definitions::new(folder.map(|(folder, _)| folder));
        let message = definitions.message(&name.text).map_err(refuse)?;
        let mut mapping = Mapping { message, wanted: Wanted::default(), len: 0, stamped: false };
        let message = Rc::clone(&mapping.message);
        let binding = Binding { entry, message: &message };
        let mut errors = Vec::new();
        binding.reading(entry.reading(), sensor.reading, "", &mut mapping, &mut errors);
        if let Some(stamp) = entry.stamp() {
            match binding.stamp(stamp) {
                Ok(path) => {
                    mapping.stamped = true;
                    let word = |i, kind| ([&path[..], &[Part::Field(i)]].concat(), kind);
                    for (i, (path, kind)) in
                        [word(0, Word::Signed), word(1, Word::Unsigned)].iter().enumerate()
                    {
                        mapping.wanted.want(path, mapping.len + i, *kind);
                    }
                }
                Err(error) => errors.push(error),
            }
        }
        CellError::all(errors).map(|()| mapping)
    }

    /// What the body of a message says.
    ///
    /// # Errors
    /// It is no message of the topic's type, or does not have what is wanted.
    pub fn read(&self, body: &[u8], order: ByteOrder) -> Result<Told, Refusal> {
        let mut words = vec![0; self.len + 2];
        cdr::read(body, order, &self.message, &self.wanted, &mut words)?;
        let [sec, nanosec] = [words[self.len], words[self.len + 1]];
        words.truncate(self.len);
        if self.stamped && nanosec >= 1_000_000_000 {
            let what = "and a second has fewer nanoseconds";
            return Err(Refusal::Value("nanosec".to_owned(), nanosec.to_string(), what));
        }
        let stamp = self.stamped.then(|| i128::from(sec.cast_signed()) * 1_000_000_000 + i128::from(nanosec));
        Ok(Told { words, stamp })
    }
}

struct Binding<'a> {
    entry: &'a TopicEntry,
    message: &'a MessageType,
}

impl Binding<'_> {
    fn refuse(&self, place: &Place, what: String, help: impl Into<String>) -> CellError {
        self.entry.refuse(place, what, help.into())
    }

    /// Maps a part of a reading, which is called `name`.
    fn reading(
        &self,
        said: &TopicReading,
        shape: &Shape,
        name: &str,
        mapping: &mut Mapping,
        errors: &mut Vec<CellError>,
    ) {
        let called = if name.is_empty() { "a reading" } else { name };
        match (said, shape) {
            (TopicReading::Path(path), _) => {
                let found =
                    self.leads(path).and_then(|leads| self.assign(path, &leads, shape, called, mapping));
                errors.extend(found.err());
            }
            (TopicReading::Fields(fields, place), Shape::Fields(known)) => {
                for (field, _) in fields {
                    if !known.iter().any(|(name, _)| *name == field.text) {
                        let names: Vec<_> = known.iter().map(|(name, _)| *name).collect();
                        let what = format!("{called} has no field `{}`", field.text);
                        errors.push(self.refuse(
                            field.place(),
                            what,
                            suggestion(&field.text, &names, "it has"),
                        ));
                    }
                }
                for (field, shape) in *known {
                    let name = if name.is_empty() { (*field).to_owned() } else { format!("{name}.{field}") };
                    match fields.iter().find(|(said, _)| said.text == *field) {
                        Some((_, said)) => self.reading(said, shape, &name, mapping, errors),
                        None => {
                            let what = format!("{called} has a field `{field}`, of which nothing is said");
                            let help = format!(
                                "write {field} = \"..\", the path of a field in {}",
                                self.message.name
                            );
                            errors.push(self.refuse(place, what, help));
                        }
                    }
                }
            }
            (TopicReading::Items(items, place), Shape::Array(shape, count)) => {
                if items.len() != *count {
                    let what = format!("{} values of {called}, which has {count}", items.len());
                    errors.push(self.refuse(place, what, format!("write {count} paths")));
                }
                for (i, said) in items.iter().enumerate() {
                    self.reading(said, shape, &format!("{name}[{i}]"), mapping, errors);
                }
            }
            (TopicReading::Fields(..) | TopicReading::Items(..), _) => {
                let what = format!("{called} is {}", told(shape));
                errors.push(self.refuse(said.place(), what, "write the path of such a part of a message"));
            }
        }
    }

    /// Where a path in the message leads to.
    fn leads(&self, path: &TopicText) -> Result<Leads<'_>, CellError> {
        let mut leads: Option<Leads<'_>> = None;
        for part in path.text.split('.') {
            let (name, item) = match part.split_once('[') {
                None => (part, None),
                Some((name, rest)) => {
                    (name, Some(rest.strip_suffix(']').and_then(|item| item.parse::<usize>().ok())))
                }
            };
            let message = match &leads {
                None => self.message,
                Some(Leads { item: Item::Message(message), count: Count::One, .. }) => message,
                Some(leads) => {
                    let what = format!("`{name}` of {}", self.called(leads));
                    return Err(self.refuse(
                        path.place(),
                        what,
                        "end the path there, or choose a value by [0]",
                    ));
                }
            };
            let Some(place) = message.fields.iter().position(|field| field.name == name) else {
                let names: Vec<_> = message.fields.iter().map(|field| field.name.as_str()).collect();
                let what = format!("{} has no field `{name}`", message.name);
                return Err(self.refuse(path.place(), what, suggestion(name, &names, "it has")));
            };
            let field = &message.fields[place];
            let mut trail = leads.map(|leads| leads.path).unwrap_or_default();
            trail.push(Part::Field(place));
            let count = match item {
                None => field.count,
                Some(item) => {
                    trail.push(Part::Item(self.item(path, message, field, item)?));
                    Count::One
                }
            };
            leads = Some(Leads { path: trail, item: &field.item, count });
        }
        // Splitting gives at least one part.
        leads
            .ok_or_else(|| self.refuse(path.place(), "an empty path".to_owned(), "write the path of a field"))
    }

    /// The place of a value in an array.
    fn item(
        &self,
        path: &TopicText,
        message: &MessageType,
        field: &Field,
        item: Option<usize>,
    ) -> Result<usize, CellError> {
        let most = match field.count {
            Count::One => {
                let what = format!("`{}` of {} is no array", field.name, message.name);
                return Err(self.refuse(path.place(), what, "leave [..] out"));
            }
            Count::Fixed(count) | Count::Sequence(Some(count)) => count,
            Count::Sequence(None) => u32::MAX as usize,
        };
        item.filter(|item| *item < most).ok_or_else(|| {
            let what = format!("`{}` has no such value of `{}`", path.text, field.name);
            let help = match field.count {
                Count::Sequence(None) => "write the number of a value, such as [0]".to_owned(),
                _ => format!("write a number from [0] to [{}]", most - 1),
            };
            self.refuse(path.place(), what, help)
        })
    }

    /// Makes what a path leads to the next words of a reading, which have this shape.
    fn assign(
        &self,
        path: &TopicText,
        leads: &Leads<'_>,
        shape: &Shape,
        called: &str,
        mapping: &mut Mapping,
    ) -> Result<(), CellError> {
        let unlike = || {
            let what = format!("`{}` is {}, and {called} is {}", path.text, self.called(leads), told(shape));
            self.refuse(path.place(), what, "write the path of such a part of the message")
        };
        let within = |part: Part| [&leads.path[..], &[part]].concat();
        match (shape, leads.count, leads.item) {
            (Shape::Fields(fields), Count::One, Item::Message(message)) => {
                for (name, shape) in *fields {
                    let place = message.fields.iter().position(|field| field.name == *name);
                    let place = place.ok_or_else(|| {
                        let what = format!("{called} has a field `{name}`, {} has none", message.name);
                        let help = format!("write a table, with the path of `{name}`");
                        self.refuse(path.place(), what, help)
                    })?;
                    let Field { item, count, .. } = &message.fields[place];
                    let leads = Leads { path: within(Part::Field(place)), item, count: *count };
                    self.assign(path, &leads, shape, &format!("{called}.{name}"), mapping)?;
                }
                Ok(())
            }
            (Shape::Array(shape, wanted), Count::Fixed(count), item) if *wanted == count => {
                self.assign_each(path, (leads, item), (shape, count), called, mapping)
            }
            (Shape::Array(shape, wanted), Count::Sequence(most), item)
                if most.is_none_or(|most| *wanted <= most) =>
            {
                self.assign_each(path, (leads, item), (shape, *wanted), called, mapping)
            }
            // Such as x, y, z of a vector.
            (Shape::Array(shape, wanted), Count::One, Item::Message(message))
                if message.fields.len() == *wanted =>
            {
                for (place, Field { item, count, .. }) in message.fields.iter().enumerate() {
                    let leads = Leads { path: within(Part::Field(place)), item, count: *count };
                    self.assign(path, &leads, shape, &format!("{called}[{place}]"), mapping)?;
                }
                Ok(())
            }
            (_, Count::One, Item::Number(number)) => {
                let word = word(shape, *number).ok_or_else(unlike)?;
                mapping.wanted.want(&leads.path, mapping.len, word);
                mapping.len += 1;
                Ok(())
            }
            _ => Err(unlike()),
        }
    }

    fn assign_each(
        &self,
        path: &TopicText,
        (leads, item): (&Leads<'_>, &Item),
        (shape, count): (&Shape, usize),
        called: &str,
        mapping: &mut Mapping,
    ) -> Result<(), CellError> {
        for i in 0..count {
            let trail = [&leads.path[..], &[Part::Item(i)]].concat();
            let one = Leads { path: trail, item, count: Count::One };
            self.assign(path, &one, shape, &format!("{called}[{i}]"), mapping)?;
        }
        Ok(())
    }

    /// The path of a time.
    fn stamp(&self, path: &TopicText) -> Result<Vec<Part>, CellError> {
        let leads = self.leads(path)?;
        match (leads.item, leads.count) {
            (Item::Message(message), Count::One) if message.name == TIME => Ok(leads.path),
            _ => {
                let what =
                    format!("`{}` is {}, and a stamp is a message {TIME}", path.text, self.called(&leads));
                Err(self.refuse(
                    path.place(),
                    what,
                    "write the path of a time, such as \"header.stamp\", or leave `stamp` out",
                ))
            }
        }
    }

    fn called(&self, leads: &Leads<'_>) -> String {
        let called = leads.item.called();
        match leads.count {
            Count::One => called,
            Count::Fixed(count) => format!("an array of {count} values, each {called}"),
            Count::Sequence(Some(most)) => format!("an array of up to {most} values, each {called}"),
            Count::Sequence(None) => format!("an array of any length, each value {called}"),
        }
    }
}

/// What a part of a reading is.
fn told(shape: &Shape) -> String {
    match shape {
        Shape::Float | Shape::Single => "a number".to_owned(),
        Shape::Unsigned | Shape::Signed => "a whole number".to_owned(),
        Shape::Truth => "true or false".to_owned(),
        Shape::Choice(names) => format!("one of {}", names.join(", ")),
        Shape::Array(shape, count) => format!("an array of {count} values, each {}", told(shape)),
        Shape::Fields(fields) => {
            let names: Vec<_> = fields.iter().map(|(name, _)| *name).collect();
            format!("made of fields: {}", names.join(", "))
        }
        Shape::Variants(_) | Shape::Demand | Shape::Words(_) => {
            "of words that say nothing to others".to_owned()
        }
    }
}

/// What becomes of a number of a message in a word of this shape.
const fn word(shape: &Shape, number: Number) -> Option<Word> {
    let is_whole = !matches!(number, Number::F32 | Number::F64);
    let is_bool = matches!(number, Number::Bool);
    match shape {
        Shape::Float if !is_bool => Some(Word::Float),
        Shape::Single if !is_bool => Some(Word::Single),
        Shape::Unsigned if is_whole && !is_bool => Some(Word::Unsigned),
        Shape::Signed if is_whole && !is_bool => Some(Word::Signed),
        Shape::Truth if is_whole => Some(Word::Truth),
        Shape::Choice(names) if is_whole && !is_bool => Some(Word::Choice(names.len())),
        _ => None,
    }
}
