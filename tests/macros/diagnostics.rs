//! Programs with one mistake each: the compiler reports one error, at the mistake, that gives the form to write.
//!
//! Every file of `fail/` is a program. Its head says what the mistake is and, where a text can be demanded,
//! what the error must say (``says: `(Rnt,)` ``); a program with more errors than one says why (`errors: 2, ..`).
//! One run of `cargo check` judges them all. The snapshots hold place, code, message and labels, not the
//! compiler's rendering, so that they outlive its versions.
#![allow(missing_docs)]

use std::collections::{BTreeMap, HashSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

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
        let text = errors.concat();
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
            insta::assert_snapshot!(name.as_str(), text);
        });
    }
    assert!(failures.is_empty(), "\n{failures}");
}

/// The lines of a program's head that start with `key`.
fn head<'a>(source: &'a str, key: &'a str) -> impl Iterator<Item = &'a str> {
    source.lines().map_while(|line| line.strip_prefix("//! ")).filter_map(move |line| line.strip_prefix(key))
}

/// Checks all programs as the examples of one package; returns the errors of each.
fn check(here: &Path, cases: &BTreeMap<String, String>) -> BTreeMap<String, Vec<String>> {
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR")).join("diagnostics");
    let _ = fs::remove_dir_all(&scratch);
    fs::create_dir_all(scratch.join("examples")).unwrap();
    fs::create_dir_all(scratch.join("src")).unwrap();
    let root = here.join("../..").canonicalize().unwrap();
    let manifest = format!(
        "[package]\nname = \"mistakes\"\nedition = \"2024\"\n\n[workspace]\n\n[dependencies]\n\
         mrroc = {{ path = {:?} }}\nnalgebra = \"*\"\n\n[profile.dev.package.\"*\"]\nopt-level = 2\n",
        root.join("runtime")
    );
    let library = format!(
        "#[path = {:?}]\nmod cell;\n#[path = {:?}]\nmod program;\npub use cell::*;\npub use program::*;\n",
        here.join("cell.rs"),
        here.join("program.rs")
    );
    fs::write(scratch.join("Cargo.toml"), manifest).unwrap();
    fs::write(scratch.join("src/lib.rs"), library).unwrap();
    fs::copy(root.join("Cargo.lock"), scratch.join("Cargo.lock")).unwrap();
    for (name, source) in cases {
        fs::write(scratch.join(format!("examples/{name}.rs")), source).unwrap();
    }

    // The workspace's own target directory, so that the dependencies are there already.
    let target = env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap().to_owned(), PathBuf::from);
    let output = Command::new(env!("CARGO"))
        .args(["check", "--offline", "--keep-going", "--message-format=json", "--examples"])
        .current_dir(&scratch)
        .env("CARGO_TARGET_DIR", target)
        .output()
        .unwrap();
    let stdout = String::from_utf8(output.stdout).unwrap();
    let messages: Vec<Value> = stdout.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    let ran = messages.iter().any(|message| message["target"]["kind"][0] == "example");
    assert!(ran, "cargo did not come to the programs:\n{}", String::from_utf8_lossy(&output.stderr));

    let mut errors = BTreeMap::<String, Vec<String>>::new();
    // What cargo prints: it leaves out what it has printed already, word for word.
    let mut printed = HashSet::new();
    let is_new =
        |message: &&Value| printed.insert(message["message"]["rendered"].as_str().map(str::to_owned));
    for message in messages.iter().filter(|message| message["message"]["level"] == "error").filter(is_new) {
        let text = message["message"]["message"].as_str().unwrap();
        if !text.starts_with("aborting due to") {
            let case = message["target"]["name"].as_str().unwrap();
            errors.entry(case.to_owned()).or_default().push(summary(&message["message"]));
        }
    }
    errors
}

/// Place, code, message, label and our own notes of an error.
fn summary(error: &Value) -> String {
    let mut text = String::new();
    for span in error["spans"].as_array().unwrap().iter().filter(|span| span["is_primary"] == true) {
        let marked = span["text"][0]["text"].as_str().unwrap_or_default();
        let column = |key: &str| usize::try_from(span[key].as_u64().unwrap()).unwrap() - 1;
        let one_line = span["line_start"] == span["line_end"];
        let end = if one_line { column("column_end") } else { marked.chars().count() };
        let marked: String = marked.chars().take(end).skip(column("column_start")).collect();
        let (line, column) = (&span["line_start"], &span["column_start"]);
        writeln!(text, "{line}:{column} `{marked}`").unwrap();
        if let Some(label) = span["label"].as_str() {
            writeln!(text, "  label: {label}").unwrap();
        }
    }
    let code = error["code"]["code"].as_str().map_or_else(String::new, |code| format!("[{code}]"));
    let message = error["message"].as_str().unwrap();
    let mut text = format!("error{code}: {message}\n{text}");
    for child in error["children"].as_array().unwrap() {
        let (level, message) = (child["level"].as_str().unwrap(), child["message"].as_str().unwrap());
        // Where a bound comes from and what else implements it is the compiler's to word.
        let own = child["spans"].as_array().is_none_or(Vec::is_empty)
            && !["the following", "required", "the full", "consider", "this error orig"]
                .iter()
                .any(|start| message.starts_with(start));
        for span in child["spans"].as_array().into_iter().flatten() {
            if let Some(replacement) = span["suggested_replacement"].as_str() {
                writeln!(text, "  {level}: {message}: `{replacement}`").unwrap();
            }
        }
        if own {
            writeln!(text, "  {level}: {message}").unwrap();
        }
    }
    text
}
