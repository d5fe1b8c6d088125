//! The Python module of a sensor: the words of its readings and orders as classes, and the port.
//!
//! In: the shapes of a sensor's readings and configurations. Out: the text of a module.

use core::fmt::Write;
use std::net::SocketAddr;

use mrroc::payload::{Shape, Wire};
use mrroc::robot::MAX_JOINTS;
use mrroc::sensor::Sensor;

/// The module without what differs from sensor to sensor.
const MODULE: &str = include_str!("python/port.py");

/// The port itself, on the cell's machine and on another one.
const HERE: &str = include_str!("python/here.py");
const ELSEWHERE: &str = include_str!("python/elsewhere.py");

/// What it has in common with that of a subscriber: how words are read.
pub(crate) const VALUES: &str = include_str!("python/values.py");

/// What it has in common with that of a simulator.
const ENDS: &str = include_str!("python/ends.py");

/// Words that Python reads as something else.
const KEYWORDS: [&str; 35] = [
    "False", "None", "True", "and", "as", "assert", "async", "await", "break", "class", "continue", "def",
    "del", "elif", "else", "except", "finally", "for", "from", "global", "if", "import", "in", "is",
    "lambda", "nonlocal", "not", "or", "pass", "raise", "return", "try", "while", "with", "yield",
];

/// The module of the sensor `name` at a port, whose program sends so many readings a second, from another machine if the cell
/// waits for it at an address.
pub(crate) fn module<K: Sensor>(name: &str, port: &str, rate: f64, address: Option<SocketAddr>) -> String {
    let (reading, configuration) =
        (fields(<K::Reading as Wire>::SHAPE), fields(<K::Configuration as Wire>::SHAPE));
    let mut classes = String::new();
    let read = class("Reading", "What the sensor reads.", &reading, &mut classes);
    let chosen = class("Configuration", "What the cell chooses with an order.", &configuration, &mut classes);
    let _ = write!(classes, "\nREADING = {read}\nCONFIGURATION = {chosen}\n");
    let (needs, library, port_class, ends) = match address {
        None => ("iceoryx2==0.10.0, on the cell's machine", "iceoryx2 as iox2", HERE, ENDS),
        Some(_) => ("eclipse-zenoh==1.10.2, on any machine", "zenoh", ELSEWHERE, ""),
    };
    let imports: &[&str] =
        if address.is_some() { &["json", "os", "secrets", "struct", "time"] } else { &["os", "struct"] };
    let imports: String = imports.iter().map(|module| format!("import {module}\n")).collect();
    let place = match address {
        None => format!("PORT = \"{port}\""),
        Some(address) => format!("SENSOR = \"{name}\"\nADDRESS = \"{address}\"  # of the cell"),
    };
    MODULE
        .replace("@NEEDS@", needs)
        .replace("@LIBRARY@", library)
        .replace("@IMPORTS@", &imports)
        .replace("@PLACE@", &place)
        .replace("@PORT_CLASS@", port_class.trim_end())
        .replace("@ENDS@", ends.trim_end())
        .replace("@VALUES@", VALUES.trim_end())
        .replace("@CLASSES@", &classes)
        .replace("@EXAMPLE@", &arguments("Reading", &reading))
        .replace("@NAME@", name)
        .replace("@RATE@", &format!("{rate:?}"))
        .replace("@LAYOUT@", &format!("0x{:016X}", <K::Reading as Wire>::LAYOUT))
        .replace("@MAX_JOINTS@", &MAX_JOINTS.to_string())
}

/// Writes the class of a sensor's readings for a subscriber, which has this name; returns what it is among shapes.
pub(crate) fn reading_class(name: &str, sensor: &str, shape: &'static Shape, classes: &mut String) -> String {
    class(name, &format!("What the sensor `{sensor}` reads."), &fields(shape), classes)
}

/// The fields of a value that has a class of its own: one that has none has one, `value`.
fn fields(shape: &'static Shape) -> Vec<(&'static str, &'static Shape)> {
    if let Shape::Fields(fields) = shape { fields.to_vec() } else { vec![("value", shape)] }
}

