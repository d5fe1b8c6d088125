//! Names use the terms of the field: words that once stood for them do not come back.
//!
//! Looked at are the `.rs`, `.md` and `.toml` files of the repository, without the decisions and the changelog, which tell of the past.
//! `way` may stand in a text, as "on the way" or "the other way round", and in a test's name, but is no name of the code.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::root;

/// The beginning of a word that may not stand in a text or in a name, how many letters may follow it, and what is said instead.
const WORDS: &[(&str, usize, &str)] = &[
    ("witness", 3, "an observer of steps"),
    ("onlook", 4, "a subscriber, a monitor"),
    ("desk", 1, "a console session, the console server"),
    ("door", 6, "a gateway, a listener, a policy of origins"),
    ("nudg", 3, "a trigger"),
    ("obey", 3, "to serve orders; to follow, to apply, to satisfy"),
    ("headroom", 1, "a rate margin"),
    ("patience", 1, "a timeout"),
    ("judg", 5, "a test, a check, a comparison; to evaluate"),
    ("course", 1, "a path, a trajectory"),
    ("screw", 1, "a twist"),
];

/// Where a word stands for what it means: its beginning, the file or folder, and why.
const ALLOWED: &[(&str, &str, &str)] = &[
    ("desk", "docs/safety/devices.toml", "Desk is the web interface of a Franka"),
    ("desk", "docs/src/faults.md", "Desk is the web interface of a Franka"),
    ("desk", "docs/src/real-robots.md", "Desk is the web interface of a Franka"),
    ("desk", "docs/src/tutorial/6-real-robot.md", "a table"),
    ("desk", "robots/drivers/franka/", "Desk is the web interface of a Franka"),
    ("door", "docs/src/real-robots.md", "a door, as an input"),
    ("door", "docs/src/signals.md", "a door, as an input"),
    ("door", "generators-lib/examples/06_conditions.rs", "a door"),
    ("door", "generators-lib/pictures/README.md", "a door"),
    ("door", "generators-lib/tests/pictures/examples.rs", "a door"),
    ("door", "ports/zenoh/src/certificates.rs", "the name in certificates that are in use"),
    ("door", "ports/zenoh/src/tests.rs", "the name in certificates that are in use"),
    ("door", "robots/drivers/ur-controller/src/", "the door of a guarded cell"),
    ("door", "robots/drivers/ur/", "the door of a guarded cell"),
    ("door", "runtime/core/src/model/robot_stop.rs", "the door of a guarded cell"),
    ("door", "runtime/processes/src/launch/latch_notes.rs", "the name of a guard"),
    ("door", "tests/runtime/signals.rs", "a door, as an input"),
    ("nudg", "runtime/core/src/model/payload.rs", "the text that identifies the order on the wire"),
    ("screw", "SAFETY.md", "the motion along and about an axis"),
    ("screw", "docs/src/faults.md", "the motion along and about an axis"),
    ("screw", "docs/src/glossary.md", "the motion along and about an axis"),
    ("screw", "docs/src/stops.md", "the motion along and about an axis"),
    ("screw", "generators-lib/", "the motion along and about an axis"),
    ("screw", "robots/src/", "a ball screw"),
    ("screw", "robots/tests/", "a ball screw, and a joint that URDF does not have"),
    ("screw", "sensing/calibration/", "a ball screw"),
    ("screw", "tasks/calibration/", "a ball screw"),
    ("screw", "tasks/engraving/", "the motion along and about an axis"),
    ("", "tests/layers/words.rs", "this list"),
];

/// Words that are no name of the code, nor a part of one, and what is said instead.
const NAMES: (&[&str], &str) =
    (&["way", "ways"], "a displacement, a distance, a path, a motion, a direction, a method");

/// A name of more words is a sentence.
const SENTENCE: usize = 4;

/// What tells of the past.
const PAST: &[&str] = &["docs/decisions", "CHANGELOG.md"];

/// The files that are looked at, by their paths below the root.
fn files() -> Vec<(String, PathBuf)> {
    let (top, mut found) = (root(), Vec::new());
    let mut folders = vec![top.clone()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder").map(|entry| entry.expect("an entry")) {
            let (path, name) = (entry.path(), entry.file_name());
            let name = name.to_string_lossy();
            let below = path.strip_prefix(&top).expect("below it").to_string_lossy().replace('\\', "/");
            if name.starts_with('.') || PAST.contains(&&*below) {
                continue;
            }
            let kind = entry.file_type().expect("a kind");
            if kind.is_dir() && !["target", "node_modules"].contains(&&*name) {
                folders.push(path);
            } else if kind.is_file() && [".rs", ".md", ".toml"].iter().any(|end| name.ends_with(end)) {
                found.push((below, path));
            }
        }
    }
    found.sort();
    found
}

