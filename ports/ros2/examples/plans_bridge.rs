//! The bridge of the example `plans`: `cargo run --release -p mrroc-ros2 --example plans_bridge -- --cell ports/ros2/examples/plans.toml --goals`.

mod planned;

fn main() -> std::process::ExitCode {
    mrroc_ros2::run("plans", planned::cell)
}
