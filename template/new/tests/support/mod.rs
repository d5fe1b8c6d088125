//! What the tests of `mrroc-new` share: the program in a folder of its own, the template's combinations, and cargo in
//! a generated project.

mod outside;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use mrroc_new::choices::{Chosen, Given, settle};
use mrroc_new::source;
use mrroc_new::template::{Kind, Placeholder, Template, Value};

/// The checkout that is tested.
pub fn checkout() -> PathBuf {
    source::checkout().expect("tests run in a checkout")
}

/// A folder for one test.
pub struct Folder {
    path: PathBuf,
    /// Removes it at the end, if it is there.
    _temporary: Option<tempfile::TempDir>,
}

impl Folder {
    /// One that is removed at the end.
    pub fn new() -> Self {
        let temporary = tempfile::tempdir().expect("a temporary folder");
        Folder { path: temporary.path().to_owned(), _temporary: Some(temporary) }
    }

    /// One for projects that are built: its path is the same in every run, so that what cargo keeps of a project takes the
    /// place of what it kept of the last one.
    pub fn to_build_in(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("a folder");
        Folder { path, _temporary: None }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The program, started here.
    pub fn mrroc_new(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mrroc-new"));
        command.current_dir(self.path());
        command
    }

    /// Runs the program here with these arguments.
    pub fn run(&self, arguments: &[&str]) -> Output {
        self.mrroc_new().args(arguments).output().expect("the program starts")
    }

    pub fn write(&self, name: &str, text: &str) {
        let path = self.path().join(name);
        fs::create_dir_all(path.parent().expect("a file in the folder")).expect("a folder");
        fs::write(path, text).expect("a file");
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The files below, sorted, with `/` between folders.
    pub fn files(&self) -> Vec<String> {
        let mut files = Vec::new();
        collect(self.path(), self.path(), &mut files);
        files.sort();
        files
    }

    /// That there is nothing, not even an empty folder.
    pub fn assert_empty(&self) {
        let left: Vec<_> = fs::read_dir(self.path()).expect("the folder").collect();
        assert!(left.is_empty(), "left behind: {left:?}");
    }
}

fn collect(root: &Path, folder: &Path, files: &mut Vec<String>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect(root, &path, files);
        } else {
            let name = path.strip_prefix(root).expect("below the root");
            files.push(name.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/"));
        }
    }
}

/// What the program said, when it succeeded.
pub fn said(output: &Output) -> String {
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success(), "{out}{err}");
    assert_eq!(err, "", "it says nothing but its own words");
    out
}

/// What it said, when it refused what was asked for.
pub fn refusal(output: &Output) -> String {
    complaint(output, 2)
}

/// What it said, when it ended with this status.
pub fn complaint(output: &Output, status: i32) -> String {
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(status), "{out}{err}");
    assert_eq!(out, "");
    assert!(
        err.starts_with("error: ") && err.lines().nth(1).is_some_and(|l| l.starts_with(" help: ")),
        "{err}"
    );
    assert_eq!(err.lines().count(), 2, "{err}");
    err
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// What is given to every project that is built: mrroc is this checkout.
pub fn this_checkout(template: &Template) -> Given {
    let mut given = Given::new();
    source::complete(template, &mut given, Some(&checkout())).expect("the checkout");
    given
}

/// All combinations of the choices that the template offers beside what is given, the defaults first for texts.
pub fn combinations(template: &Template, given: &Given) -> Vec<Chosen> {
    let (mut all, mut picks) = (Vec::new(), Vec::<usize>::new());
    loop {
        let mut counts = Vec::new();
        let chosen = settle(template, given, |placeholder| {
            let (values, i) = (values(placeholder), counts.len());
            counts.push(values.len());
            if picks.len() == i {
                picks.push(0);
            }
            Ok(values[picks[i]].clone())
        });
        all.push(chosen.expect("every value of the template can be chosen"));
        while let Some(last) = picks.pop() {
            if last + 1 < counts[picks.len()] {
                picks.push(last + 1);
                break;
            }
        }
        if picks.is_empty() {
            return all;
        }
    }
}

