//! What the README shows of the code is that of its files, and all that differs.

use std::path::{Path, PathBuf};

/// The programs that refinement changes.
const PROGRAMS: [&str; 3] = ["coordinate", "arm", "hand"];

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(folder().join(&path))
        .unwrap_or_else(|error| panic!("{}: {error}", path.as_ref().display()))
}

/// The programs of a file, without what stands around them.
fn programs(source: &str) -> Vec<(&'static str, String)> {
    let function = |name: &&'static str| {
        let from = source.find(&format!("fn {name}(")).or_else(|| source.find(&format!("fn {name}<")))?;
        let length = source[from..].find("\n}\n")? + 3;
        Some((*name, source[from..from + length].to_owned()))
    };
    PROGRAMS.iter().filter_map(function).collect()
}

/// What is shown: two files, and the lines before and after.
fn shown(readme: &str) -> Vec<(String, String, String, String)> {
    let block = |rest: &str| {
        let (files, rest) = rest.split_once(" -->\n```diff\n").expect("a block below the comment");
        let (old, new) = files.split_once(' ').expect("two files");
        let lines = || rest.split("```").next().unwrap_or_default().lines();
        let side = |other: char| {
            let kept = lines().filter(|line| !line.starts_with(other)).map(|line| &line[1..]);
            kept.map(|line| format!("{line}\n")).collect::<String>()
        };
        (old.to_owned(), new.to_owned(), side('+'), side('-'))
    };
    readme.split("<!-- diff: ").skip(1).map(block).collect()
}

#[test]
fn what_refinement_changes_is_what_the_readme_shows_and_nothing_else() {
    let blocks = shown(&read("README.md"));
    assert_eq!(blocks.len(), 3);
    for (old, new, before, after) in &blocks {
        let (old_text, new_text) = (read(old), read(new));
        assert_eq!(old_text.matches(before.as_str()).count(), 1, "{old} has not once\n{before}");
        assert_eq!(new_text.matches(after.as_str()).count(), 1, "{new} has not once\n{after}");
        // Applied, it makes the programs of one file those of the other.
        let made = programs(&old_text.replace(before, after));
        let there = programs(&new_text);
        assert!(!there.is_empty());
        for (name, program) in there {
            let made = made.iter().find(|(made, _)| *made == name).map(|(_, program)| program);
            assert_eq!(made, Some(&program), "`{name}` of {old} and of {new} differ by more than is shown");
        }
    }
}

#[test]
fn links_lead_to_files_and_so_does_the_table() {
    let readme = read("README.md");
    let links = readme.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let table = readme.lines().filter(|line| line.starts_with("| `")).flat_map(|line| {
        let names = line.split('|').nth(1).unwrap_or_default();
        names.split('`').skip(1).step_by(2).collect::<Vec<_>>()
    });
    let mut count = 0;
    for path in links.chain(table) {
        assert!(folder().join(path).exists(), "{path} is not there");
        count += 1;
    }
    assert!(count > 10, "{count}");
}
