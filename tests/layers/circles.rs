//! No files of a crate import each other in a circle.
//!
//! Looked at are the paths of a file that begin with `crate`, `super` or `self`. A name that a file passes on from another one
//! (`pub use`) counts as a name of the file that has it, so a folder's `mod.rs` may pass on what its files have.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use super::{root, texts};

/// A module of a crate by its path: none of the crate itself.
type Module = Vec<String>;

/// A path as it stands in a file, and the name that it has there; `*` for all names.
type Import = (Vec<String>, String);

/// What a file has that is no test.
struct File {
    code: String,
    /// The names that it takes from elsewhere.
    names: Vec<Import>,
}

/// The files of a crate by their modules, without its tests.
struct Crate(BTreeMap<Module, File>);

impl Crate {
    /// Of files by their paths below the sources of the crate.
    fn of(texts: Vec<(String, String)>) -> Crate {
        let (mut files, mut tests) = (BTreeMap::new(), Vec::new());
        let has_lib = texts.iter().any(|(path, _)| path == "lib.rs");
        for (path, text) in texts.iter().filter(|(path, _)| !(has_lib && path == "main.rs")) {
            let module = module(path);
            let (code, of_tests) = code(text);
            tests.extend(of_tests.into_iter().map(|test| [module.clone(), vec![test]].concat()));
            files.insert(module, File { names: names(&code), code });
        }
        let is_test =
            |module: &Module| tests.iter().any(|test| module.starts_with(test)) || is_of_tests(module);
        files.retain(|module, _| !is_test(module));
        Crate(files)
    }

    /// The module of the file in which a path ends that stands in the file of a module.
    fn resolve(&self, from: &[String], path: &[String], steps: usize) -> Module {
        let (mut at, mut rest) = (from.to_vec(), path);
        while let [first, others @ ..] = rest {
            match &**first {
                "crate" => at.clear(),
                "super" => drop(at.pop()),
                "self" => {}
                _ => break,
            }
            rest = others;
        }
        while let [first, others @ ..] = rest {
            let below = [&at[..], core::slice::from_ref(first)].concat();
            if !self.0.contains_key(&below) {
                break;
            }
            (at, rest) = (below, others);
        }
        while !at.is_empty() && !self.0.contains_key(&at) {
            at.pop();
        }
        let (Some(name), Some(file)) = (rest.first(), self.0.get(&at)) else { return at };
        if steps == 0 {
            return at;
        }
        let is_own = |path: &[String]| {
            let below = [&at[..], &path[..1]].concat();
            ["crate", "super", "self"].contains(&&*path[0]) || self.0.contains_key(&below)
        };
        let from_elsewhere = file.names.iter().filter(|(path, _)| is_own(path));
        for (path, known) in from_elsewhere {
            if known == name {
                return self.resolve(&at, path, steps - 1);
            }
            if known == "*" {
                let other = self.resolve(&at, &path[..path.len() - 1], steps - 1);
                if other != at && self.0.get(&other).is_some_and(|other| defines(&other.code, name)) {
                    return other;
                }
            }
        }
        at
    }

    /// Which files each file imports from.
    fn edges(&self) -> BTreeMap<Module, BTreeSet<Module>> {
        let edges = |(module, file): (&Module, &File)| {
            let paths = paths(&file.code);
            let others = paths.iter().map(|(path, _)| self.resolve(module, path, 10));
            (module.clone(), others.filter(|other| other != module).collect())
        };
        self.0.iter().map(edges).collect()
    }
}

/// The module of a file.
fn module(path: &str) -> Module {
    let mut parts: Module = path.strip_suffix(".rs").unwrap_or(path).split('/').map(str::to_owned).collect();
    parts.pop_if(|last| last == "mod");
    if parts == ["lib"] || parts == ["main"] { Vec::new() } else { parts }
}

fn is_of_tests(module: &[String]) -> bool {
    module.iter().any(|part| part == "tests")
}

