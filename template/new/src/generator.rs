//! Copies a generator of the library into a project, under a name of its own, to be changed there.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::{fs, iter};

use tempfile::NamedTempFile;
use toml::{Table, Value};

use crate::catalogue::{CATALOGUE, Entry};
use crate::error::Error;
use crate::{name, suggestion};

/// The library's generators with their classes, to be printed.
#[must_use]
pub fn list() -> String {
    let width = CATALOGUE.iter().map(|entry| entry.name.len()).max().unwrap_or(0);
    CATALOGUE
        .iter()
        .map(|entry| {
            let name = entry.name;
            format!("{name:width$}  {}\n{:width$}  {}\n", entry.summary(), "", entry.class)
        })
        .collect()
}

/// The folder of a project's generators, and the file that declares them.
const FOLDER: &str = "src/generators";
const MODULES: &str = "src/generators/mod.rs";

/// A copy that can be made.
#[derive(Debug)]
pub struct Copy {
    entry: &'static Entry,
    name: String,
    type_name: String,
    project: PathBuf,
    manifest: Table,
    modules: String,
}

impl Copy {
    /// A copy of the library's `generator` as `name` into the project in which the folder `here` lies.
    ///
    /// # Errors
    /// [`Error::Refused`] when there is no such generator or project, when the name cannot be taken, and when the
    /// project lacks a dependency.
    pub fn new(generator: &str, name: &str, here: &Path) -> Result<Copy, Error> {
        let entry = CATALOGUE.iter().find(|entry| entry.name == generator || entry.type_name == generator);
        let entry = entry.ok_or_else(|| {
            let help = suggestion::help(generator, "there are", CATALOGUE.iter().map(|entry| entry.name));
            Error::refused(format!("there is no generator `{generator}`"), help)
        })?;
        let name = if name == entry.type_name { entry.name } else { name };
        let type_name = type_name(name)?;
        if type_name != entry.type_name && words(&entry.copied()).any(|word| word == type_name) {
            let what = format!("`{name}` would be the type `{type_name}`, which the generator itself uses");
            return Err(Error::refused(what, format!("take another name, such as `my_{name}`")));
        }
        let project = here
            .ancestors()
            .find(|folder| folder.join("Cargo.toml").is_file() && folder.join(MODULES).is_file());
        let project = project.ok_or_else(|| {
            let what = format!("no project here: {MODULES} is neither in {} nor above", here.display());
            Error::refused(what, "go into a project by `cd`, or make one by `mrroc-new my-task`")
        })?;
        let manifest = read(&project.join("Cargo.toml"))?;
        let manifest: Table = manifest.parse().map_err(|error| {
            let what = format!("{}: {error}", project.join("Cargo.toml").display());
            Error::refused(what.trim_end(), "see whether `cargo check` takes it")
        })?;
        let modules = read(&project.join(MODULES))?;
        let copy =
            Copy { entry, name: name.to_owned(), type_name, project: project.to_owned(), manifest, modules };
        copy.check_room()?;
        copy.check_dependencies()?;
        Ok(copy)
    }

    fn file(&self) -> String {
        format!("{FOLDER}/{}.rs", self.name)
    }

    fn check_room(&self) -> Result<(), Error> {
        let folder = format!("{FOLDER}/{}", self.name);
        let there = [self.file(), folder].into_iter().find(|path| self.project.join(path).exists());
        let declared = declarations(&self.modules).any(|(_, module)| module == self.name);
        let what = match there {
            Some(path) => format!("{path} is there already"),
            None if declared => format!("{MODULES} has a module `{}` already", self.name),
            None => return Ok(()),
        };
        let help = format!("take another name: `--as my_{}`; nothing is overwritten", self.name);
        Err(Error::refused(what, help))
    }

