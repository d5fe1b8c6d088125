//! What messages are made of: definitions in the `.msg` language of ROS 2.
//!
//! In: the name of a type, and the folder of a user's own definitions, if there is one. Out: its fields, with those of the messages in it; or what is wrong.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read as _;
use std::path::PathBuf;
use std::rc::Rc;

use mrroc_core::suggestion::{nearest, suggestion};

use super::common::common;

/// The longest file of a definition \[bytes\].
const LONGEST: u64 = 1 << 20;

/// Messages within messages, at most.
const DEEPEST: usize = 20;

/// The fields of all messages within one, at most: some definitions would have more than fit into memory.
const MOST_FIELDS: usize = 100_000;

/// Values of an array of fixed length, at most: a message of more is too long anyhow.
const MOST_VALUES: usize = 1 << 20;

/// A type of message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MessageType {
    /// Such as `geometry_msgs/msg/Twist`.
    pub name: String,
    pub fields: Vec<Field>,
}

/// A field of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    pub name: String,
    pub item: Item,
    pub count: Count,
}

/// One value of a field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Item {
    Number(Number),
    /// A text of at most so many bytes.
    Text(Option<usize>),
    Message(Rc<MessageType>),
}

/// How many values a field has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Count {
    One,
    Fixed(usize),
    /// As many as a message says, up to so many.
    Sequence(Option<usize>),
}

/// A number, or a truth value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Number {
    Bool,
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl Number {
    /// Bytes that it takes, of which its place is a multiple.
    pub const fn size(self) -> usize {
        match self {
            Number::Bool | Number::U8 | Number::I8 => 1,
            Number::U16 | Number::I16 => 2,
            Number::U32 | Number::I32 | Number::F32 => 4,
            Number::U64 | Number::I64 | Number::F64 => 8,
        }
    }

    /// Its name in definitions.
    const fn name(self) -> &'static str {
        match self {
            Number::Bool => "bool",
            Number::U8 => "uint8",
            Number::I8 => "int8",
            Number::U16 => "uint16",
            Number::I16 => "int16",
            Number::U32 => "uint32",
            Number::I32 => "int32",
            Number::U64 => "uint64",
            Number::I64 => "int64",
            Number::F32 => "float32",
            Number::F64 => "float64",
        }
    }

    fn of(word: &str) -> Option<Number> {
        Some(match word {
            "bool" => Number::Bool,
            "byte" | "char" | "uint8" => Number::U8,
            "int8" => Number::I8,
            "uint16" => Number::U16,
            "int16" => Number::I16,
            "uint32" => Number::U32,
            "int32" => Number::I32,
            "uint64" => Number::U64,
            "int64" => Number::I64,
            "float32" => Number::F32,
            "float64" => Number::F64,
            _ => return None,
        })
    }
}

impl Item {
    /// The fewest bytes that it takes.
    pub const fn least(&self) -> usize {
        match self {
            Item::Number(number) => number.size(),
            // Its length.
            Item::Text(_) => 4,
            Item::Message(_) => 1,
        }
    }

    /// What it is called.
    pub fn called(&self) -> String {
        match self {
            Item::Number(number) => format!("a value of type {}", number.name()),
            Item::Text(_) => "a text".to_owned(),
            Item::Message(message) => format!("a message {}", message.name),
        }
    }
}

/// What is wrong with a type, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wrong {
    pub what: String,
    pub help: String,
}

impl Wrong {
    fn new(what: String, help: &str) -> Wrong {
        Wrong { what, help: help.to_owned() }
    }
}

/// The definitions that there are.
pub struct Definitions {
    /// The folder of the packages of the user's own.
    folder: Option<PathBuf>,
    fields: usize,
    /// Types that were read, and the number of their fields with those of the messages in them.
    known: BTreeMap<String, (Rc<MessageType>, usize)>,
}

impl Definitions {
    /// Those of a folder, and the common ones.
    pub const fn new(folder: Option<PathBuf>) -> Definitions {
        Definitions { folder, fields: 0, known: BTreeMap::new() }
    }

