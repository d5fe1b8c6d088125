//! Cargo in projects outside of the workspace, which tests make: without the network, with this workspace's profiles and
//! target folder. What it has compiled already is not compiled again, and what they share is compiled once.

use std::fs;
use std::path::Path;
use std::process::Command;

/// `cargo SUBCOMMAND` in a project that depends on the crates of the workspace at `root`.
pub fn cargo(root: &Path, project: &Path, subcommand: &str) -> Command {
    let workspace = fs::read_to_string(root.join("Cargo.toml")).expect("the workspace's manifest");
    let configuration = project.join("profiles.toml");
    fs::write(&configuration, profiles(&workspace)).expect("the project can be written");
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("the target folder");
    let mut command = Command::new(env!("CARGO"));
    command.arg(subcommand);
    // The formatter takes no configuration of cargo's.
    if subcommand != "fmt" {
        command.arg("--config").arg(configuration);
    }
    command.current_dir(project).env("CARGO_TARGET_DIR", target);
    command.env("CARGO_NET_OFFLINE", "true").env("CARGO_TERM_COLOR", "never");
    // CI sets it for the times of tests; here it would compile everything again.
    command.env_remove("RUSTC_BOOTSTRAP");
    command
}

/// The profiles of a manifest. Those that a project has of its own are replaced by them, and the workspace's crates are
/// dependencies there, which are not optimised: that is compiled soonest, and what the projects simulate is short.
fn profiles(manifest: &str) -> String {
    let sections = manifest.split("\n[").filter(|section| section.starts_with("profile."));
    sections.map(|section| format!("[{section}\n")).collect()
}
