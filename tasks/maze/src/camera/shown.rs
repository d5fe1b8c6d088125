//! What a user is shown of runs with the camera: figures, and a picture of a single run.

use std::error::Error;
use std::fs;

use super::eye::believed;
use super::picture::png;
use super::run::Ready;
use super::summary::{Row, Summary};
use crate::mazes::Seeded;
use crate::options::Options;

/// Runs many mazes, or the first one and draws it: how many faults there were, and what is to be said.
///
/// # Errors
/// The fault of a single run; a picture that cannot be written.
pub fn runs(mazes: &[Seeded], many: bool, options: &Options) -> Result<(usize, String), Box<dyn Error>> {
    let Some(maze) = mazes.first().filter(|_| !many) else {
        let summary = Summary::sweep(mazes);
        return Ok((summary.faults(), summary.to_string()));
    };
    let outcome = Ready::new(&maze.layout, maze.seed)?.run();
    let file = options.out.join("camera.png");
    let drawn = png(&outcome, &believed(maze.seed));
    if let Ok(drawn) = &drawn {
        fs::create_dir_all(&options.out).and_then(|()| fs::write(&file, drawn)).map_err(|error| {
            format!(
                "{}: cannot be written: {error}\n help: give a folder that can be written by --out",
                file.display()
            )
        })?;
    }
    let summary = Summary(vec![Row::of(&maze.name, &outcome)]);
    outcome.report?;
    drawn?;
    Ok((summary.faults(), format!("{summary}see {}\n", file.display())))
}