/// What a file has without comments and tests, and the names of the modules that are tests.
fn code(text: &str) -> (String, Vec<String>) {
    let (mut code, mut tests) = (String::new(), Vec::new());
    // The indentation of the item that is a test.
    let mut test = None;
    for line in text.lines() {
        let is_comment = line.trim_start().starts_with("//");
        let line = if is_comment { "" } else { line.split(" //").next().unwrap_or_default() };
        let words = line.trim();
        let indentation = line.len() - line.trim_start().len();
        if ["#[cfg(test)]", "#[cfg(all(test,"].iter().any(|begins| words.starts_with(begins)) {
            test = Some(indentation);
        } else if let Some(of_test) = test {
            let name = words.rsplit_once("mod ").and_then(|(_, name)| name.strip_suffix(';'));
            tests.extend(name.map(str::to_owned));
            let ends = words.starts_with('}') || words.ends_with(';') || words.ends_with('}');
            if indentation == of_test && ends {
                test = None;
            }
        } else {
            code.push_str(line);
            code.push('\n');
        }
    }
    (code, tests)
}

/// The names that a code takes from elsewhere.
fn names(code: &str) -> Vec<Import> {
    let is_item = |(at, _): &(usize, &str)| {
        let before = code[..*at].rsplit('\n').next().unwrap_or_default().trim_start();
        before.is_empty() || before == "pub " || before.starts_with("pub(") && before.ends_with(") ")
    };
    let uses = code.match_indices("use ").filter(is_item);
    uses.flat_map(|(at, found)| imports(&code[at + found.len()..])).collect()
}

/// All paths of a code that begin in its own crate.
fn paths(code: &str) -> Vec<Import> {
    let mut found = Vec::new();
    for begins in ["crate::", "super::", "self::"] {
        for (at, _) in code.match_indices(begins) {
            let before = &code[..at];
            // Not behind another part of a path, in a macro, or in `pub(in crate::a)`.
            let is_part = before.ends_with(|c: char| c.is_alphanumeric() || "_:$".contains(c))
                || before.ends_with("(in ");
            if !is_part {
                found.extend(imports(&code[at..]));
            }
        }
    }
    found
}

/// The paths of a tree such as `crate::a::{b, c::D as E}`.
fn imports(text: &str) -> Vec<Import> {
    let mut found = Vec::new();
    tree(text, Vec::new(), &mut found);
    found
}

/// Finds the paths of a tree behind this beginning of a path; returns what follows the tree.
fn tree<'a>(mut text: &'a str, mut path: Vec<String>, found: &mut Vec<Import>) -> &'a str {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let name = |text: &'a str| text.split_at(text.find(|c| !is_name(c)).unwrap_or(text.len()));
    loop {
        if let Some(mut inner) = text.strip_prefix('{') {
            loop {
                inner = inner.trim_start_matches(|c: char| c.is_whitespace() || c == ',');
                let rest = tree(inner, path.clone(), found);
                if rest.len() == inner.len() {
                    return rest.strip_prefix('}').unwrap_or(rest);
                }
                inner = rest;
            }
        }
        if let Some(rest) = text.strip_prefix('*') {
            path.push("*".to_owned());
            found.push((path, "*".to_owned()));
            return rest;
        }
        let (part, mut rest) = name(text);
        if part.is_empty() {
            return text;
        }
        path.push(part.to_owned());
        let goes_on = |next: &&str| next.starts_with(|c| is_name(c) || c == '{' || c == '*');
        if let Some(next) = rest.strip_prefix("::").filter(goes_on) {
            text = next;
            continue;
        }
        // `a::{self}` is the name of `a`.
        if path.len() > 1 && part == "self" {
            path.pop();
        }
        let mut known = path.last().map(String::as_str).unwrap_or_default();
        if let Some(other) = rest.strip_prefix(" as ") {
            (known, rest) = name(other);
        }
        let known = known.to_owned();
        found.push((path, known));
        return rest;
    }
}

