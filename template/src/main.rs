//! Runs the cell of `cell.toml` and draws what moved: `cargo run`, or `cargo run -- --help`.

fn main() -> std::process::ExitCode {
    mrroc::launch(task::cell, mrroc_pictures::Film::new())
}
