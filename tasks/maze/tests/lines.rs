//! The programs stay short.

/// Lines of a function's body that are neither blank nor a comment alone.
fn body(source: &str, function: &str) -> usize {
    let start = ["(", "<"].iter().find_map(|after| source.find(&format!("fn {function}{after}")));
    let start = start.expect("the function");
    let lines = source[start..].lines().skip(1).take_while(|line| *line != "}");
    lines.filter(|line| !line.trim().is_empty() && !line.trim().starts_with("//")).count()
}

#[test]
fn the_mp_has_at_most_sixty_lines_and_the_reactive_controller_forty() {
    let sum = |source: &str, all: &[&str]| all.iter().map(|function| body(source, function)).sum::<usize>();
    let mp = sum(include_str!("../src/mp.rs"), &["coordinate", "carried_out"]);
    let ecp = sum(include_str!("../src/ecp.rs"), &["arm", "go", "hop"]);
    println!("lines: MP {mp}, ECP {ecp}");
    assert!(mp <= 60 && ecp <= 40, "{mp} {ecp}");
}

#[test]
fn the_purely_reactive_controller_has_at_most_forty_lines_and_so_has_the_arm_with_a_force_sensor() {
    let (reactive, starts, force) = (
        body(include_str!("../src/reactive/ecp.rs"), "arm"),
        body(include_str!("../src/reactive/mp.rs"), "coordinate"),
        body(include_str!("../src/force/ecp.rs"), "arm"),
    );
    println!("lines: reactive ECP {reactive}, the MP that starts it {starts}, ECP with force {force}");
    assert!(reactive <= 40 && starts <= 60 && force <= 40, "{reactive} {starts} {force}");
}

#[test]
fn the_programs_with_a_camera_are_as_short() {
    let (mp, ecp) = (
        body(include_str!("../src/camera/mp.rs"), "coordinate"),
        body(include_str!("../src/camera/ecp.rs"), "arm"),
    );
    println!("lines: MP {mp}, ECP {ecp}");
    assert!(mp <= 60 && ecp <= 40, "{mp} {ecp}");
}
