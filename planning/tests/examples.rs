//! The numbered examples do what they say: each asserts its own outcome.

#[path = "../examples/01_around_a_box.rs"]
mod around_a_box;
#[path = "../examples/02_new_goals.rs"]
mod new_goals;

#[test]
fn example_01_goes_around_a_box() {
    around_a_box::main().expect("runs without a fault");
}

#[test]
fn example_02_reaches_the_last_of_its_goals() {
    new_goals::main().expect("runs without a fault");
}
