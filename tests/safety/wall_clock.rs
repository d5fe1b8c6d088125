//! Fault 13: jumps of the wall clock do not affect control.

use std::fs;
use std::path::{Path, PathBuf};

/// Files that may read the machine's clock: the waits of a launcher, a console, or a thread that records or shows what a
/// process did are no part of control.
const MAY: [&str; 5] = [
    "runtime/core/src/observe/ring.rs",
    "runtime/processes/",
    "runtime/launch/src/panel.rs",
    "runtime/launch/src/long_run.rs",
    "runtime/recording/",
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn fault_13_only_the_named_files_may_read_the_wall_clock() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let mut files = Vec::new();
    for part in ["runtime", "robots/src", "generators-lib/src"] {
        sources(&root.join(part), &mut files);
    }
    assert!(files.len() > 100, "{} files are not all", files.len());
    for file in files {
        let name = file.strip_prefix(root).expect("below it").to_string_lossy().replace('\\', "/");
        let text = fs::read_to_string(&file).expect("a text");
        let reads = ["Instant::now", "SystemTime", "thread::sleep"].iter().any(|clock| text.contains(clock));
        assert!(!reads || MAY.iter().any(|may| name.starts_with(may)), "{name} reads the wall clock");
    }
}