    fn check_dependencies(&self) -> Result<(), Error> {
        let copied = self.entry.copied();
        let (generator, tests) = copied.split_once("#[cfg(test)]").unwrap_or((&copied, ""));
        let always = self.dependencies(&["dependencies"]);
        let in_tests = self.dependencies(&["dev-dependencies"]);
        for name in ["mrroc", "mrroc-generators", "mrroc-robots", "nalgebra"] {
            let is_used = |text| words(text).any(|word| word == name.replace('-', "_"));
            let has = |table: &[(String, &Value)]| table.iter().any(|(found, _)| found == name);
            let section = if is_used(generator) && !has(&always) {
                "dependencies"
            } else if is_used(tests) && !has(&always) && !has(&in_tests) {
                "dev-dependencies"
            } else {
                continue;
            };
            let line = self.line_for(name, always.iter().find(|(found, _)| OURS.contains(&found.as_str())));
            let manifest = self.project.join("Cargo.toml");
            let what =
                format!("{} does not depend on {name}, which {} uses", manifest.display(), self.entry.name);
            return Err(Error::refused(what, format!("add this line below [{section}]: {line}")));
        }
        Ok(())
    }

    fn dependencies(&self, sections: &[&str]) -> Vec<(String, &Value)> {
        let tables = sections.iter().filter_map(|section| self.manifest.get(*section)?.as_table());
        tables.flatten().map(|(name, value)| (name.replace('_', "-"), value)).collect()
    }

    /// The line that makes the project depend on `name` from where its mrroc comes.
    fn line_for(&self, name: &str, like: Option<&(String, &Value)>) -> String {
        if name == "nalgebra" {
            return concat!("nalgebra = ", env!("NALGEBRA")).to_owned();
        }
        let mut value =
            like.map_or_else(|| Value::from(env!("CARGO_PKG_VERSION")), |(_, value)| (*value).clone());
        if let Some(Value::String(path)) = value.get_mut("path") {
            let folder = match name {
                "mrroc" => "runtime",
                "mrroc-generators" => "generators-lib",
                _ => "robots",
            };
            let root = path.trim_end_matches('/').rsplit_once('/').map_or(".", |(root, _)| root);
            *path = format!("{root}/{folder}");
        }
        format!("{name} = {value}")
    }

    /// Writes the copy and declares it; says how to use it.
    ///
    /// # Errors
    /// [`Error::Failed`] when it cannot be written; nothing is left behind.
    pub fn write(&self) -> Result<String, Error> {
        let path = self.project.join(self.file());
        let modules_path = self.project.join(MODULES);
        let text = self.formatted(&renamed(self.entry, &self.name, &self.type_name));
        let (modules, lines) = declared(&self.modules, &self.name, &self.type_name);
        let mut file = fs::File::create_new(&path).map_err(|error| unwritable(&path, &error))?;
        let written = file.write_all(text.as_bytes()).map_err(|error| unwritable(&path, &error));
        let replaced = written.and_then(|()| {
            replace(&modules_path, &modules).map_err(|error| unwritable(&modules_path, &error))
        });
        if let Err(error) = replaced {
            // Reported is what went wrong first.
            let _ = fs::remove_file(&path);
            return Err(error);
        }
        let re_exported = lines.len() > 1;
        let lines = lines.join(" ");
        let used = self.path(re_exported);
        let call = self.example_call();
        Ok(format!(
            "{} is a copy of the library's {}, with its test.\n{MODULES} declares it: {lines}\n\nUse it:\n  \
             use {used};\n  {call}\n{}\nTest it:\n  cargo test {}\n",
            self.file(),
            self.entry.type_name,
            self.caution(),
            self.name,
        ))
    }

