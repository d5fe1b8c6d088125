//! A UR5e that executes plans of MoveIt: `cargo run --release -p mrroc-ros2 --example plans -- --cell ports/ros2/examples/plans.toml --processes`, and in
//! another terminal the example `plans_bridge`.

mod planned;

fn main() -> std::process::ExitCode {
    mrroc::launch(planned::cell, mrroc_pictures::Film::new())
}
