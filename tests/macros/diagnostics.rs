//! Programs with one mistake each: the compiler reports one error, at the mistake, that gives the form to write.
//!
//! Every file of `fail/` is a program. Its head says what the mistake is and, where a text can be demanded,
//! what the error must say (``says: `(Rnt,)` ``); a program with more errors than one says why (`errors: 2, ..`).
//! They are modules of one crate, which is compiled with the `mrroc` that this executable was linked with, once for all of them, and again for
//! those whose errors are hidden by errors of an earlier stage of the compiler. The snapshots contain the place, the code, and the texts of the macros and
//! the runtime. They leave out the compiler's own texts and layout, so that they hold for later versions of it.
#![allow(missing_docs)]

use std::collections::{BTreeMap, HashSet};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

#[test]
fn every_mistake_is_one_error_that_gives_the_form_to_write() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("macros");
    let cases: BTreeMap<String, String> = fs::read_dir(here.join("fail"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "rs"))
        .map(|path| {
            (path.file_stem().unwrap().to_str().unwrap().to_owned(), fs::read_to_string(&path).unwrap())
        })
        .collect();
    let errors = check(&here, &cases);

    let mut failures = String::new();
    for (name, source) in &cases {
        let errors = errors.get(name).map(Vec::as_slice).unwrap_or_default();
        let text: String = errors.iter().map(|error| error.said.as_str()).collect();
        let ours: String = errors.iter().map(|error| error.ours.as_str()).collect();
        let expected = head(source, "errors: ").next().map_or(1, |line| {
            let (number, reason) = line.split_once(", ").expect("a number of errors and its reason");
            assert!(!reason.is_empty());
            number.parse().unwrap()
        });
        if errors.len() != expected {
            writeln!(failures, "{name}: {} errors instead of {expected}\n{text}", errors.len()).unwrap();
        }
        for says in
            head(source, "says: ").map(|form| form.trim_matches('`')).filter(|form| !text.contains(form))
        {
            writeln!(failures, "{name}: no error says `{says}`\n{text}").unwrap();
        }
        let mistake = source.lines().next().unwrap().trim_start_matches("//! ");
        insta::with_settings!({ snapshot_path => "snapshots", prepend_module_to_snapshot => false, omit_expression => true, description => mistake }, {
            insta::assert_snapshot!(name.as_str(), ours);
        });
    }
    assert!(failures.is_empty(), "\n{failures}");
}

/// The lines of a program's head that start with `key`.
fn head<'a>(source: &'a str, key: &'a str) -> impl Iterator<Item = &'a str> {
    source.lines().map_while(|line| line.strip_prefix("//! ")).filter_map(move |line| line.strip_prefix(key))
}

/// Compiles all programs; returns the errors of each.
fn check(here: &Path, cases: &BTreeMap<String, String>) -> BTreeMap<String, Vec<Mistake>> {
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR")).join("diagnostics");
    let _ = fs::remove_dir_all(&scratch);
    fs::create_dir_all(&scratch).unwrap();
    let built = std::env::current_exe().unwrap().parent().expect("the folder of the executable").to_owned();
    let mrroc = newest(&built, "libmrroc-", ".rlib");

    let library = format!(
        "#[path = {:?}]\nmod cell;\n#[path = {:?}]\nmod program;\npub use cell::*;\npub use program::*;\n",
        here.join("cell.rs"),
        here.join("program.rs")
    );
    fs::write(scratch.join("mistakes.rs"), library).unwrap();
    let compiled = rustc(&scratch, &built, &mrroc, "mistakes", "lib").output().unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));

    let mut errors = BTreeMap::<String, Vec<Mistake>>::new();
    let mut left: Vec<&String> = cases.keys().collect();
    // A program that is compiled again has had no error yet, so none is counted twice.
    while !left.is_empty() {
        let modules: String = left
            .iter()
            .map(|name| format!("#[path = {:?}]\nmod {name};\n", here.join(format!("fail/{name}.rs"))))
            .collect();
        fs::write(scratch.join("all.rs"), format!("{modules}\nfn main() {{}}\n")).unwrap();
        let mut programs = rustc(&scratch, &built, &mrroc, "all", "bin");
        let found = errors_of(programs.arg("--extern").arg("mistakes=libmistakes.rmeta"));
        let before = left.len();
        left.retain(|name| !found.contains_key(*name));
        errors.extend(found);
        if left.len() == before {
            break;
        }
    }
    errors
}

