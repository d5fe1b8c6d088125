//! Folders are layers and crates are optional parts: nothing imports what stands above it (decision 2).
//!
//! The imports are read from the source as text: every `crate::..` path of a file, without its comments and its tests.
//! `cargo test -p mrroc-tests --test all layers -- --nocapture` prints the lines of each layer and crate.

mod circles;
mod words;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use circles::in_circles;

/// The layers of the core, from the bottom up.
const CORE: &[&str] = &[
    "console",
    "files",
    "random",
    "suggestion",
    "model",
    "safety",
    "operator",
    "link",
    "observe",
    "control",
    "cell",
];

/// The layers of a cell's processes, from the bottom up.
const PROCESSES: &[&str] = &[
    "machine",
    "session",
    "link",
    "board",
    "control",
    "consoles",
    "launch",
    "member",
    "nodes",
    "picture_socket",
    "diagnosis",
    "part",
];

/// Which folders of the robots each one may import.
const ROBOTS: &[(&str, &[&str])] = &[
    ("dynamics", &[]),
    ("models", &["dynamics"]),
    ("sensors", &[]),
    ("simulation", &["dynamics", "models", "sensors"]),
    ("clearance", &["models"]),
    ("conformance", &["models"]),
    ("kinds", &["models", "simulation", "clearance"]),
];

/// Which crates of the workspace each one may depend on.
const CRATES: &[(&str, &[&str])] = &[
    ("macros", &[]),
    ("runtime/core", &["mrroc-macros"]),
    ("runtime/launch", &["mrroc-core"]),
    ("runtime/recording", &["mrroc-core", "mrroc-launch"]),
    ("runtime/processes", &["mrroc-core", "mrroc-launch"]),
    ("runtime/testing", &["mrroc-core"]),
    (
        "runtime",
        &["mrroc-core", "mrroc-launch", "mrroc-panel", "mrroc-processes", "mrroc-recording", "mrroc-testing"],
    ),
    ("robots", &["mrroc-core", "mrroc-launch"]),
    ("planning", &["mrroc-core", "mrroc-generators", "mrroc-robots"]),
    ("robots/drivers/kit", &[]),
    ("robots/drivers/franka", &["mrroc-core", "mrroc-driver-kit", "mrroc-launch", "mrroc-robots"]),
    ("robots/drivers/kuka", &["mrroc-core", "mrroc-driver-kit", "mrroc-launch", "mrroc-robots"]),
    ("robots/drivers/ur", &["mrroc-core", "mrroc-driver-kit", "mrroc-launch", "mrroc-robots"]),
    ("robots/drivers/ur-controller", &["mrroc-core", "mrroc-driver-kit", "mrroc-robots", "mrroc-ur"]),
    ("robots/drivers/modbus", &["mrroc-core", "mrroc-driver-kit", "mrroc-launch", "mrroc-robots"]),
    (
        "robots/drivers/robotiq",
        &["mrroc-core", "mrroc-driver-kit", "mrroc-launch", "mrroc-modbus", "mrroc-robots"],
    ),
    ("ports/external", &["mrroc-core", "mrroc-generators", "mrroc-launch"]),
    ("ports/panel", &["mrroc-core", "mrroc-launch", "mrroc-processes", "mrroc-recording"]),
    ("sensing/sensors", &["mrroc-core", "mrroc-robots"]),
    ("sensing/calibration", &["mrroc-core", "mrroc-launch", "mrroc-robots", "mrroc-sensors"]),
    ("sensing/geocom", &["mrroc-core", "mrroc-driver-kit"]),
    ("sensing/map", &["mrroc-core"]),
    (
        "ports/ros2",
        &[
            "mrroc-core",
            "mrroc-external",
            "mrroc-generators",
            "mrroc-launch",
            "mrroc-processes",
            "mrroc-recording",
        ],
    ),
    ("ports/zenoh", &["mrroc-core", "mrroc-launch"]),
    ("robots/wheels", &["mrroc-core", "mrroc-generators", "mrroc-map", "mrroc-robots"]),
    ("generators-lib", &["mrroc-core"]),
    ("pictures", &["mrroc-core"]),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// A source file below a folder, by its path there.
struct Source {
    path: String,
    text: String,
}

impl Source {
    /// The first part of its path: a folder, or a file of the root.
    fn layer(&self) -> &str {
        let first = self.path.split('/').next().unwrap_or_default();
        first.strip_suffix(".rs").unwrap_or(first)
    }

    /// Layer and module, such as `control::edp`.
    fn module(&self) -> String {
        let parts: Vec<_> =
            self.path.split('/').take(2).map(|part| part.strip_suffix(".rs").unwrap_or(part)).collect();
        if parts.last() == Some(&"mod") { parts[0].to_owned() } else { parts.join("::") }
    }

    /// What it imports from its own crate, without comments and tests: paths such as `control::edp`.
    fn imports(&self) -> BTreeSet<String> {
        let code: String = self
            .text
            .lines()
            .map(|line| line.split("//").next().unwrap_or_default())
            .collect::<Vec<_>>()
            .join("\n");
        let code = code.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default().replace("$crate::", "");
        let mut found = BTreeSet::new();
        for path in code.split("crate::").skip(1) {
            let end =
                path.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(path.len());
            let parts: Vec<_> = path[..end].split("::").filter(|part| !part.is_empty()).take(2).collect();
            let is_module = |part: &&&str| part.starts_with(|c: char| c.is_lowercase());
            found.insert(parts.iter().take_while(is_module).copied().collect::<Vec<_>>().join("::"));
        }
        found.remove("");
        found
    }
}

/// All `.rs` files of a folder: their paths there, and what they have.
fn texts(folder: &str) -> Vec<(String, String)> {
    let top = root().join(folder);
    let mut found = Vec::new();
    let mut folders = vec![top.clone()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).expect("a folder").map(|entry| entry.expect("an entry").path()) {
            if entry.is_dir() {
                folders.push(entry);
                continue;
            }
            let path = entry.strip_prefix(&top).expect("below it").to_string_lossy().replace('\\', "/");
            if path.ends_with(".rs") {
                found.push((path, fs::read_to_string(&entry).expect("a text")));
            }
        }
    }
    found.sort();
    assert!(!found.is_empty(), "{folder} has no sources");
    found
}

