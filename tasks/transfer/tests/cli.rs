//! The command that users run.

use std::path::PathBuf;
use std::process::{Command, Output};

fn transfer(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_transfer")).args(arguments).output().expect("it starts")
}

#[test]
fn a_run_keeps_its_bounds_and_draws_two_pictures() {
    let out = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("transfer");
    let output = transfer(&["--out", out.to_str().expect("plain")]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let printed = String::from_utf8_lossy(&output.stdout);
    for row in ["arms alone", "a bar", "a base off", ".. with force sensors", "lines of code"] {
        assert!(printed.lines().any(|line| line.starts_with(row)), "{printed}");
    }
    let read = |file: &str| std::fs::read_to_string(out.join(file)).expect("drawn");
    let (arms, stress) = (read("arms.svg"), read("stress.svg"));
    // The bar moves and the table does not: three views of six faces, twice at rest and once moving; and once.
    let document = roxmltree::Document::parse(&arms).expect("an SVG");
    let blocks = document.descendants().filter(|node| node.attribute("class") == Some("block"));
    assert_eq!(blocks.count(), 3 * (3 + 1));
    let document = roxmltree::Document::parse(&stress).expect("an SVG");
    let lines = document.descendants().filter(|node| node.attribute("class") == Some("measured"));
    assert_eq!(lines.count(), 5 * 3);
}

#[test]
fn what_cannot_be_followed_is_refused() {
    for arguments in [&["--sensor"][..], &["--cell", "nowhere.toml"]] {
        let output = transfer(arguments);
        assert_eq!(output.status.code(), Some(2));
        assert!(output.stdout.is_empty() && String::from_utf8_lossy(&output.stderr).starts_with("error: "));
    }
    assert!(String::from_utf8_lossy(&transfer(&["--help"]).stdout).contains("--no-sensor"));
}
