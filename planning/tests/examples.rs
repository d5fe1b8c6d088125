//! The numbered examples do what they say: each asserts its own outcome.

#[path = "../examples/01_around_a_box.rs"]
mod around_a_box;

#[test]
fn example_01_goes_around_a_box() {
    around_a_box::main().expect("runs without a fault");
}