    /// As rustfmt has it in the project; a longer or shorter name moves line ends.
    fn formatted(&self, text: &str) -> String {
        let edition = self.manifest.get("package").and_then(|package| package.get("edition")?.as_str());
        let formatted = || -> io::Result<Option<String>> {
            let mut rustfmt = Command::new("rustfmt")
                .args(["--edition", edition.unwrap_or("2024")])
                .current_dir(&self.project)
                .stdin(Stdio::piped())
                .stdout(Stdio::piped())
                .stderr(Stdio::null())
                .spawn()?;
            if let Some(mut stdin) = rustfmt.stdin.take() {
                stdin.write_all(text.as_bytes())?;
            }
            let output = rustfmt.wait_with_output()?;
            Ok(String::from_utf8(output.stdout).ok().filter(|_| output.status.success()))
        };
        // Without rustfmt the text stays as the library has it.
        formatted().ok().flatten().unwrap_or_else(|| text.to_owned())
    }

    /// Where a program of the project finds the type: programs lie in the crate that has the generators.
    fn path(&self, re_exported: bool) -> String {
        let module = if re_exported { String::new() } else { format!("{}::", self.name) };
        format!("crate::generators::{module}{}", self.type_name)
    }

    /// Whether the project has a program of an ECP, which moves one robot.
    fn has_ecp(&self) -> bool {
        self.project.join("src/ecp.rs").is_file()
    }

    /// What is missing for a Move of it in this project, if anything.
    fn caution(&self) -> &'static str {
        if self.entry.reads_orders() && !self.has_ecp() {
            "\nIt reads orders, in the program of an ECP, which this project has none of: make a project with `--define levels=both`, \
             or give the robot a program by `.ecp(..)` in src/lib.rs.\n"
        } else {
            ""
        }
    }

    /// A Move of it, by its first constructor.
    fn example_call(&self) -> String {
        let sensors = if self.entry.reads_sensors() { "(&mut sensor,)" } else { "()" };
        let made = constructor(self.entry.source)
            .map_or_else(|| self.type_name.clone(), |call| format!("{}::{call}", self.type_name));
        if self.entry.is_of_an_ecp() && (self.has_ecp() || self.entry.reads_orders()) {
            format!("ecp.move_robot({sensors}, {made})?;")
        } else if self.entry.is_of_an_ecp() {
            format!("mp.move_robot(&mut robot, {sensors}, {made})?;")
        } else {
            format!("mp.move_robots((&mut robot,), {sensors}, {made})?;")
        }
    }
}

fn read(path: &Path) -> Result<String, Error> {
    fs::read_to_string(path).map_err(|error| {
        Error::failed(
            format!("{}: cannot be read: {error}", path.display()),
            "see whether the file is in order",
        )
    })
}

fn unwritable(path: &Path, error: &io::Error) -> Error {
    Error::of_system(format!("{}: cannot be written", path.display()), error, "see who may write there")
}

/// Gives a file of the user's another text: the whole of it is on the disk before the old one goes.
fn replace(path: &Path, text: &str) -> io::Result<()> {
    // The file itself, if this is a link to it.
    let path = path.canonicalize()?;
    let permissions = fs::metadata(&path)?.permissions();
    let mut beside = NamedTempFile::new_in(path.parent().unwrap_or(Path::new(".")))?;
    beside.write_all(text.as_bytes())?;
    fs::set_permissions(beside.path(), permissions)?;
    beside.persist(&path).map(drop).map_err(|failed| failed.error)
}

/// The crates of mrroc that a project depends on.
const OURS: [&str; 4] = ["mrroc", "mrroc-generators", "mrroc-pictures", "mrroc-robots"];

/// The type that goes with a module's name: `MyLine` with `my_line`.
fn type_name(name: &str) -> Result<String, Error> {
    if !names_a_module(name) {
        let help = format!("write small letters, digits and `_`: `{}`", snake_case(name));
        return Err(Error::refused(format!("`{name}` cannot name a module"), help));
    }
    let capital = |part: &str| part[..1].to_uppercase() + &part[1..];
    Ok(name.split('_').map(capital).collect())
}

fn names_a_module(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
        && !name.contains("__")
        && !name.ends_with('_')
        && !name::is_keyword(name)
}

