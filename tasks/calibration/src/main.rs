//! Two arms are calibrated by two theodolites: `cargo run --release -p calibration`.
fn main() {}