/// The values of a choice: all there are, or of a text the default.
fn values(placeholder: &Placeholder) -> Vec<Value> {
    match &placeholder.kind {
        Kind::YesNo => vec![Value::Bool(false), Value::Bool(true)],
        Kind::OneOf(choices) => choices.iter().map(|choice| Value::Text(choice.value.clone())).collect(),
        Kind::AnyOf(choices) => (0..1_usize << choices.len())
            .map(|set| {
                let in_set = choices.iter().enumerate().filter(|(i, _)| set >> i & 1 == 1);
                Value::List(in_set.map(|(_, choice)| choice.value.clone()).collect())
            })
            .collect(),
        // Of the file of an arm there is none: then one that is here.
        Kind::Text(_) => vec![placeholder.default().unwrap_or_else(|_| {
            Value::Text(checkout().join("template/sets/ur5e/ur5e.urdf").display().to_string())
        })],
    }
}

/// A few of the combinations in which every value of every choice occurs.
pub fn covering(combinations: &[Chosen]) -> Vec<Chosen> {
    let pairs = |chosen: &Chosen| {
        chosen.iter().map(|(name, value)| format!("{name}={value}")).collect::<BTreeSet<_>>()
    };
    let mut missing: BTreeSet<String> = combinations.iter().flat_map(pairs).collect();
    let mut covering = Vec::new();
    while !missing.is_empty() {
        let gain = |chosen: &&Chosen| pairs(chosen).intersection(&missing).count();
        // The last of the best, so in reverse order the first.
        let best = combinations.iter().rev().max_by_key(gain).expect("what is missing is in one of them");
        missing = &missing - &pairs(best);
        covering.push(best.clone());
    }
    covering
}

/// What was chosen, but for where mrroc and the file of an arm come from.
pub fn label(chosen: &Chosen) -> String {
    let own = chosen.iter().filter(|(name, _)| !name.starts_with("mrroc_") && name != "urdf");
    let words: Vec<_> = own.map(|(name, value)| format!("{name}={value}")).collect();
    words.join(" ")
}

/// A project made of these choices in a folder.
pub fn generated(folder: Folder, name: &str, chosen: &Chosen) -> Folder {
    let mut command = folder.mrroc_new();
    command.args([name, "--defaults"]);
    for (choice, value) in chosen {
        command.arg("--define").arg(format!("{choice}={value}"));
    }
    said(&command.output().expect("the program starts"));
    folder
}

/// Cargo in a project.
pub struct Cargo<'a>(&'a Path);

impl<'a> Cargo<'a> {
    pub fn new(project: &'a Path) -> Self {
        Cargo(project)
    }

    /// A command of cargo's.
    fn command(&self, subcommand: &str) -> Command {
        outside::cargo(&checkout(), self.0, subcommand)
    }

    /// Runs a command that must succeed; returns what it printed.
    pub fn run(&self, subcommand: &str, arguments: &[&str]) -> String {
        let mut command = self.command(subcommand);
        command.args(arguments);
        successful(command)
    }

    /// `cargo test`, and what a tidy project passes too, as far as the toolchain has it; returns what the tests printed.
    pub fn check(&self) -> String {
        let mut tests = self.command("test");
        if has("clippy-driver") {
            // Clippy compiles the project as it checks it. `cargo clippy` would check all that the project depends on once
            // more, which takes longer than everything else here.
            tests.env("RUSTC_WORKSPACE_WRAPPER", "clippy-driver");
            tests.env("CLIPPY_ARGS", "-D__CLIPPY_HACKERY__warnings__CLIPPY_HACKERY__");
        }
        let tested = successful(tests);
        if has("cargo-fmt") {
            self.run("fmt", &["--check"]);
        }
        tested
    }
}

/// Whether the toolchain has this program.
fn has(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
}

/// What a command prints, which must succeed.
fn successful(mut command: Command) -> String {
    let output = command.output().expect("the program starts");
    let said = [text(&output.stdout), text(&output.stderr)].concat();
    assert!(output.status.success(), "{command:?}\n{said}");
    said
}
