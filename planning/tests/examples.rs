//! The numbered examples do what they say: each asserts its own outcome.

#[path = "../examples/01_around_a_box.rs"]
mod around_a_box;
#[path = "../examples/03_carry_a_plate.rs"]
pub(crate) mod carry_a_plate;
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

#[test]
fn example_03_carries_a_plate_without_a_pull_at_it() {
    carry_a_plate::main().expect("runs without a fault");
}
