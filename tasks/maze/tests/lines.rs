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
    let (mp, ecp) =
        (body(include_str!("../src/mp.rs"), "coordinate"), body(include_str!("../src/ecp.rs"), "arm"));
    println!("lines: MP {mp}, ECP {ecp}");
    assert!(mp <= 60 && ecp <= 40, "{mp} {ecp}");
}
