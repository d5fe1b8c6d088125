//! Four legs carry a trunk over steps: `cargo run --release -p legs -- --help`.

use std::error::Error;
use std::fs;
use std::process::ExitCode;

use legs::options::{Options, parse};
use legs::pictures::film;
use legs::plant::Drawn;
use legs::run::{LENGTH, Ready};
use legs::summary::{Row, Summary};
use legs::walk::Gait;
use mrroc::console::{complain, say};
use mrroc::launch::Launch;

fn main() -> ExitCode {
    let options = match parse(std::env::args_os().skip(1)) {
        Ok(options) => options,
        Err(answer) => return Launch::answer(&answer),
    };
    match walks(&options) {
        Ok((bad, text)) => {
            let said = if options.quiet { ExitCode::SUCCESS } else { say(&text) };
            if bad == 0 { said } else { ExitCode::FAILURE }
        }
        Err(error) => {
            complain(&format!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

/// All walks; how many were bad, and what there is to say.
fn walks(options: &Options) -> Result<(usize, String), Box<dyn Error>> {
    let gait = Gait::default();
    let mut summary = Summary { gait, rows: Vec::new() };
    let first = u64::from(options.seed);
    for seed in first..first + u64::from(options.seeds.unwrap_or(1)) {
        let drawn = Drawn::by(seed, LENGTH);
        let outcome = Ready::new(&drawn, &gait, seed)?.run();
        summary.rows.push(Row::of(seed, &outcome));
        if options.seeds.is_some() {
            continue;
        }
        let file = options.out.join("legs.svg");
        let drawn = film(&outcome.seen, &drawn.ground);
        fs::create_dir_all(&options.out).and_then(|()| fs::write(&file, drawn)).map_err(|error| {
            format!(
                "{}: cannot be written: {error}\n help: give a folder that can be written by --out",
                file.display()
            )
        })?;
        return Ok((summary.bad(), format!("{summary}see {}\n", file.display())));
    }
    Ok((summary.bad(), summary.to_string()))
}