/// A module's name like `name`.
fn snake_case(name: &str) -> String {
    let mut snake = String::new();
    for c in name.chars() {
        let begins = !c.is_ascii_alphanumeric() || c.is_ascii_uppercase();
        if begins && !snake.is_empty() && !snake.ends_with('_') {
            snake.push('_');
        }
        if c.is_ascii_alphanumeric() {
            snake.push(c.to_ascii_lowercase());
        }
    }
    match snake.trim_matches('_') {
        "" => "my_motion".to_owned(),
        snake if names_a_module(snake) => snake.to_owned(),
        snake => format!("my_{snake}"),
    }
}

/// The words of a text: names, and what looks like them in comments.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c| !is_of_word(c)).filter(|word| !word.is_empty())
}

fn is_of_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The entry's source with its type, its own name, and names that begin with it, replaced.
fn renamed(entry: &Entry, name: &str, type_name: &str) -> String {
    let copied = entry.copied();
    let mut text = String::with_capacity(copied.len());
    let mut rest = copied.as_str();
    while !rest.is_empty() {
        let end = rest.find(|c| !is_of_word(c)).unwrap_or(rest.len());
        let (word, after) = rest.split_at(end);
        match word.strip_prefix(entry.name) {
            _ if word == entry.type_name => text.push_str(type_name),
            Some(more) if more.is_empty() || more.starts_with('_') => {
                text.push_str(name);
                text.push_str(more);
            }
            Some(_) | None => text.push_str(word),
        }
        let between = after.find(is_of_word).unwrap_or(after.len());
        text.push_str(&after[..between]);
        rest = &after[between..];
    }
    text
}

/// The lines `mod name;` of a file, with the number of the line.
fn declarations(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines().enumerate().filter_map(|(i, line)| {
        let line = line.strip_prefix("pub ").or_else(|| line.strip_prefix("pub(crate) ")).unwrap_or(line);
        let (module, _) = line.strip_prefix("mod ")?.split_once([';', ' '])?;
        Some((i, module))
    })
}

/// The lines `pub use module::..` of a file.
fn exports(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines().enumerate().filter_map(|(i, line)| {
        let (module, _) = line.strip_prefix("pub use ")?.trim_start_matches("self::").split_once("::")?;
        Some((i, module))
    })
}

/// A `mod.rs` that declares one more module, as it declares the others, and the lines that were added.
fn declared(text: &str, name: &str, type_name: &str) -> (String, Vec<String>) {
    let is_private = |module| {
        text.lines().any(|line| {
            line.split("//").next().is_some_and(|code| code.trim_end() == format!("mod {module};"))
        })
    };
    let lines = if exports(text).any(|(_, module)| is_private(module)) {
        vec![format!("mod {name};"), format!("pub use {name}::{type_name};")]
    } else {
        vec![format!("pub mod {name};")]
    };
    let mut new = inserted(text, &declarations(text).collect::<Vec<_>>(), name, &lines[0]);
    if let Some(export) = lines.get(1) {
        new = inserted(&new, &exports(&new).collect::<Vec<_>>(), name, export);
    }
    (new, lines)
}

/// `line` put among its like in the order of names, or at the end of the text.
fn inserted(text: &str, like: &[(usize, &str)], name: &str, line: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let at = match (like.iter().find(|(_, other)| *other > name), like.last()) {
        // Comments and attributes belong to what follows them.
        (Some(&(next, _)), _) => {
            let above = lines[..next].iter().rev();
            next - above.take_while(|line| line.starts_with("///") || line.starts_with("#[")).count()
        }
        (None, Some(&(last, _))) => last + 1,
        (None, None) => lines.len(),
    };
    let gap = like.is_empty() && lines.last().is_some_and(|last| !last.is_empty());
    let (before, after) = lines.split_at(at);
    let new =
        before.iter().copied().chain(gap.then_some("")).chain(iter::once(line)).chain(after.iter().copied());
    new.flat_map(|line| [line, "\n"]).collect()
}

