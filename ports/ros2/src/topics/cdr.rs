//! Reads the wanted values of a message in CDR, whose type is known when the program runs.
//!
//! In: the body of a message, its byte order, its type, and which of its values are wanted. Out: words, or why the message is none of its type. The whole message
//! is walked through, so that one that is too short or too long is found out wherever the wanted values are. A value lies at a multiple of its size, counted
//! from the beginning of the body (OMG DDS-RTPS 2.5, 10; XTypes 1.3, 7.4.1). Whatever the bytes are, the work is bounded by their number.

use std::collections::BTreeMap;

use crate::definitions::{Count, Field, Item, MessageType, Number};

/// Bytes behind a message that may be there since its length was rounded up.
const PADDING: usize = 3;

/// The order of the bytes of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteOrder {
    Little,
    Big,
}

/// What a word is made of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Word {
    /// The bits of an `f64`.
    Float,
    /// The bits of an `f32`.
    Single,
    Unsigned,
    Signed,
    /// 0 or 1.
    Truth,
    /// Less than that.
    Choice(usize),
}

/// Which values of a message are wanted: of a message by its fields, of an array by its items, of a number as which words.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    words: Vec<(usize, Word)>,
    fields: BTreeMap<usize, Wanted>,
    items: BTreeMap<usize, Wanted>,
}

/// From a message, or an array, to a part of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    Field(usize),
    Item(usize),
}

impl Wanted {
    /// Wants the number at the end of a path as a word.
    pub fn want(&mut self, path: &[Part], place: usize, word: Word) {
        match path {
            [] => self.words.push((place, word)),
            [Part::Field(field), rest @ ..] => self.fields.entry(*field).or_default().want(rest, place, word),
            [Part::Item(item), rest @ ..] => self.items.entry(*item).or_default().want(rest, place, word),
        }
    }
}

/// Why a message is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// It ends too early.
    #[error("it is too short: it ends in `{0}`")]
    Short(String),
    /// It does not end where its type does.
    #[error("it is too long: {0} bytes are left, so its type has other fields")]
    Long(usize),
    /// A sequence says that it has more values than fit into the message.
    #[error("`{0}` says that it has {1} values, more than there are bytes")]
    Count(String, u32),
    /// A sequence or a text is longer than its type allows.
    #[error("`{0}` is longer than its type allows: {1}")]
    Bound(String, u32),
    /// A text does not end as one.
    #[error("the text `{0}` has no end")]
    Text(String),
    /// A sequence has no such value.
    #[error("`{0}` has {1} values, and value [{2}] is wanted")]
    NoItem(String, usize, usize),
    /// A number is no value of the reading.
    #[error("`{0}` is {1}, {2}")]
    Value(String, String, &'static str),
}

/// A message, and how far it has been read.
struct Cursor<'a> {
    body: &'a [u8],
    at: usize,
    order: ByteOrder,
}

/// Reads the wanted values of a message into words.
///
/// # Errors
/// It is no message of that type, or a value is not what is wanted.
pub fn read(
    body: &[u8],
    order: ByteOrder,
    message: &MessageType,
    wanted: &Wanted,
    words: &mut [u64],
) -> Result<(), Refusal> {
    let mut cursor = Cursor { body, at: 0, order };
    cursor.message(message, Some(wanted), words)?;
    match body.len() - cursor.at {
        left if left <= PADDING => Ok(()),
        left => Err(Refusal::Long(left)),
    }
}