    /// The type of this name.
    ///
    /// # Errors
    /// It is not known, or cannot be read.
    pub fn message(&mut self, name: &str) -> Result<Rc<MessageType>, Wrong> {
        self.read(name, &mut Vec::new())
    }

    /// Reads a type that is in those of `within`.
    fn read(&mut self, name: &str, within: &mut Vec<String>) -> Result<Rc<MessageType>, Wrong> {
        let help = "correct the definitions";
        if within.iter().any(|outer| outer == name) {
            return Err(Wrong::new(format!("{name} contains itself"), help));
        }
        if within.len() == DEEPEST {
            return Err(Wrong::new(format!("{name} is nested in more than {DEEPEST} messages"), help));
        }
        if let Some((known, count)) = self.known.get(name) {
            self.fields += count;
            if self.fields > MOST_FIELDS {
                return Err(Wrong::new(format!("with {name}, it has more than {MOST_FIELDS} fields"), help));
            }
            return Ok(Rc::clone(known));
        }
        let before = self.fields;
        let text = self.text(name)?;
        within.push(name.to_owned());
        let package = name.split('/').next().unwrap_or_default();
        let mut fields = Vec::new();
        for (i, line) in text.lines().enumerate() {
            let wrong = |what: &str| {
                let what = format!("{name}, line {}: {what}: `{}`", i + 1, line.trim());
                Wrong::new(what, "write lines `TYPE NAME` of the .msg language of ROS 2")
            };
            let Some(line) = Line::of(line).map_err(wrong)? else { continue };
            self.fields += 1;
            if self.fields > MOST_FIELDS {
                return Err(wrong("too many fields"));
            }
            let item = match line.item {
                Named::Item(item) => item,
                Named::Message(message) => {
                    let whole = whole_name(package, message).ok_or_else(|| wrong("no type of a message"))?;
                    Item::Message(self.read(&whole, within)?)
                }
            };
            fields.push(Field { name: line.name.to_owned(), item, count: line.count });
        }
        if fields.is_empty() {
            // What ROS 2 sends where there is nothing.
            let name = "structure_needs_at_least_one_member".to_owned();
            fields.push(Field { name, item: Item::Number(Number::U8), count: Count::One });
        }
        within.pop();
        let message = Rc::new(MessageType { name: name.to_owned(), fields });
        self.known.insert(name.to_owned(), (Rc::clone(&message), self.fields - before));
        Ok(message)
    }

    /// The text of a definition. What is in the user's folder counts first.
    fn text(&self, name: &str) -> Result<String, Wrong> {
        if let [package, "msg", kind] = name.split('/').collect::<Vec<_>>()[..]
            && let Some(folder) = &self.folder
            && [package, kind].into_iter().all(is_word)
        {
            let path = folder.join(package).join("msg").join(format!("{kind}.msg"));
            let failed = |error: &dyn core::fmt::Display| {
                Wrong::new(
                    format!("{}: {error}", path.display()),
                    "see whether it is a definition of a message",
                )
            };
            match File::open(&path) {
                Ok(file) => {
                    let mut text = String::new();
                    file.take(LONGEST + 1).read_to_string(&mut text).map_err(|error| failed(&error))?;
                    let is_short = text.len() as u64 <= LONGEST;
                    return if is_short { Ok(text) } else { Err(failed(&"it has more than 1 MiB")) };
                }
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
                Err(error) => return Err(failed(&error)),
            }
        }
        common()
            .find(|(known, _)| *known == name)
            .map(|(_, text)| text.to_owned())
            .ok_or_else(|| self.unknown(name))
    }

