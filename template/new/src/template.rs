//! The template: its files, which are built in, and the choices that its `cargo-generate.toml` offers.
//!
//! What cargo-generate knows, this knows too; nothing here names a particular choice.

use std::fmt;

use regex::Regex;
use toml::{Table, Value as Toml};

use crate::error::Error;
use crate::suggestion;

/// The template's files by name, with `/` between folders.
pub const FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/template.rs"));

/// The file that describes the choices.
const DESCRIPTION: &str = "cargo-generate.toml";

/// The choices of a template.
#[derive(Clone, Debug)]
pub struct Template {
    /// Those that are always asked for.
    pub placeholders: Vec<Placeholder>,
    /// Those that depend on others.
    pub conditionals: Vec<Conditional>,
}

/// Choices that are asked for when others say so.
#[derive(Clone, Debug)]
pub struct Conditional {
    /// The condition, an expression of Rhai.
    pub when: String,
    /// What is asked for when it holds.
    pub placeholders: Vec<Placeholder>,
}

/// One choice.
#[derive(Clone, Debug)]
pub struct Placeholder {
    /// Its name, as in `--define name=value`.
    pub name: String,
    /// The question.
    pub prompt: String,
    /// What can be answered.
    pub kind: Kind,
    /// What is taken when nobody answers.
    pub default: Option<Value>,
}

/// What can be chosen.
#[derive(Clone, Debug)]
pub enum Kind {
    /// A text, of a certain form if there is one.
    Text(Option<Regex>),
    /// One of these.
    OneOf(Vec<Choice>),
    /// Any of these.
    AnyOf(Vec<Choice>),
    /// Yes or no.
    YesNo,
}

/// One value that can be chosen.
#[derive(Clone, Debug)]
pub struct Choice {
    /// What the template is told.
    pub value: String,
    /// What is shown.
    pub label: String,
}

/// What was chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Value {
    /// A text or one of several.
    Text(String),
    /// Several.
    List(Vec<String>),
    /// Yes or no.
    Bool(bool),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Text(text) => f.write_str(text),
            Value::List(list) => f.write_str(&list.join(",")),
            Value::Bool(yes) => yes.fmt(f),
        }
    }
}

impl Template {
    /// The choices of the template that is built in.
    ///
    /// # Errors
    /// Its description cannot be read, which is a fault of the template.
    pub fn built_in() -> Result<Template, Error> {
        let file = FILES.iter().find(|(name, _)| *name == DESCRIPTION);
        let text = file.and_then(|(_, text)| str::from_utf8(text).ok());
        Template::read(text.ok_or_else(|| broken("there is none"))?)
    }

    /// Reads a description.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(text: &str) -> Result<Template, Error> {
        let description: Table = text.parse().map_err(broken)?;
        let mut template = Template {
            placeholders: placeholders(description.get("placeholders"))?,
            conditionals: Vec::new(),
        };
        for (when, section) in table(description.get("conditional"), "conditional")? {
            let section = table(Some(&section), &when)?;
            let placeholders = placeholders(section.get("placeholders"))?;
            template.conditionals.push(Conditional { when, placeholders });
        }
        Ok(template)
    }

    /// Every choice with its condition, if it has one.
    pub fn all(&self) -> impl Iterator<Item = (&Placeholder, Option<&str>)> {
        let always = self.placeholders.iter().map(|placeholder| (placeholder, None));
        always.chain(self.conditionals.iter().flat_map(|conditional| {
            conditional.placeholders.iter().map(|placeholder| (placeholder, Some(conditional.when.as_str())))
        }))
    }

    /// Whether there is a choice of this name.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.all().any(|(placeholder, _)| placeholder.name == name)
    }
}

fn broken(why: impl fmt::Display) -> Error {
    Error::failed(
        format!("the template's {DESCRIPTION} cannot be read: {why}"),
        "this is a fault of the template: report it, please",
    )
}

fn table(value: Option<&Toml>, name: &str) -> Result<Table, Error> {
    match value {
        None => Ok(Table::new()),
        Some(Toml::Table(table)) => Ok(table.clone()),
        Some(_) => Err(broken(format!("`{name}` is no table"))),
    }
}

fn placeholders(section: Option<&Toml>) -> Result<Vec<Placeholder>, Error> {
    let section = table(section, "placeholders")?;
    section.iter().map(|(name, value)| placeholder(name, &table(Some(value), name)?)).collect()
}

fn placeholder(name: &str, entry: &Table) -> Result<Placeholder, Error> {
    let text = |key| entry.get(key).and_then(Toml::as_str);
    let kind = match (text("type").unwrap_or("string"), entry.get("choices")) {
        ("bool", None) => Kind::YesNo,
        ("array", Some(choices)) => Kind::AnyOf(self::choices(name, choices)?),
        ("string", Some(choices)) => Kind::OneOf(self::choices(name, choices)?),
        ("string" | "text" | "editor", None) => {
            Kind::Text(text("regex").map(Regex::new).transpose().map_err(broken)?)
        }
        (other, _) => return Err(broken(format!("`{name}` is of the type `{other}` with these choices"))),
    };
    let default = entry.get("default").map(|default| match default {
        Toml::String(text) => Ok(Value::Text(text.clone())),
        Toml::Boolean(yes) => Ok(Value::Bool(*yes)),
        Toml::Array(list) => {
            let list = list.iter().map(|item| item.as_str().map(str::to_owned)).collect::<Option<_>>();
            list.map(Value::List)
                .ok_or_else(|| broken(format!("the default of `{name}` is no list of strings")))
        }
        _ => Err(broken(format!("the default of `{name}` is neither text nor list nor bool"))),
    });
    let prompt = text("prompt").ok_or_else(|| broken(format!("`{name}` has no prompt")))?;
    Ok(Placeholder { name: name.to_owned(), prompt: prompt.to_owned(), kind, default: default.transpose()? })
}

