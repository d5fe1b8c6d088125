//! Names of projects: what Cargo takes for a package that can be built, tested and depended on.

use crate::error::Error;

/// Rust's keywords, none of which can name a crate or a module.
const KEYWORDS: &[&str] = &[
    "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "crate", "do", "dyn",
    "else", "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in", "let", "loop",
    "macro", "match", "mod", "move", "mut", "override", "priv", "pub", "ref", "return", "self", "static",
    "struct", "super", "trait", "true", "try", "type", "typeof", "unsafe", "unsized", "use", "virtual",
    "where", "while", "yield",
];

/// Crates that a project sees already, folders of Cargo's, files that Windows keeps for devices, and a
/// word of this program's.
const TAKEN: &[(&str, &[&str])] = &[
    ("is a crate of Rust's", &["alloc", "core", "proc_macro", "std", "test"]),
    (
        "is a crate that the project depends on",
        &["mrroc", "mrroc_generators", "mrroc_macros", "mrroc_pictures", "mrroc_robots", "nalgebra"],
    ),
    ("is a folder of Cargo's", &["build", "deps", "examples", "incremental", "target"]),
    ("is a device on Windows", &["aux", "con", "nul", "prn"]),
    ("is a command of this program", &["generator"]),
];

/// Whether a word is kept for the language.
pub fn is_keyword(word: &str) -> bool {
    KEYWORDS.contains(&word)
}

/// Whether `name` can name a project.
///
/// # Errors
/// [`Error::Refused`] with a name like it that can.
pub fn check(name: &str) -> Result<(), Error> {
    if let Some((folder, last)) = name.trim_end_matches(['/', '\\']).rsplit_once(['/', '\\']) {
        let what = format!("`{name}` is a path, not the name of a project");
        let folder = if folder.is_empty() { "/" } else { folder };
        return Err(Error::refused(what, format!("write `--into {folder} {}`", good(last))));
    }
    let Some(why) = fault(name) else { return Ok(()) };
    Err(Error::refused(
        format!("`{name}` cannot name a project: {why}"),
        format!("`{}` can; letters, digits, `-` and `_` make a name", good(name)),
    ))
}

fn fault(name: &str) -> Option<String> {
    let known = name.replace('-', "_").to_lowercase();
    if name.is_empty() {
        return Some("it is empty".to_owned());
    }
    if let Some(bad) = name.chars().find(|c| !c.is_ascii_alphanumeric() && !matches!(c, '-' | '_')) {
        return Some(format!("{bad:?} is in it"));
    }
    if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        return Some("it does not begin with a letter".to_owned());
    }
    if is_keyword(&known) {
        return Some("it is a keyword of Rust".to_owned());
    }
    TAKEN.iter().find(|(_, names)| names.contains(&known.as_str())).map(|(why, _)| format!("it {why}"))
}

/// A name like `name` that can name a project.
fn good(name: &str) -> String {
    let mut words = String::new();
    for c in name.chars() {
        match c {
            'a'..='z' | 'A'..='Z' | '0'..='9' | '_' => words.push(c),
            _ if words.is_empty() || words.ends_with('-') => {}
            _ => words.push('-'),
        }
    }
    let words = words.trim_matches(['-', '_']);
    match words {
        "" => "my-task".to_owned(),
        _ if !words.starts_with(|c: char| c.is_ascii_alphabetic()) => format!("task-{words}"),
        _ if fault(words).is_some() => format!("my-{words}"),
        _ => words.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_packages_are_taken() {
        for name in ["my-task", "my_task", "Cell7", "a", "engraving"] {
            assert_eq!(check(name), Ok(()), "{name}");
        }
    }

    #[test]
    fn other_names_are_refused_with_one_that_can_be_taken() {
        for (name, instead) in [
            ("", "my-task"),
            ("7up", "task-7up"),
            ("my task", "my-task"),
            ("żółw", "w"),
            ("-x", "x"),
            ("test", "my-test"),
            ("Match", "my-Match"),
            ("mrroc-robots", "my-mrroc-robots"),
            ("mrroc-pictures", "my-mrroc-pictures"),
            ("con", "my-con"),
            ("🤖", "my-task"),
            ("_", "my-task"),
            ("a{{b}}", "a-b"),
        ] {
            let error = check(name).expect_err(name);
            assert!(error.to_string().contains(&format!("`{instead}` can;")), "{error}");
            assert_eq!(check(instead), Ok(()), "{instead}");
            assert_eq!(error.status(), 2);
        }
        assert!(check("a/b").expect_err("a path").to_string().contains("write `--into a b`"));
        assert!(check("/b/").expect_err("a path").to_string().contains("write `--into / b`"));
    }
}
