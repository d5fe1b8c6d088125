//! Two arms that follow trajectories of nodes of ROS 2:
//! `cargo run --release -p mrroc-ros2 --example goals -- --cell ports/ros2/examples/goals.toml --processes`, and in another terminal the example
//! `goals_bridge`.

mod offered;

fn main() -> std::process::ExitCode {
    mrroc::launch(offered::cell, mrroc_pictures::Film::new())
}
