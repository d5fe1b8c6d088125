//! The programs stay short.

/// Lines of a function's body that are neither blank nor a comment alone.
fn body(source: &str, function: &str) -> usize {
    let start = source.find(&format!("fn {function}(")).expect("the function");
    let lines = source[start..].lines().skip(1).take_while(|line| *line != "}");
    lines.filter(|line| !line.trim().is_empty() && !line.trim().starts_with("//")).count()
}

#[test]
fn mp_and_ecp_have_at_most_forty_lines_each() {
    let mp = body(include_str!("../src/mp.rs"), "coordinate");
    let ecp = include_str!("../src/ecp.rs");
    let (arm, hand) = (body(ecp, "arm"), body(ecp, "hand"));
    println!("lines: MP {mp}, ECP of the arm {arm}, of the hand {hand}");
    assert!(mp <= 40 && arm <= 40 && hand <= 40, "{mp} {arm} {hand}");
    let mp = body(include_str!("../src/camera/mp.rs"), "coordinate");
    let ecp = include_str!("../src/camera/ecp.rs");
    let (arm, hand) = (body(ecp, "arm"), body(ecp, "hand"));
    let two = body(include_str!("../src/camera/share.rs"), "coordinate");
    println!("lines of the MP of two arms: {two}");
    assert!(two <= 40, "{two}");
    println!("lines with the camera: MP {mp}, ECP of the arm {arm}, of the hand {hand}");
    assert!(mp <= 40 && arm <= 40 && hand <= 40, "{mp} {arm} {hand}");
}