impl Cursor<'_> {
    fn message(
        &mut self,
        message: &MessageType,
        wanted: Option<&Wanted>,
        words: &mut [u64],
    ) -> Result<(), Refusal> {
        for (place, field) in message.fields.iter().enumerate() {
            let wanted = wanted.and_then(|wanted| wanted.fields.get(&place));
            match field.count {
                Count::One => self.item(field, wanted, words)?,
                Count::Fixed(count) => self.items(field, count, wanted, words)?,
                Count::Sequence(most) => {
                    let said = u32::from_ne_bytes(self.number(field)?);
                    let count = said as usize;
                    if most.is_some_and(|most| count > most) {
                        return Err(Refusal::Bound(field.name.clone(), said));
                    }
                    if count > (self.body.len() - self.at) / field.item.least() {
                        return Err(Refusal::Count(field.name.clone(), said));
                    }
                    let last = wanted.and_then(|wanted| wanted.items.keys().next_back());
                    if let Some(&last) = last.filter(|&&last| last >= count) {
                        return Err(Refusal::NoItem(field.name.clone(), count, last));
                    }
                    self.items(field, count, wanted, words)?;
                }
            }
        }
        Ok(())
    }

    fn items(
        &mut self,
        field: &Field,
        count: usize,
        wanted: Option<&Wanted>,
        words: &mut [u64],
    ) -> Result<(), Refusal> {
        let Item::Number(number) = field.item else {
            for i in 0..count {
                self.item(field, wanted.and_then(|wanted| wanted.items.get(&i)), words)?;
            }
            return Ok(());
        };
        // Of none there is no place, either.
        if count == 0 {
            return Ok(());
        }
        let begin = self.at.next_multiple_of(number.size());
        let end = begin + count.saturating_mul(number.size()).min(self.body.len() + 1);
        if end > self.body.len() {
            return Err(Refusal::Short(field.name.clone()));
        }
        for (i, wanted) in wanted.iter().flat_map(|wanted| &wanted.items) {
            self.at = begin + i * number.size();
            self.item(field, Some(wanted), words)?;
        }
        self.at = end;
        Ok(())
    }

    fn item(&mut self, field: &Field, wanted: Option<&Wanted>, words: &mut [u64]) -> Result<(), Refusal> {
        match &field.item {
            Item::Message(message) => self.message(message, wanted, words),
            Item::Text(most) => self.text(field, *most),
            Item::Number(number) => {
                let value = self.value(field, *number)?;
                for &(place, word) in wanted.iter().flat_map(|wanted| &wanted.words) {
                    let refuse = |why| Refusal::Value(field.name.clone(), value.to_string(), why);
                    words[place] = value.as_word(word).map_err(refuse)?;
                }
                Ok(())
            }
        }
    }

    fn text(&mut self, field: &Field, most: Option<usize>) -> Result<(), Refusal> {
        let said = u32::from_ne_bytes(self.number(field)?);
        // With the zero at its end; some send an empty one without that.
        let Some(len) = (said as usize).checked_sub(1) else { return Ok(()) };
        if most.is_some_and(|most| len > most) {
            return Err(Refusal::Bound(field.name.clone(), said));
        }
        match self.body[self.at..].get(len) {
            Some(0) => self.at += len + 1,
            Some(_) => return Err(Refusal::Text(field.name.clone())),
            None => return Err(Refusal::Short(field.name.clone())),
        }
        Ok(())
    }

    /// The bytes of a number at its next place, in this machine's order.
    fn number<const SIZE: usize>(&mut self, field: &Field) -> Result<[u8; SIZE], Refusal> {
        let begin = self.at.next_multiple_of(SIZE);
        let found = self.body.get(begin..).and_then(|rest| rest.first_chunk::<SIZE>());
        let mut bytes = *found.ok_or_else(|| Refusal::Short(field.name.clone()))?;
        self.at = begin + SIZE;
        if (self.order == ByteOrder::Big) != cfg!(target_endian = "big") {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn value(&mut self, field: &Field, number: Number) -> Result<Value, Refusal> {
        Ok(match number {
            Number::Bool => Value::Unsigned(u8::from_ne_bytes(self.number(field)?).into()),
            Number::U8 => Value::Unsigned(u8::from_ne_bytes(self.number(field)?).into()),
            Number::I8 => Value::Signed(i8::from_ne_bytes(self.number(field)?).into()),
            Number::U16 => Value::Unsigned(u16::from_ne_bytes(self.number(field)?).into()),
            Number::I16 => Value::Signed(i16::from_ne_bytes(self.number(field)?).into()),
            Number::U32 => Value::Unsigned(u32::from_ne_bytes(self.number(field)?).into()),
            Number::I32 => Value::Signed(i32::from_ne_bytes(self.number(field)?).into()),
            Number::U64 => Value::Unsigned(u64::from_ne_bytes(self.number(field)?)),
            Number::I64 => Value::Signed(i64::from_ne_bytes(self.number(field)?)),
            Number::F32 => Value::Float(f32::from_ne_bytes(self.number(field)?).into()),
            Number::F64 => Value::Float(f64::from_ne_bytes(self.number(field)?)),
        })
    }
}

/// A number of a message.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Value {
    Float(f64),
    Unsigned(u64),
    Signed(i64),
}

impl core::fmt::Display for Value {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Value::Float(x) => x.fmt(f),
            Value::Unsigned(x) => x.fmt(f),
            Value::Signed(x) => x.fmt(f),
        }
    }
}

impl Value {
    /// It as a word of a reading, or why it is none.
    fn as_word(self, word: Word) -> Result<u64, &'static str> {
        let (float, unsigned, signed) = match self {
            Value::Float(x) => (x, None, None),
            Value::Unsigned(x) => (x as f64, Some(x), i64::try_from(x).ok()),
            Value::Signed(x) => (x as f64, u64::try_from(x).ok(), Some(x)),
        };
        match word {
            Word::Float => Ok(float.to_bits()),
            Word::Single if float.is_finite() && !(float as f32).is_finite() => {
                Err("and too large for the reading")
            }
            Word::Single => Ok(u64::from((float as f32).to_bits())),
            Word::Unsigned => unsigned.ok_or("and the reading has no numbers below 0"),
            Word::Signed => {
                signed.map(i64::cast_unsigned).ok_or("and the reading has no numbers above 2^63 - 1")
            }
            Word::Truth => unsigned.filter(|x| *x <= 1).ok_or("and neither 0 nor 1"),
            Word::Choice(count) => {
                unsigned.filter(|x| *x < count as u64).ok_or("and the reading has no choice of this number")
            }
        }
    }
}
