//! Runs the runtime's numbered examples, each of which asserts its own outcome.

#[path = "../../runtime/examples/01_move.rs"]
mod example_01;
#[path = "../../runtime/examples/02_wait.rs"]
mod example_02;
#[path = "../../runtime/examples/03_loose.rs"]
mod example_03;
#[path = "../../runtime/examples/04_tight.rs"]
mod example_04;

#[test]
fn example_01_moves_an_arm() {
    example_01::main().expect("runs without a fault");
}

#[test]
fn example_02_waits_and_stops_at_a_sensor() {
    example_02::main().expect("runs without a fault");
}

#[test]
fn example_03_cooperates_loosely() {
    example_03::main().expect("runs without a fault");
}

#[test]
fn example_04_cooperates_tightly_and_is_suspended() {
    example_04::main().expect("runs without a fault");
}