/// The words of a line, in lower case: `SharedThing_of` has three.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let (mut before, mut letters) = (' ', line.chars().peekable());
    while let Some(letter) = letters.next() {
        // A capital begins a word behind a small letter, or before one: `HTTPServer`.
        let before_small = letters.peek().is_some_and(|next| next.is_lowercase());
        let begins =
            letter.is_uppercase() && (before.is_lowercase() || before.is_uppercase() && before_small);
        if begins || !letter.is_alphabetic() {
            words.push(String::new());
        }
        if letter.is_alphabetic() {
            words.last_mut().expect("there is one").extend(letter.to_lowercase());
        }
        before = letter;
    }
    words.retain(|word| !word.is_empty());
    words
}

/// The names in a line of code, outside of its comments and texts; `in_text` says whether it begins in a text, and then whether
/// the next one does.
fn names(line: &str, in_text: &mut bool) -> Vec<String> {
    let line = line.replace(r"\\", "").replace(r#"\""#, "").replace(r#"'"'"#, "");
    let mut names = Vec::new();
    for (i, part) in line.split('"').enumerate() {
        *in_text ^= i > 0;
        if *in_text {
            continue;
        }
        let code = part.split("//").next().unwrap_or_default();
        let all = code.split(|letter: char| !letter.is_alphanumeric() && letter != '_');
        names.extend(all.filter(|name| !name.is_empty()).map(str::to_owned));
        if code.len() < part.len() {
            break;
        }
    }
    names
}

/// Whether a name is, or has, a word that is no name of the code.
fn is_no_name(name: &str) -> bool {
    let words = words(name);
    words.len() <= SENTENCE && words.iter().any(|word| NAMES.0.contains(&&**word))
}

/// Which of the words that may not stand there this is.
fn forbidden(word: &str) -> Option<&'static (&'static str, usize, &'static str)> {
    let is = |(begins, more, _): &&(&str, usize, &str)| {
        word.strip_prefix(begins).is_some_and(|rest| rest.chars().count() <= *more)
    };
    WORDS.iter().find(is)
}

/// Which exception lets a word stand in a file.
fn exception(begins: &str, file: &str) -> Option<usize> {
    let lets = |(word, place, _): &(&str, &str, &str)| {
        let is_there = if place.ends_with('/') { file.starts_with(place) } else { file == *place };
        is_there && (word.is_empty() || *word == begins)
    };
    ALLOWED.iter().position(lets)
}

#[test]
fn words_that_terms_of_the_field_have_replaced_do_not_come_back() {
    let (mut wrong, mut used) = (Vec::new(), BTreeSet::new());
    let files = files();
    assert!(files.len() > 1000, "{} files", files.len());
    for (file, path) in files {
        let text = fs::read_to_string(Path::new(&path)).expect("a text");
        let mut in_text = false;
        for (number, line) in text.lines().enumerate() {
            let is_code = file.ends_with(".rs") && exception("way", &file).is_none();
            let names = if is_code { names(line, &mut in_text) } else { Vec::new() };
            for name in names.iter().filter(|name| is_no_name(name)) {
                wrong.push(format!("{file}:{}: `{name}`: say {}", number + 1, NAMES.1));
            }
            for word in words(line) {
                let Some((begins, _, instead)) = forbidden(&word) else { continue };
                match exception(begins, &file) {
                    Some(place) => drop(used.insert(place)),
                    None => wrong.push(format!("{file}:{}: `{word}`: say {instead}", number + 1)),
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let unused: Vec<_> =
        (0..ALLOWED.len()).filter(|place| !used.contains(place)).map(|place| ALLOWED[place]).collect();
    assert!(unused.is_empty(), "exceptions that nothing needs: {unused:?}");
}

#[test]
fn names_are_taken_apart() {
    let all = |line: &str| words(line).join(" ");
    assert_eq!(all("let shared_desk = SharedDesk::of(DESKS);"), "let shared desk shared desk of desks");
    assert_eq!(all("HTTPServer2Door"), "http server door");
    assert_eq!(forbidden("nudging").map(|found| found.0), Some("nudg"));
    assert_eq!(forbidden("desks").map(|found| found.0), Some("desk"));
    for other in ["desktop", "patient", "indoor", "serve"] {
        assert!(forbidden(other).is_none(), "{other}");
    }
}

#[test]
fn names_of_the_code_are_told_from_texts_comments_and_sentences() {
    let (mut in_text, mut found) = (false, Vec::new());
    for line in [
        r#"let way_points = "by the way"; // on the way"#,
        r#"const TEXT: &str = "say \" on the"#,
        "way back, and",
        r#"    the rest"; if letter == '"' { LEAST_WAY } else { Ways::No }"#,
        r#"/// "All the way"#,
        "fn a_robot_on_its_way_to_rest() { always(away); }",
    ] {
        found.extend(names(line, &mut in_text).into_iter().filter(|name| is_no_name(name)));
    }
    assert_eq!(found, ["way_points", "LEAST_WAY", "Ways"]);
}