fn choices(name: &str, list: &Toml) -> Result<Vec<Choice>, Error> {
    let entries = list.as_array().ok_or_else(|| broken(format!("the choices of `{name}` are no list")))?;
    let choice = |entry: &Toml| {
        let value = entry.as_str().or_else(|| entry.get("value")?.as_str())?;
        let label = entry.get("label").and_then(Toml::as_str).unwrap_or(value);
        Some(Choice { value: value.to_owned(), label: label.to_owned() })
    };
    let choices: Option<Vec<_>> = entries.iter().map(choice).collect();
    choices
        .filter(|list| !list.is_empty())
        .ok_or_else(|| broken(format!("`{name}` has a choice without value")))
}

impl Placeholder {
    /// Reads a value as it is written after `--define name=`.
    ///
    /// # Errors
    /// [`Error::Refused`], with what it can be.
    pub fn read(&self, text: &str) -> Result<Value, Error> {
        let refused = |help: String| Error::refused(format!("{} cannot be `{text}`", self.name), help);
        match &self.kind {
            Kind::YesNo => match text {
                "true" | "yes" => Ok(Value::Bool(true)),
                "false" | "no" => Ok(Value::Bool(false)),
                _ => Err(refused("it can be: `true`, `false`".to_owned())),
            },
            Kind::Text(form) => match form {
                Some(form) if !form.is_match(text) => {
                    Err(refused(format!("it must be of the form `{form}`{}", self.default_said())))
                }
                Some(_) | None if text.contains(['\n', '\r', '\0']) => {
                    Err(refused("write it in one line".to_owned()))
                }
                Some(_) | None => Ok(Value::Text(text.to_owned())),
            },
            Kind::OneOf(choices) => {
                let values = choices.iter().map(|choice| choice.value.as_str());
                if values.clone().any(|value| value == text) {
                    return Ok(Value::Text(text.to_owned()));
                }
                Err(refused(suggestion::help(text, "it can be", values)))
            }
            Kind::AnyOf(choices) => {
                let values = choices.iter().map(|choice| choice.value.as_str());
                let list: Vec<_> =
                    text.split(',').filter(|item| !item.is_empty()).map(str::to_owned).collect();
                match list.iter().find(|item| !values.clone().any(|value| value == **item)) {
                    None => Ok(Value::List(list)),
                    Some(bad) => {
                        let help = suggestion::help(bad, "with commas between, it can have", values);
                        Err(refused(help))
                    }
                }
            }
        }
    }

    /// The default, or why there must be an answer.
    ///
    /// # Errors
    /// [`Error::Refused`] for a choice without a default.
    pub fn default(&self) -> Result<Value, Error> {
        self.default.clone().ok_or_else(|| {
            let what = format!("{} has no default: {}", self.name, self.prompt);
            Error::refused(what, format!("give it by `--define {}=..`", self.name))
        })
    }

    fn default_said(&self) -> String {
        self.default.as_ref().map(|default| format!(", such as `{default}`")).unwrap_or_default()
    }
}

/// What `--choices` prints.
impl fmt::Display for Template {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (placeholder, when) in self.all() {
            writeln!(f, "{}: {}", placeholder.name, placeholder.prompt)?;
            if let Some(when) = when {
                writeln!(f, "  only when {when}")?;
            }
            let is_default = |value: &str| match &placeholder.default {
                Some(Value::List(list)) => list.iter().any(|item| item == value),
                Some(default) => default.to_string() == value,
                None => false,
            };
            let mark = |value: &str| if is_default(value) { " [default]" } else { "" };
            match &placeholder.kind {
                Kind::Text(form) => {
                    let form = form.as_ref().map(|form| format!(" of the form {form}")).unwrap_or_default();
                    let default =
                        placeholder.default.as_ref().map(|default| format!(" [default: {default}]"));
                    writeln!(f, "  a text{form}{}", default.unwrap_or_default())?;
                }
                Kind::YesNo => {
                    for value in ["true", "false"] {
                        writeln!(f, "  {value}{}", mark(value))?;
                    }
                }
                Kind::OneOf(choices) | Kind::AnyOf(choices) => {
                    if let Kind::AnyOf(_) = placeholder.kind {
                        writeln!(f, "  any of these, with commas between")?;
                    }
                    let width = choices.iter().map(|choice| choice.value.chars().count()).max().unwrap_or(0);
                    for Choice { value, label } in choices {
                        let said = if label == value { String::new() } else { format!("  {label}") };
                        let line = format!("  {value:width$}{said}");
                        writeln!(f, "{}{}", line.trim_end(), mark(value))?;
                    }
                }
            }
        }
        Ok(())
    }
}