/// Whether a code has an item of this name.
fn defines(code: &str, name: &str) -> bool {
    let kinds = ["fn", "struct", "enum", "trait", "type", "const", "static", "union", "macro_rules!"];
    code.match_indices(name).any(|(at, _)| {
        let is_whole = !code[at + name.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_');
        is_whole && kinds.iter().any(|kind| code[..at].ends_with(&format!("{kind} ")))
    })
}

/// Those that are reached from themselves.
pub(super) fn in_circles<T: Clone + Ord>(edges: &BTreeMap<T, BTreeSet<T>>) -> BTreeSet<T> {
    let is_in_one = |one: &&T| {
        let (mut reached, mut next) = (BTreeSet::new(), vec![*one]);
        while let Some(others) = next.pop().map(|at| edges.get(at)) {
            next.extend(others.into_iter().flatten().filter(|other| reached.insert(*other)));
        }
        reached.contains(one)
    };
    edges.keys().filter(is_in_one).cloned().collect()
}

#[test]
fn no_files_of_a_crate_import_each_other_in_a_circle() {
    let manifest = fs::read_to_string(root().join("Cargo.toml")).expect("the workspace's manifest");
    let manifest: toml::Table = manifest.parse().expect("a manifest");
    let members = manifest["workspace"]["members"].as_array().expect("a list");
    let mut wrong = Vec::new();
    for member in members.iter().map(|member| member.as_str().expect("a path")) {
        let folder = format!("{member}/src");
        if !root().join(&folder).is_dir() {
            continue;
        }
        let edges = Crate::of(texts(&folder)).edges();
        let circles = in_circles(&edges);
        wrong.extend(circles.iter().map(|module| {
            let others: Vec<_> = edges[module].intersection(&circles).map(|other| other.join("::")).collect();
            format!("{member}: {}: imports {}", module.join("::"), others.join(", "))
        }));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_circle_is_found_through_names_that_are_passed_on_and_tests_make_none() {
    let of = |files: &[(&str, &str)]| {
        let texts = files.iter().map(|(path, text)| ((*path).to_owned(), (*text).to_owned()));
        let circles = in_circles(&Crate::of(texts.collect()).edges());
        circles.iter().map(|module| module.join("::")).collect::<Vec<_>>()
    };
    let lib = ("lib.rs", "mod a;\nmod b;\npub use b::c::C;\n");
    let folder = ("b/mod.rs", "mod c;\nmod d;\npub(crate) use c::{C, E as F};\npub use d::*;\n");
    let (c, d) = ("pub struct C;\npub struct E;\n", "pub fn d() {}\n");
    // A folder passes on what its files have, and these may use each other.
    let a = ("a.rs", "use crate::b::{C,\n    F};\n// crate::b::d\nfn a() { crate::b::d() }\n");
    assert!(of(&[lib, folder, a, ("b/c.rs", c), ("b/d.rs", &format!("{d}use super::C;\n"))]).is_empty());
    // What a name stands for counts, and not who passes it on.
    for back in ["use crate::a;", "fn e() { super::super::a::a() }", "use super::{super::a::a as e};"] {
        assert_eq!(
            of(&[lib, folder, a, ("b/c.rs", &format!("{c}{back}\n")), ("b/d.rs", d)]),
            ["a", "b::c"],
            "{back}"
        );
        assert_eq!(
            of(&[lib, folder, a, ("b/c.rs", c), ("b/d.rs", &format!("{d}{back}\n"))]),
            ["a", "b::d"],
            "{back}"
        );
    }
    let through_root = ("b/d.rs", "pub fn d() {}\nuse crate::C;\n");
    let c_of_d = ("b/c.rs", "pub struct C;\npub struct E;\nuse super::d::d;\n");
    assert_eq!(of(&[lib, folder, a, c_of_d, through_root]), ["b::c", "b::d"]);
    // Tests may import everything.
    let tests = "#[cfg(test)]\nmod tests {\n    use crate::a;\n}\n";
    assert!(of(&[lib, folder, a, ("b/c.rs", &format!("{c}{tests}")), ("b/d.rs", d)]).is_empty());
    let tested = ("b/c.rs", "pub struct C;\npub struct E;\n#[cfg(test)]\n#[allow(unused)]\nmod checked;\n");
    assert!(of(&[lib, folder, a, tested, ("b/c/checked.rs", "use crate::a;\n"), ("b/d.rs", d)]).is_empty());
}
