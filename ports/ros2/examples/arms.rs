//! Two arms that go to and fro, for nodes of ROS 2:
//! `cargo run --release -p mrroc-ros2 --example arms -- --cell ports/panel/examples/cell.toml --processes`, and in another terminal the example `bridge`.
//!
//! `--turns` behind a `--` says how often they go, a thousand times by default.

mod cell;

fn main() -> std::process::ExitCode {
    mrroc::launch(cell::cell, mrroc_pictures::Film::new())
}