/// The compiler, for a crate of a name that lies in `scratch`, with what cargo has compiled into the folder `built`.
fn rustc(scratch: &Path, built: &Path, mrroc: &Path, name: &str, kind: &str) -> Command {
    let mut command = Command::new(Path::new(env!("CARGO")).with_file_name("rustc"));
    command.current_dir(scratch).arg(format!("{name}.rs"));
    command.args(["--crate-name", name, "--crate-type", kind, "--edition", "2024", "--emit", "metadata"]);
    command.args(["--error-format", "json", "--out-dir", ".", "-L"]);
    command.arg(format!("dependency={}", built.display()));
    command.arg("--extern").arg(format!("mrroc={}", mrroc.display()));
    command
}

/// The file of a folder that was written last, of those whose names begin and end so: cargo leaves what it has compiled of older sources.
fn newest(folder: &Path, start: &str, end: &str) -> PathBuf {
    let is_meant = |path: &PathBuf| {
        path.file_name()
            .and_then(|name| name.to_str())
            .is_some_and(|name| name.starts_with(start) && name.ends_with(end))
    };
    fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(is_meant)
        .max_by_key(|path| path.metadata().and_then(|metadata| metadata.modified()).unwrap())
        .expect("this executable is linked with it")
}

/// The errors of the programs that a compiler finds.
fn errors_of(compiler: &mut Command) -> BTreeMap<String, Vec<Mistake>> {
    let output = compiler.output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    let messages = stderr.lines().map(|line| serde_json::from_str::<Value>(line).expect(line));

    let mut errors = BTreeMap::<String, Vec<Mistake>>::new();
    // The compiler says some errors twice, word for word.
    let mut printed = HashSet::new();
    let is_new = |error: &Value| printed.insert(error["rendered"].as_str().map(str::to_owned));
    for error in messages.filter(|message| message["level"] == "error").filter(is_new) {
        // What the compiler says of the whole crate has no place.
        if let Some(file) =
            error["spans"].as_array().unwrap().iter().find_map(|span| span["file_name"].as_str())
        {
            let name = Path::new(file).file_stem().unwrap().to_str().unwrap();
            errors.entry(name.to_owned()).or_default().push(Mistake::of(&error, name));
        }
    }
    errors
}

/// One error of the compiler.
struct Mistake {
    /// Place, code and all that it says.
    said: String,
    /// The part of it that is not the compiler's to word: the place, and what the macros and the runtime say.
    ours: String,
}

impl Mistake {
    /// An error in the program of a name. Where types stand the compiler says by chance: their names count alone.
    fn of(error: &Value, program: &str) -> Mistake {
        let module = format!("{program}::");
        let text =
            |value: &Value| value.as_str().unwrap_or_default().replace(&module, "").replace("mistakes::", "");
        let code = text(&error["code"]["code"]);
        // Errors without a code come from the macros; unsatisfied bounds have texts of ours.
        let is_ours = code.is_empty() || code == "E0277";
        let mut lines = Vec::new();
        let head = if code.is_empty() { "error".to_owned() } else { format!("error[{code}]") };
        lines.push((true, if is_ours { format!("{head}: {}", text(&error["message"])) } else { head }));
        lines.push((false, text(&error["message"])));
        for span in error["spans"].as_array().unwrap().iter().filter(|span| span["is_primary"] == true) {
            lines.push((true, place(span)));
            lines.push((is_ours, format!("  label: {}", text(&span["label"]))));
        }
        for child in error["children"].as_array().unwrap() {
            let (level, message) = (text(&child["level"]), text(&child["message"]));
            let spans = child["spans"].as_array().unwrap();
            let is_note = is_ours && level == "note" && spans.is_empty() && !is_of_compiler(&message);
            lines.push((is_note, format!("  {level}: {message}")));
            for replacement in spans.iter().filter_map(|span| span["suggested_replacement"].as_str()) {
                lines.push((false, format!("  {level}: {message}: `{replacement}`")));
            }
        }
        lines.retain(|(_, line)| !line.trim().is_empty() && line != "  label: ");
        let of = |all: bool| -> String {
            lines.iter().filter(|(ours, _)| all || *ours).map(|(_, line)| format!("{line}\n")).collect()
        };
        Mistake { said: of(true), ours: of(false) }
    }
}

/// Notes of the compiler's own beside ours.
fn is_of_compiler(note: &str) -> bool {
    ["required", "the full name", "consider", "this error originates"]
        .iter()
        .any(|start| note.starts_with(start))
}

/// Line, column and the marked text, up to the end of the line.
fn place(span: &Value) -> String {
    let number = |key: &str| usize::try_from(span[key].as_u64().unwrap()).unwrap();
    let (line, start) = (number("line_start"), number("column_start"));
    let end = if number("line_end") == line { number("column_end") } else { usize::MAX };
    let text = span["text"][0]["text"].as_str().unwrap_or_default();
    let marked: String = text.chars().take(end - 1).skip(start - 1).collect();
    format!("{line}:{start} `{marked}`")
}
