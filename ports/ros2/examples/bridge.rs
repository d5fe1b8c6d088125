//! The bridge of the example `arms`: `cargo run --release -p mrroc-ros2 --example bridge -- --cell ports/panel/examples/cell.toml`.

mod cell;

fn main() -> std::process::ExitCode {
    mrroc_ros2::run("arms", cell::cell)
}
