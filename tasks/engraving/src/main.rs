//! Engraves a drawing with a simulated IRp-6.
fn main() {}
