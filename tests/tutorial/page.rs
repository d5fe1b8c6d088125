//! A page of the tutorial as what a newcomer does: commands, what they print, and edits.

use std::path::{Path, PathBuf};

/// The folder of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

pub fn read(path: impl AsRef<Path>) -> String {
    let path = path.as_ref();
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All pages of the book, by name below `docs/src`.
pub fn pages() -> Vec<(String, String)> {
    fn collect(folder: &Path, below: &str, pages: &mut Vec<(String, String)>) {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let name = path.file_name().and_then(|name| name.to_str()).expect("a plain name");
            if path.is_dir() {
                collect(&path, &format!("{below}{name}/"), pages);
            } else if name.ends_with(".md") {
                pages.push((format!("{below}{name}"), read(&path)));
            }
        }
    }
    let mut pages = Vec::new();
    collect(&root().join("docs/src"), "", &mut pages);
    pages.sort();
    pages
}

/// The chapters of the tutorial, in order.
pub fn chapters() -> Vec<(String, String)> {
    pages().into_iter().filter(|(name, _)| name.starts_with("tutorial/")).collect()
}

/// What `path:anchor` stands for, a file below `folder` or the part of it between two comments.
pub fn included(folder: &Path, what: &str) -> Result<String, String> {
    let (path, anchor) = what.split_once(':').map_or((what, None), |(path, anchor)| (path, Some(anchor)));
    let text = std::fs::read_to_string(folder.join(path)).map_err(|error| format!("{path}: {error}"))?;
    let mark = |line: &str, word: &str| line.split_once(word).map(|(_, name)| name.trim().to_owned());
    let mut inside = anchor.is_none();
    let (mut kept, mut ended) = (String::new(), anchor.is_none());
    for line in text.lines() {
        if let Some(name) = mark(line, "ANCHOR_END:") {
            if Some(name.as_str()) == anchor {
                (inside, ended) = (false, true);
            }
        } else if let Some(name) = mark(line, "ANCHOR:") {
            inside |= Some(name.as_str()) == anchor;
        } else if inside {
            kept += line;
            kept.push('\n');
        }
    }
    if kept.is_empty() || !ended {
        return Err(format!("{path} has no anchor {anchor:?} with an end"));
    }
    Ok(kept)
}

/// The blocks of code that a page shows of a file, `<!-- code: path:anchor -->` before each: the file, and the code.
pub fn shown(text: &str) -> impl Iterator<Item = (&str, &str)> {
    text.split("<!-- code: ").skip(1).map(|rest| {
        let (what, block) = rest.split_once(" -->\n```").expect("a block of code below the comment");
        let (_language, block) = block.split_once('\n').expect("the code");
        (what, block.split("```").next().unwrap_or(block))
    })
}

/// The targets of links, `[..](target)`, outside of code.
pub fn links(text: &str) -> Vec<String> {
    let prose: String = text.split("```").step_by(2).collect();
    prose
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split(')').next())
        .filter(|target| !target.contains("://") && !target.starts_with('#'))
        .map(|target| target.split('#').next().unwrap_or(target).to_owned())
        .collect()
}

/// What a page tells a newcomer to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Commands, and the lines that they print among others; `..` in a line stands for anything.
    Run(Vec<String>, Vec<String>),
    /// The same in a second terminal, where they go on until the chapter ends.
    Beside(Vec<String>, Vec<String>),
    /// What wants a person at a terminal.
    ByHand(Vec<String>),
    /// A change of a file of the project.
    Edit(String, Edit),
}

#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// A piece of text by another.
    Text(String, String),
    /// A line by others.
    Line(String, String),
    /// A function with its attributes by others.
    Function(String, String),
    /// The whole file.
    Whole(String),
}

