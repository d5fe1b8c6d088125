//! An arm that follows the twists of a topic of ROS 2, or with `poses.toml` its poses:
//! `cargo run --release -p mrroc-ros2 --example servo -- --cell ports/ros2/examples/servo.toml --processes`, and in another terminal the example
//! `servo_bridge` with the same cell.
//!
//! `--seconds` behind a `--` says for how long, a minute by default.

mod following;

fn main() -> std::process::ExitCode {
    mrroc::launch(following::cell, mrroc_pictures::Film::new())
}