/// The files of a folder that are no tests.
fn sources(folder: &str) -> Vec<Source> {
    let is_test = |path: &str| path.contains("tests/") || path.ends_with("tests.rs");
    let texts = texts(folder).into_iter().filter(|(path, _)| !is_test(path));
    texts.map(|(path, text)| Source { path, text }).collect()
}

/// Looks for imports from a layer above among the files of a folder but for those `outside` of all layers, and prints the lines of each
/// layer.
fn no_layer_imports_one_above_it(folder: &str, layers: &[&str], outside: &[&str]) {
    let place = |layer: &str| layers.iter().position(|known| *known == layer);
    let mut lines = BTreeMap::<&str, usize>::new();
    let mut seen = BTreeSet::new();
    let mut wrong = Vec::new();
    let sources = sources(folder);
    for source in &sources {
        *lines.entry(source.layer()).or_default() += source.text.lines().count();
        if outside.contains(&source.layer()) {
            continue;
        }
        let Some(own) = place(source.layer()) else { panic!("{} is in no layer", source.path) };
        seen.insert(own);
        for import in source.imports() {
            let layer = import.split("::").next().unwrap_or_default();
            match place(layer) {
                Some(other) if other > own => {
                    wrong.push(format!("{}: imports {import}, which stands above it", source.path))
                }
                Some(_) => {}
                None => {
                    wrong.push(format!("{}: imports `crate::{import}`; name it by its layer", source.path))
                }
            }
        }
    }
    for layer in layers {
        println!("{layer:14} {:6} lines", lines.get(layer).copied().unwrap_or_default());
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_eq!(seen.len(), layers.len(), "a layer without files");
}

#[test]
fn no_layer_of_the_core_imports_one_above_it() {
    // The root names everything, and so does what the macros' expansions name.
    no_layer_imports_one_above_it("runtime/core/src", CORE, &["lib", "private"]);
}

#[test]
fn no_layer_of_a_cells_processes_imports_one_above_it() {
    no_layer_imports_one_above_it("runtime/processes/src", PROCESSES, &["lib"]);
}

#[test]
fn no_modules_of_the_core_import_each_other_in_a_circle() {
    let mut edges = BTreeMap::<String, BTreeSet<String>>::new();
    let modules: BTreeSet<_> = sources("runtime/core/src").iter().map(Source::module).collect();
    for source in sources("runtime/core/src") {
        if ["lib", "private"].contains(&source.layer()) {
            continue;
        }
        let own = source.module();
        let others = source.imports().into_iter().filter(|import| modules.contains(import) && *import != own);
        edges.entry(own.clone()).or_default().extend(others);
    }
    let circles = in_circles(&edges);
    assert!(circles.is_empty(), "in a circle: {circles:?}");
}

#[test]
fn models_of_robots_know_neither_simulation_nor_clearance() {
    let mut wrong = Vec::new();
    for source in sources("robots/src") {
        if source.layer() == "lib" {
            continue;
        }
        let rule = ROBOTS.iter().find(|(layer, _)| *layer == source.layer());
        let (own, allowed) = rule.unwrap_or_else(|| panic!("{} is in no folder of the robots", source.path));
        for import in source.imports() {
            let layer = import.split("::").next().unwrap_or_default();
            if layer != *own && !allowed.contains(&layer) {
                wrong.push(format!("{}: imports {import}", source.path));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The crates of the workspace that a crate depends on, other than for its tests.
fn dependencies(folder: &str) -> BTreeSet<String> {
    let manifest = fs::read_to_string(root().join(folder).join("Cargo.toml")).expect("a manifest");
    let mut found = BTreeSet::new();
    let mut counts = false;
    for line in manifest.lines() {
        if line.starts_with('[') {
            counts = line.ends_with("dependencies]") && !line.contains("dev-dependencies");
        } else if counts && line.starts_with("mrroc") {
            let package = line.split("package = \"").nth(1).and_then(|rest| rest.split('"').next());
            let name = line.split(['.', ' ', '=']).next().unwrap_or_default();
            found.insert(package.unwrap_or(name).to_owned());
        }
    }
    found
}

#[test]
fn no_crate_depends_on_one_above_it() {
    for (folder, allowed) in CRATES {
        let allowed: BTreeSet<_> = allowed.iter().map(|name| (*name).to_owned()).collect();
        let found = dependencies(folder);
        assert!(found.is_subset(&allowed), "{folder} depends on {found:?}, and may on {allowed:?}");
        if root().join(folder).join("src").is_dir() {
            let lines: usize =
                sources(&format!("{folder}/src")).iter().map(|source| source.text.lines().count()).sum();
            println!("{folder:20} {lines:6} lines");
        }
    }
}
