//! The cells of the tutorial's projects, and what its pages show.

// Each chapter uses some of it.
#![allow(dead_code)]

use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;

use mrroc::cell::RunReport;
use mrroc::prelude::*;

/// The cell of a project with one robot.
pub const ONE: &str = "
step_ms = 2
[robots.arm]
kind = \"irp6\"
start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]
";

/// The cell of a project with two robots.
pub const TWO: &str = "
step_ms = 2
[robots.left]
kind = \"irp6\"
start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]
base = { xyz = [0.0, 0.6, 0.0] }
[robots.right]
kind = \"irp6\"
start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]
base = { xyz = [0.0, -0.6, 0.0] }
";

pub fn file(text: &str) -> CellFile {
    CellFile::parse("cell.toml", text).expect("in order")
}

/// Where the tool of each robot was at the end of each servo period [m], by the robot's name.
pub type Paths = Rc<RefCell<Vec<(String, [f64; 3])>>>;

pub fn watched(cell: Cell) -> (Cell, Paths) {
    let paths = Paths::default();
    let seen = Rc::clone(&paths);
    let cell = cell.watch(move |robot| {
        let mut tool = [0.0; 3];
        robot.frames(&mut |frame| tool = frame.translation.vector.into());
        seen.borrow_mut().push((robot.robot.to_owned(), tool));
    });
    (cell, paths)
}

/// How far the tool of a robot went along an axis of the world: below and above where it began [m].
pub fn extent(paths: &Paths, robot: &str, axis: usize) -> (f64, f64) {
    let paths = paths.borrow();
    let mut along = paths.iter().filter(|(name, _)| name == robot).map(|(_, at)| at[axis]);
    let begin = along.next().expect("it was seen");
    along.fold((0.0_f64, 0.0_f64), |(low, high), at| (low.min(at - begin), high.max(at - begin)))
}

/// What a project prints at the end of such a run.
pub fn printed(report: &RunReport) -> String {
    format!("ran {:.3} s in {} steps: see picture.svg", report.time.as_secs_f64(), report.steps)
}

/// A page of the tutorial shows this text, line by line, with `..` where it leaves something out.
pub fn shows(page: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/src/tutorial").join(page);
    let page = std::fs::read_to_string(&path).expect("the page is there");
    let blocks = page.split("```text\n").skip(1).filter_map(|rest| rest.split("```").next());
    let shown: Vec<_> = blocks.flat_map(str::lines).collect();
    for line in text.lines() {
        assert!(shown.iter().any(|shown| matches(shown, line)), "{} does not show\n{line}", path.display());
    }
}

/// Whether a line that was written is the one that is shown, in which `..` stands for anything.
pub fn matches(shown: &str, written: &str) -> bool {
    let parts: Vec<_> = shown.split("..").collect();
    let (first, last) = (parts[0], parts[parts.len() - 1]);
    if parts.len() == 1 {
        return shown == written;
    }
    let Some(mut rest) = written.strip_prefix(first).and_then(|rest| rest.strip_suffix(last)) else {
        return false;
    };
    for part in &parts[1..parts.len() - 1] {
        let Some(at) = rest.find(part) else { return false };
        rest = &rest[at + part.len()..];
    }
    true
}
