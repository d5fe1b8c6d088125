//! Runs the cell of `cell.toml` and draws what moved: `cargo run`, or `cargo run -- --help`.

use task::belt::{PART, Shown, place};

fn main() -> std::process::ExitCode {
    let shown = Shown::default();
    let part = shown.clone();
    let film = mrroc_pictures::Film::new().with_block(PART, move || place(&part));
    mrroc::launch(move |file| task::cell(file, &shown), film)
}