impl Edit {
    /// The changed file.
    pub fn apply(&self, text: &str) -> Result<String, String> {
        match self {
            Edit::Whole(new) => Ok(new.clone()),
            Edit::Text(old, new) if text.matches(old.as_str()).count() == 1 => Ok(text.replacen(old, new, 1)),
            Edit::Text(old, _) => {
                Err(format!("`{old}` is there {} times", text.matches(old.as_str()).count()))
            }
            Edit::Line(old, new) => {
                let line = text.lines().find(|line| line.trim() == old).ok_or(format!("no line `{old}`"))?;
                Ok(text.replacen(&format!("{line}\n"), new, 1))
            }
            Edit::Function(name, new) => {
                let found = text.find(&format!("fn {name}(")).ok_or(format!("no function `{name}`"))?;
                let above = text[..found].rfind("\n#[").ok_or(format!("`{name}` has no attribute"))? + 1;
                let end = found + text[found..].find("\n}\n").ok_or(format!("`{name}` has no end"))? + 3;
                Ok(format!("{}{new}{}", &text[..above], &text[end..]))
            }
        }
    }
}

/// Reads a chapter; the next block of code belongs to the edit that ends with a colon.
pub fn steps(name: &str, text: &str) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut waiting: Option<(String, Edit)> = None;
    for (i, part) in text.split("```").enumerate() {
        if i % 2 == 0 {
            for sentence in paragraphs(part) {
                for (file, edit, wants_code) in edits(&sentence) {
                    assert!(waiting.is_none(), "{name}: no code for {waiting:?}");
                    match wants_code {
                        true => waiting = Some((file, edit)),
                        false => steps.push(Step::Edit(file, edit)),
                    }
                }
            }
            continue;
        }
        let (language, body) = part.split_once('\n').unwrap_or((part, ""));
        let lines = || body.lines().map(str::to_owned).collect::<Vec<_>>();
        match (language, steps.last_mut()) {
            ("sh", _) => steps.push(Step::Run(lines(), Vec::new())),
            ("sh,beside", _) => steps.push(Step::Beside(lines(), Vec::new())),
            ("sh,by-hand", _) => steps.push(Step::ByHand(lines())),
            ("text", Some(Step::Run(_, shown) | Step::Beside(_, shown))) => shown.extend(lines()),
            ("rust" | "toml", _) => {
                if let Some((file, edit)) = waiting.take() {
                    steps.push(Step::Edit(file, with_code(edit, body.to_owned())));
                }
            }
            (other, _) => panic!("{name}: a block of `{other}` out of place"),
        }
    }
    assert!(waiting.is_none(), "{name}: no code for {waiting:?}");
    steps
}

/// Paragraphs and items of lists, each in one line.
fn paragraphs(text: &str) -> Vec<String> {
    let items = text.replace("\n- ", "\n\n");
    items.split("\n\n").map(|paragraph| paragraph.replace('\n', " ")).collect()
}

/// The edits that a paragraph asks for: file, edit, and whether its new text is the next block of code.
fn edits(paragraph: &str) -> Vec<(String, Edit, bool)> {
    let parts: Vec<_> = paragraph.split('`').map(str::to_owned).collect();
    let part = |i: usize| parts.get(i).cloned().unwrap_or_default();
    let mut edits = Vec::new();
    for i in (1..parts.len()).step_by(2) {
        let (before, file) = (&parts[i - 1], part(i));
        let in_it = before.ends_with("In ") || before.ends_with("in ");
        let (first, second, empty) = (part(i + 2), part(i + 4), String::new());
        edits.push(match part(i + 1).as_str() {
            ", change " if in_it => (file, Edit::Text(first, second), false),
            ", delete the line " if in_it => (file, Edit::Line(first, empty), false),
            ", replace the line " if in_it => (file, Edit::Line(first, empty), true),
            ", replace the function " if in_it => (file, Edit::Function(first, empty), true),
            " by:" if before.ends_with("Replace ") => (file, Edit::Whole(empty), true),
            _ => continue,
        });
    }
    edits
}

fn with_code(edit: Edit, code: String) -> Edit {
    match edit {
        Edit::Line(old, _) => Edit::Line(old, code),
        Edit::Function(name, _) => Edit::Function(name, code),
        Edit::Whole(_) => Edit::Whole(code),
        Edit::Text(..) => edit,
    }
}
