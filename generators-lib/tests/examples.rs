//! The numbered examples do what they say: each asserts its own outcome.

#[path = "../examples/07_belt_in_the_background.rs"]
pub mod belt_in_the_background;
#[path = "../examples/08_cells_of_cells.rs"]
pub mod cells_of_cells;
#[path = "../examples/06_conditions.rs"]
pub mod conditions;
#[path = "../examples/05_force.rs"]
pub mod force;
#[path = "../examples/01_jerk_limited_plan.rs"]
pub mod jerk_limited_plan;
#[path = "../examples/09_pallet.rs"]
pub mod pallet;
#[path = "../examples/02_spline_through_points.rs"]
pub mod spline_through_points;
#[path = "../examples/04_two_arms_carry.rs"]
pub mod two_arms_carry;
#[path = "../examples/03_via_points.rs"]
pub mod via_points;

#[test]
fn example_01_plans_joints_that_arrive_together_within_their_limits() {
    jerk_limited_plan::main().expect("in range");
}

#[test]
fn example_02_passes_its_points_on_a_spline() {
    spline_through_points::main().expect("runs without a fault");
}

#[test]
fn example_03_passes_via_points_within_a_deviation() {
    via_points::main().expect("runs without a fault");
}

#[test]
fn example_04_keeps_two_arms_on_one_body() {
    two_arms_carry::main().expect("runs without a fault");
}

#[test]
fn example_05_presses_on_a_table() {
    force::main().expect("runs without a fault");
}

#[test]
fn example_06_waits_for_what_holds_together() {
    conditions::main().expect("runs without a fault");
}

#[test]
fn example_07_runs_a_belt_while_an_arm_moves() {
    belt_in_the_background::main().expect("runs without a fault");
}

#[test]
fn example_08_goes_on_without_a_cell_until_it_is_reset() {
    cells_of_cells::main().expect("runs without a fault");
}

#[test]
fn example_09_takes_parts_from_one_pallet_to_another() {
    pallet::main().expect("runs without a fault");
}

/// `cargo test --doc` runs them.
#[test]
fn every_generator_combinator_and_condition_has_an_example_with_an_outcome() {
    for folder in ["generators", "combinators", "conditions"] {
        let folder = format!("{}/src/{folder}", env!("CARGO_MANIFEST_DIR"));
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let file = path.file_name().and_then(|name| name.to_str()).expect("a plain name");
            if ["mod.rs", "group.rs", "stopwatch.rs"].contains(&file) {
                continue;
            }
            // The tests of a file are in a folder of its name.
            if path.is_dir() && path.with_extension("rs").is_file() {
                continue;
            }
            let text = std::fs::read_to_string(&path).expect("a file");
            let documented = text.split_once("#[cfg(test)]").map_or(text.as_str(), |(code, _)| code);
            // An example that runs has neither a language nor a word that keeps it from running behind its fence.
            let mut parts = documented.split("/// ```");
            let runs = parts.any(|part| part.starts_with('\n') && part.contains("/// assert"));
            assert!(runs, "{file} has no example that runs");
        }
    }
}