    fn unknown(&self, name: &str) -> Wrong {
        let known: Vec<_> = common().map(|(known, _)| known).collect();
        let package = name.split('/').next().unwrap_or_default();
        let folder = match &self.folder {
            Some(folder) => format!("or put it at {}", folder.join(format!("{name}.msg")).display()),
            None => format!(
                "or write `definitions = \"FOLDER\"`: the folder that has {name}.msg, such as `src` or `install/{package}/share` of your workspace, or /opt/ros/jazzy/share"
            ),
        };
        let help = match nearest(name, &known) {
            Some(meant) => format!("did you mean `{meant}`? {folder}"),
            None => format!("{}; {folder}", suggestion(name, &known, "write one of those that are known")),
        };
        Wrong { what: format!("no definition of {name}"), help }
    }
}

/// A letter, then letters, digits and underscores.
fn is_word(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic())
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// The name of a type of message, `package/msg/Name`, as a definition of this package names it; `None`: it is none.
pub fn whole_name(package: &str, named: &str) -> Option<String> {
    match named.split('/').collect::<Vec<_>>()[..] {
        [name] => Some(format!("{package}/msg/{name}")),
        [package, name] | [package, "msg", name] => Some(format!("{package}/msg/{name}")),
        _ => None,
    }
}

/// A line with a field.
pub struct Line<'a> {
    pub item: Named<'a>,
    count: Count,
    name: &'a str,
}

/// The type of a field, as it is named.
pub enum Named<'a> {
    Item(Item),
    Message(&'a str),
}