/// The first constructor of a source, called with its arguments' names: `to(goal, limits)`.
fn constructor(source: &str) -> Option<String> {
    let (_, signature) = source.split_once("pub fn ")?;
    let (signature, _) = signature.split_once('{')?;
    let name = signature.split(['(', '<']).next()?;
    let (_, arguments) = signature.split_once('(')?;
    let mut depth = 0;
    let mut names = Vec::new();
    let mut argument = String::new();
    let mut rest = arguments.char_indices();
    let end = loop {
        let (i, c) = rest.next()?;
        match c {
            '(' | '<' | '[' => depth += 1,
            ')' if depth == 0 => break i,
            ')' | '>' | ']' if !argument.ends_with('-') => depth -= 1,
            ',' if depth == 0 => names.push(std::mem::take(&mut argument)),
            _ => {}
        }
        argument.push(c);
    };
    names.push(argument);
    let names =
        names.iter().filter_map(|argument| Some(argument.trim_matches([',', ' ', '\n']).split_once(':')?.0));
    let fails = if arguments[end..].contains("Result<") { "?" } else { "" };
    Some(format!("{name}({}){fails}", names.collect::<Vec<_>>().join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_types() {
        assert_eq!(type_name("my_line2").as_deref(), Ok("MyLine2"));
        for (name, instead) in [
            ("MyLine", "my_line"),
            ("my-line", "my_line"),
            ("_x", "x"),
            ("x__y", "x_y"),
            ("7", "my_7"),
            ("move", "my_move"),
            ("", "my_motion"),
        ] {
            let error = type_name(name).expect_err(name).to_string();
            assert!(error.ends_with(&format!("`{instead}`")), "{error}");
            assert!(type_name(instead).is_ok());
        }
    }

    fn entry(name: &str) -> &'static Entry {
        CATALOGUE.iter().find(|entry| entry.name == name).expect("in the catalogue")
    }

    #[test]
    fn whole_words_alone_are_renamed() {
        let entry = Entry {
            source: "//! A StraightLine.\nfn straight_line() { a_straight_line(StraightLines, straight_line_to) }",
            ..*entry("straight_line")
        };
        assert_eq!(
            renamed(&entry, "mine", "Mine"),
            "//! A Mine.\nfn mine() { a_straight_line(StraightLines, mine_to) }"
        );
    }

    #[test]
    fn a_module_is_declared_as_the_others_are() {
        let declared = |text, name| declared(text, name, "T").0;
        assert_eq!(declared("//! Doc.\n", "m"), "//! Doc.\n\npub mod m;\n");
        assert_eq!(declared("", "m"), "pub mod m;\n");
        assert_eq!(declared("pub mod a;\npub mod z;\n", "m"), "pub mod a;\npub mod m;\npub mod z;\n");
        assert_eq!(
            declared("mod a;\n\npub use a::A;\n", "m"),
            "mod a;\nmod m;\n\npub use a::A;\npub use m::T;\n"
        );
        assert_eq!(
            declared("pub mod a;\n/// Last.\n#[rustfmt::skip]\npub mod z;\n\nfn f() {}\n", "m"),
            "pub mod a;\npub mod m;\n/// Last.\n#[rustfmt::skip]\npub mod z;\n\nfn f() {}\n"
        );
    }

    #[test]
    fn the_first_constructor_is_shown() {
        let call = |name: &str| constructor(entry(name).source).expect("a constructor");
        assert_eq!(call("guarded_approach"), "along(direction, speed, acceleration, travel, contact)");
        assert_eq!(call("joint_move"), "to(goal, velocity, acceleration)");
        assert_eq!(call("spline_track"), "through(points, spline, feed, X_WP, R_PE)?");
        assert_eq!(call("straight_line"), "to(X_WE, limits)");
        assert!(CATALOGUE.iter().all(|entry| constructor(entry.source).is_some()));
    }
}
