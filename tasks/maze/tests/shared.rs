//! How much of the maze's source is the same for arm and wheels.

use std::fs;
use std::path::Path;

/// Folders and files that only one effector uses: its program, how it moves, its simulated world, how it is put into a cell.
const ARM: &[&str] = &[
    "tasks/maze/src/ecp.rs",
    "tasks/maze/src/force",
    "tasks/maze/src/found.rs",
    "tasks/maze/src/generators",
    "tasks/maze/src/plant",
];
const WHEELS: &[&str] = &["tasks/maze/src/wheels"];
/// What neither of them uses by feeling and a map: that by a camera, and that without a map.
const OTHERS: &[&str] = &["tasks/maze/src/camera", "tasks/maze/src/reactive", "sensing/map/src/taut.rs"];
/// All of the task, and the map and planner that it uses.
const ALL: &[&str] = &["tasks/maze/src", "sensing/map/src"];

/// Lines of a file that are neither blank nor comments, without its tests.
fn lines(file: &Path) -> usize {
    let text = fs::read_to_string(file).expect("a text");
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    code.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//")).count()
}

/// The same of all Rust files at a path from the root.
fn below(path: &Path) -> usize {
    if path.is_dir() {
        return fs::read_dir(path)
            .expect("a folder")
            .map(|entry| below(&entry.expect("an entry").path()))
            .sum();
    }
    if path.extension().is_some_and(|end| end == "rs") { lines(path) } else { 0 }
}

#[test]
fn at_least_four_fifths_of_the_lines_that_bring_wheels_through_a_maze_are_those_that_bring_an_arm() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let sum = |paths: &[&str]| paths.iter().map(|path| below(&root.join(path))).sum::<usize>();
    let (all, arm, wheels) = (sum(ALL) - sum(OTHERS), sum(ARM), sum(WHEELS));
    let shared = all - arm - wheels;
    let share = |own: usize| shared as f64 / (shared + own) as f64;
    println!("{shared} lines are shared, {arm} are the arm's alone, {wheels} those of wheels");
    println!(
        "of what brings wheels through a maze {:.0} % is shared, of the arm's {:.0} %",
        1e2 * share(wheels),
        1e2 * share(arm)
    );
    assert!(share(wheels) >= 0.8, "{}", share(wheels));
}