impl<'a> Line<'a> {
    /// `None` for a line without a field: a comment, or a constant.
    pub fn of(line: &'a str) -> Result<Option<Line<'a>>, &'static str> {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            return Ok(None);
        }
        let (kind, rest) = line.split_once(char::is_whitespace).ok_or("no name of a field")?;
        let rest = rest.trim_start();
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
        let (name, rest) = rest.split_at(end);
        if !is_word(name) {
            return Err("no name of a field");
        }
        if rest.trim_start().starts_with('=') {
            return Ok(None);
        }
        // What follows is a default, or a comment.
        if rest.starts_with(|c: char| !c.is_whitespace() && c != '#') {
            return Err("no name of a field");
        }
        let (one, count) =
            match kind.strip_suffix(']').map(|kind| kind.rsplit_once('[').ok_or("a bracket is missing")) {
                None => (kind, Count::One),
                Some(split) => {
                    let (one, count) = split?;
                    let number = |text: &str| {
                        text.parse()
                            .ok()
                            .filter(|n| (1..=MOST_VALUES).contains(n))
                            .ok_or("no such number of values")
                    };
                    let count = match (count, count.strip_prefix("<=")) {
                        ("", _) => Count::Sequence(None),
                        (_, Some(most)) => Count::Sequence(Some(number(most)?)),
                        (fixed, None) => Count::Fixed(number(fixed)?),
                    };
                    (one, count)
                }
            };
        let bound = |most: &str| most.parse().map(Some).map_err(|_| "no such length of a text");
        let item = match (Number::of(one), one.strip_prefix("string")) {
            (Some(number), _) => Named::Item(Item::Number(number)),
            (None, Some("")) => Named::Item(Item::Text(None)),
            (None, Some(most)) if most.starts_with("<=") => Named::Item(Item::Text(bound(&most[2..])?)),
            (None, _) if one.starts_with("wstring") => {
                return Err("a wstring, whose form differs between implementations");
            }
            (None, _) if one.split('/').all(is_word) => Named::Message(one),
            (None, _) => return Err("no type of a field"),
        };
        Ok(Some(Line { item, count, name }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_folder(name: &str, files: &[(&str, &str)], of: &str) -> Result<Rc<MessageType>, Wrong> {
        let folder = std::env::temp_dir().join(format!("mrroc-msg-{}-{name}", std::process::id()));
        std::fs::create_dir_all(folder.join("own/msg")).expect("a folder");
        for (file, text) in files {
            std::fs::write(folder.join(format!("own/msg/{file}.msg")), text).expect("written");
        }
        let read = Definitions::new(Some(folder.clone())).message(of);
        std::fs::remove_dir_all(folder).expect("removed");
        read
    }

    #[test]
    fn all_common_definitions_can_be_read() {
        for (name, _) in common() {
            let message =
                Definitions::new(None).message(name).unwrap_or_else(|wrong| panic!("{name}: {wrong:?}"));
            assert!(!message.fields.is_empty(), "{name}");
        }
        assert!(common().count() > 50);
    }

    #[test]
    fn a_definition_has_fields_and_neither_constants_nor_comments() {
        let text = "# what it is\nint32 MOST=7\nstring KIND = \"a # b\"\n\nbool on true # whether\nstring<=5 said \"a=b\"\n\
                    float32[] many\nuint8[<=3] few\nint16[2] two\nInner in\nown/Inner[] more\nbuiltin_interfaces/Time at\n";
        let message = in_folder("fields", &[("Outer", text), ("Inner", "")], "own/msg/Outer").expect("read");
        let told: Vec<_> = message
            .fields
            .iter()
            .map(|field| format!("{} {} {:?}", field.name, field.item.called(), field.count))
            .collect();
        assert_eq!(
            told,
            [
                "on a value of type bool One",
                "said a text One",
                "many a value of type float32 Sequence(None)",
                "few a value of type uint8 Sequence(Some(3))",
                "two a value of type int16 Fixed(2)",
                "in a message own/msg/Inner One",
                "more a message own/msg/Inner Sequence(None)",
                "at a message builtin_interfaces/msg/Time One",
            ]
        );
        assert_eq!(message.fields[1].item, Item::Text(Some(5)));
        let Item::Message(inner) = &message.fields[5].item else { panic!("{message:?}") };
        assert_eq!(inner.fields[0].name, "structure_needs_at_least_one_member");
    }

    #[test]
    fn what_is_wrong_with_a_definition_is_named_with_its_line() {
        for (text, told) in [
            ("float64", "own/msg/Bad, line 1: no name of a field"),
            ("float64 x\nfloat64 9x", "line 2: no name of a field"),
            ("float64 x-y", "no name of a field"),
            ("float64[ x", "no type of a field"),
            ("float64] x", "a bracket is missing"),
            ("float64[0] x", "no such number of values"),
            ("float64[99999999999999999999] x", "no such number of values"),
            ("float64[<=x] x", "no such number of values"),
            ("string<=many x", "no such length of a text"),
            ("wstring x", "a wstring, whose form differs"),
            ("a/b/c/d x", "no type of a message"),
            ("../etc x", "no type of a field"),
            ("Bad x", "own/msg/Bad contains itself"),
            ("Other x", "no definition of own/msg/Other"),
        ] {
            let wrong = in_folder("wrong", &[("Bad", text)], "own/msg/Bad").expect_err(told);
            assert!(wrong.what.contains(told), "{told}: {wrong:?}");
        }
        let long = "x".repeat(LONGEST as usize + 1);
        let wrong = in_folder("long", &[("Bad", &long)], "own/msg/Bad").expect_err("too long");
        assert!(wrong.what.contains("more than 1 MiB"), "{wrong:?}");
        let wrong = Definitions::new(None).message("own/msg/Gauge").expect_err("not known");
        assert!(
            wrong
                .help
                .contains("the folder that has own/msg/Gauge.msg, such as `src` or `install/own/share`"),
            "{wrong:?}"
        );
        let wrong = Definitions::new(None).message("geometry_msgs/msg/TwistStampd").expect_err("not known");
        assert!(wrong.help.contains("did you mean `geometry_msgs/msg/TwistStamped`?"), "{wrong:?}");
    }

    #[test]
    fn definitions_that_would_fill_the_memory_are_refused() {
        // Each level has the one below it ten times: 10^19 fields.
        let files: Vec<_> = (0..19)
            .map(|i| (format!("L{i}"), (0..10).map(|k| format!("L{} x{k}\n", i + 1)).collect::<String>()))
            .chain([("L19".to_owned(), "bool x".to_owned())])
            .collect();
        let files: Vec<_> = files.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
        let wrong = in_folder("bomb", &files, "own/msg/L0").expect_err("too many");
        assert!(wrong.what.contains("it has more than 100000 fields"), "{wrong:?}");
    }
}
