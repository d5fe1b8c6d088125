//! The bridge of the example `goals`: `cargo run --release -p mrroc-ros2 --example goals_bridge -- --cell ports/ros2/examples/goals.toml --goals`.

mod offered;

fn main() -> std::process::ExitCode {
    mrroc_ros2::run("offered", offered::cell)
}
