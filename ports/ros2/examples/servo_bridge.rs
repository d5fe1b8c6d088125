//! The bridge of the example `servo`: `cargo run --release -p mrroc-ros2 --example servo_bridge -- --cell ports/ros2/examples/servo.toml`.

mod following;

fn main() -> std::process::ExitCode {
    mrroc_ros2::run("servo", following::cell)
}
