//! The bridge of the example `arms`: `cargo run --release -p mrroc-ros2 --example bridge -- --cell ports/ros2/examples/cell.toml`.

mod cell;

fn main() -> std::process::ExitCode {
    mrroc_ros2::run("arms", cell::cell)
}