/// Writes a class of fields, after those of its fields; returns what it is among shapes.
fn class(name: &str, told: &str, fields: &[(&str, &Shape)], classes: &mut String) -> String {
    let parts: Vec<_> = fields
        .iter()
        .map(|(field, shape)| part(&format!("{name}{}", camel(field)), shape, classes))
        .collect();
    let _ = write!(classes, "\nclass {name}(NamedTuple):\n    \"\"\"{told}\"\"\"\n\n");
    for ((field, shape), (of, _)) in fields.iter().zip(&parts) {
        let _ = writeln!(classes, "    {}: {of}{}", own(field), comment(shape));
    }
    if fields.is_empty() {
        classes.push_str("    pass\n");
    }
    classes.push('\n');
    let parts: Vec<_> = parts.into_iter().map(|(_, part)| part).collect();
    let comma = if parts.len() == 1 { "," } else { "" };
    format!("(\"fields\", {name}, ({}{comma}))", parts.join(", "))
}

/// The Python type of a part, and what it is among shapes.
fn part(name: &str, shape: &Shape, classes: &mut String) -> (String, String) {
    let of = |python: &str, shape: &str| (python.to_owned(), format!("\"{shape}\""));
    match shape {
        Shape::Float => of("float", "float"),
        Shape::Single => of("float", "single"),
        Shape::Unsigned => of("int", "unsigned"),
        Shape::Signed => of("int", "signed"),
        Shape::Truth => of("bool", "truth"),
        Shape::Choice(names) => {
            let _ = write!(classes, "\nclass {name}(IntEnum):\n");
            for (i, choice) in names.iter().enumerate() {
                let _ = writeln!(classes, "    {} = {i}", own(&snake(choice)).to_uppercase());
            }
            classes.push('\n');
            (name.to_owned(), format!("(\"choice\", {name})"))
        }
        Shape::Array(item, count) => {
            let (_, item) = part(name, item, classes);
            ("tuple".to_owned(), format!("(\"array\", {item}, {count})"))
        }
        Shape::Fields(fields) => (name.to_owned(), class(name, "A part of it.", fields, classes)),
        Shape::Variants(_) | Shape::Demand | Shape::Words(_) => {
            ("tuple".to_owned(), format!("(\"words\", {})", shape.len()))
        }
    }
}

/// What a type does not say.
fn comment(shape: &Shape) -> String {
    match shape {
        Shape::Array(_, count) => format!("  # {count} values"),
        Shape::Variants(_) | Shape::Demand | Shape::Words(_) => "  # words, as they are".to_owned(),
        _ => String::new(),
    }
}

/// A value of this shape, whose class has this name.
fn example(name: &str, shape: &Shape) -> String {
    match shape {
        Shape::Float | Shape::Single => "0.0".to_owned(),
        Shape::Unsigned | Shape::Signed => "0".to_owned(),
        Shape::Truth => "True".to_owned(),
        Shape::Choice(_) => format!("{name}(0)"),
        Shape::Array(item, count) => {
            let items: Vec<_> = (0..*count).map(|_| example(name, item)).collect();
            format!("[{}]", items.join(", "))
        }
        Shape::Fields(fields) => format!("{name}({})", arguments(name, fields)),
        Shape::Variants(_) | Shape::Demand | Shape::Words(_) => format!("[0] * {}", shape.len()),
    }
}

/// Values of fields, as arguments.
fn arguments(name: &str, fields: &[(&str, &Shape)]) -> String {
    let one = |(field, shape): &(&str, &Shape)| {
        format!("{}={}", own(field), example(&format!("{name}{}", camel(field)), shape))
    };
    fields.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// A name that Python takes as one.
pub(crate) fn own(name: &str) -> String {
    if KEYWORDS.contains(&name) {
        format!("{name}_")
    } else if name.starts_with(|c: char| c.is_ascii_digit() || c == '_') {
        format!("v{name}")
    } else {
        name.to_owned()
    }
}

/// `part_pose` as `PartPose`.
pub(crate) fn camel(name: &str) -> String {
    let words = name.split('_').filter(|word| !word.is_empty());
    words.map(|word| word[..1].to_uppercase() + &word[1..]).collect()
}

/// `NotSeen` as `Not_Seen`.
fn snake(name: &str) -> String {
    let mut out = String::new();
    for (i, c) in name.char_indices() {
        if i > 0 && c.is_uppercase() {
            out.push('_');
        }
        out.push(c);
    }
    out
}
