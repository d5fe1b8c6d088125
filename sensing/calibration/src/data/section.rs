//! Tables of a TOML text, read key by key: each mistake is told at its place, and so is each key that nobody asked for.

use core::ops::Range;
use std::cell::RefCell;

use mrroc::suggestion::suggestion;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::mistake::Source;

type Value<'t> = Spanned<DeValue<'t>>;

/// A value and where it stands.
#[derive(Clone, Debug)]
pub(super) struct At<T> {
    pub(super) value: T,
    pub(super) span: Range<usize>,
}

/// A table.
pub(super) struct Section<'t> {
    pub(super) source: &'t Source,
    table: &'t DeTable<'t>,
    pub(super) span: Range<usize>,
    /// As messages call it.
    title: String,
    asked: RefCell<Vec<&'static str>>,
}

/// Reads a whole text, whose places are those of the source's, and hands its table to `with`.
pub(super) fn parse<T>(
    source: &Source,
    toml: &str,
    title: &str,
    with: impl FnOnce(&Section<'_>) -> Option<T>,
) -> Option<T> {
    let (document, syntax) = DeTable::parse_recoverable(toml);
    let place = |error: &toml::de::Error| error.span().unwrap_or(0..0);
    if let Some(error) = syntax.iter().min_by_key(|error| place(error).start) {
        let help = "write key = value, texts in \"quotes\", lists in [1.0, 2.0]; a bracket or a quote may be missing in the line above";
        source.complain(&place(error), error.message().to_owned(), help);
        return None;
    }
    let section = Section {
        source,
        table: document.get_ref(),
        span: 0..0,
        title: title.to_owned(),
        asked: RefCell::default(),
    };
    let read = with(&section);
    section.close();
    read
}

impl<'t> Section<'t> {
    fn get(&self, key: &'static str) -> Option<&'t Value<'t>> {
        self.asked.borrow_mut().push(key);
        self.table.get(key)
    }

    /// Tells of keys that nobody asked for.
    pub(super) fn close(&self) {
        let known = self.asked.borrow();
        for key in self.table.keys() {
            let name: &str = key.get_ref();
            if !known.contains(&name) {
                let what = format!("{} has no `{name}`", self.title);
                let mut all: Vec<&str> = known.clone();
                all.dedup();
                self.source.complain(&key.span(), what, suggestion(name, &all, "it may have"));
            }
        }
    }

    /// Tells that a key is missing.
    pub(super) fn missing(&self, key: &str, help: &str) {
        self.source.complain(&self.span, format!("{} has no `{key}`", self.title), help);
    }

    fn wrong(&self, key: &str, value: &Value<'_>, help: &str) {
        self.source.complain(
            &value.span(),
            format!("`{key}` of {} is not what it should be", self.title),
            help,
        );
    }

    pub(super) fn text(&self, key: &'static str, help: &str) -> Option<At<String>> {
        let value = self.get(key)?;
        match value.get_ref() {
            DeValue::String(text) => Some(At { value: text.to_string(), span: value.span() }),
            _ => {
                self.wrong(key, value, help);
                None
            }
        }
    }

    pub(super) fn truth(&self, key: &'static str) -> Option<bool> {
        let value = self.get(key)?;
        match value.get_ref() {
            DeValue::Boolean(truth) => Some(*truth),
            _ => {
                self.wrong(key, value, "write true or false");
                None
            }
        }
    }

    pub(super) fn number(&self, key: &'static str, help: &str) -> Option<At<f64>> {
        let value = self.get(key)?;
        let read = number(value.get_ref());
        if read.is_none() {
            self.wrong(key, value, help);
        }
        Some(At { value: read?, span: value.span() })
    }

    /// A number that is > 0.
    pub(super) fn positive(&self, key: &'static str, help: &str) -> Option<f64> {
        let read = self.number(key, help)?;
        if read.value > 0.0 {
            return Some(read.value);
        }
        self.source.complain(&read.span, format!("`{key}` is {}, not more than 0", read.value), help);
        None
    }

    pub(super) fn numbers(&self, key: &'static str, help: &str) -> Option<At<Vec<f64>>> {
        let value = self.get(key)?;
        let all = match value.get_ref() {
            DeValue::Array(array) => {
                array.iter().map(|one| number(one.get_ref())).collect::<Option<Vec<f64>>>()
            }
            _ => None,
        };
        if all.is_none() {
            self.wrong(key, value, help);
        }
        Some(At { value: all?, span: value.span() })
    }

    /// A list of texts; a single text is a list of one.
    pub(super) fn texts(&self, key: &'static str, help: &str) -> Option<At<Vec<At<String>>>> {
        let value = self.get(key)?;
        let one = |value: &Value<'_>| match value.get_ref() {
            DeValue::String(text) => Some(At { value: text.to_string(), span: value.span() }),
            _ => None,
        };
        let all = match value.get_ref() {
            DeValue::Array(array) => array.iter().map(one).collect::<Option<Vec<_>>>(),
            _ => one(value).map(|one| vec![one]),
        };
        if all.is_none() {
            self.wrong(key, value, help);
        }
        Some(At { value: all?, span: value.span() })
    }

    /// One of some words.
    pub(super) fn one_of<T: Copy>(&self, key: &'static str, words: &[(&str, T)]) -> Option<T> {
        let known: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
        let text = self.text(key, &format!("write one of \"{}\"", known.join("\", \"")))?;
        let found = words.iter().find(|(word, _)| *word == text.value);
        if found.is_none() {
            let what = format!("no `{key}` is called `{}`", text.value);
            self.source.complain(&text.span, what, suggestion(&text.value, &known, "there are"));
        }
        found.map(|(_, one)| *one)
    }

    fn of(&self, title: String, value: &'t Value<'t>) -> Option<Section<'t>> {
        match value.get_ref() {
            DeValue::Table(table) => Some(Section {
                source: self.source,
                table,
                span: value.span(),
                title,
                asked: RefCell::default(),
            }),
            _ => {
                self.source.complain(
                    &value.span(),
                    format!("{title} is no table"),
                    "write [TABLE], or { key = value }",
                );
                None
            }
        }
    }

    /// A table in it.
    pub(super) fn section(&self, key: &'static str) -> Option<Section<'t>> {
        self.of(format!("[{key}]"), self.get(key)?)
    }

    /// All tables of a list `[[key]]`; a single one is a list of one.
    pub(super) fn sections(&self, key: &'static str) -> Vec<Section<'t>> {
        match self.get(key) {
            None => Vec::new(),
            Some(value) => match value.get_ref() {
                DeValue::Array(array) => {
                    array.iter().filter_map(|one| self.of(format!("[[{key}]]"), one)).collect()
                }
                _ => self.of(format!("[{key}]"), value).into_iter().collect(),
            },
        }
    }

    /// The tables `[key.NAME]`.
    pub(super) fn named(&self, key: &'static str) -> Vec<(At<String>, Section<'t>)> {
        let Some(value) = self.get(key) else { return Vec::new() };
        let DeValue::Table(table) = value.get_ref() else {
            self.wrong(key, value, &format!("write [{key}.NAME]"));
            return Vec::new();
        };
        let one = |(name, value): (&Spanned<std::borrow::Cow<'_, str>>, &'t Value<'t>)| {
            let at = At { value: name.get_ref().to_string(), span: name.span() };
            Some((at, self.of(format!("[{key}.{}]", name.get_ref()), value)?))
        };
        table.iter().filter_map(one).collect()
    }

    /// Whether a key is a text, without asking for it.
    pub(super) fn is_text(&self, key: &str) -> bool {
        self.table.get(key).is_some_and(|value| matches!(value.get_ref(), DeValue::String(_)))
    }
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Integer(integer) => {
            i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|whole| whole as f64)
        }
        DeValue::Float(float) => float.as_str().parse().ok().filter(|number: &f64| number.is_finite()),
        DeValue::String(_)
        | DeValue::Boolean(_)
        | DeValue::Datetime(_)
        | DeValue::Array(_)
        | DeValue::Table(_) => None,
    }
}
