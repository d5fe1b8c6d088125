//! Holes, coordinate systems, polar words.

use super::*;

#[test]
fn holes_are_drilled_as_the_manual_says() {
    // G81 at four places, the last two lower; G98 back to Z3.
    let four = "G21 G90 G98 G0 Z3\nG81 X1 Y0 Z-1 R1 F60\nX2\nZ-2 Y1\nX1\nG80";
    let hole = |x: f64, y: f64, z: f64| [x, y, 0.0, x, y, z];
    assert_ends(
        four,
        &[hole(1.0, 0.0, -1.0), hole(2.0, 0.0, -1.0), hole(2.0, 1.0, -2.0), hole(1.0, 1.0, -2.0)],
    );
    // The manual's example of increments: from (1, 2, 3), three times by (4, 5), R 1.8 above, Z 0.6 below R.
    // The surface lies between R, 4.8, and the bottom, 4.2.
    let increments = "G21 G0 Z5\nX1 Y2\nZ3\nG91 G98 G81 X4 Y5 Z-0.6 R1.8 L3";
    let reading = Reading { gcode: Switches { surface: 4.5, ..Switches::default() }, ..Reading::default() };
    let found = ends(&read_str("a.ngc", increments, reading).unwrap().drawing);
    for (found, [x, y]) in found.iter().zip([[5.0, 7.0], [9.0, 12.0], [13.0, 17.0]]) {
        let expected = [x, y, 0.0, x, y, -0.3];
        assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} for {expected:?}");
    }
    assert_eq!(found.len(), 3);
    // Pecks of 2 mm to 5 mm: G83 comes back to 0.254 mm above the bottom, from R; G73 backs off by as much.
    let pecks = [
        [0.0, 0.0, 0.0, 0.0, 0.0, -1.0],
        [0.0, 0.0, -0.746, 0.0, 0.0, -3.0],
        [0.0, 0.0, -2.746, 0.0, 0.0, -5.0],
    ];
    assert_ends("G21 G0 Z1\nG83 X0 Y0 Z-5 R1 Q2", &pecks);
    assert_ends("G21 G0 Z1\nG73 X0 Y0 Z-5 R1 Q2", &pecks);
    let goes_on = |text: &str| drawn(text).strokes.iter().map(|s| s.manner().goes_on).collect::<Vec<_>>();
    assert_eq!(goes_on("G21 G0 Z1\nG83 X0 Y0 Z-5 R1 Q2"), [false, false, false]);
    assert_eq!(goes_on("G21 G0 Z1\nG73 X0 Y0 Z-5 R1 Q2"), [false, true, true]);
    assert_eq!(drawn("G21 G0 Z1\nG82 X5 Z-1 R1 P0.7").strokes[0].manner().dwell, 0.7);
    for (text, part) in [
        ("G81 X1 R1", "without Z and R"),
        ("G81 X1 Z2 R1", "R is below its Z"),
        ("G83 X1 Z-2 R1", "pecks without Q"),
        ("G83 X1 Z-2 R1 Q0", "pecks without Q"),
        ("G81 X1 Z-2 R1 L0", "L0"),
        ("G84 X1 Z-2 R1", "tapping"),
        ("G18 G81 X1 Z-2 R1", "G18 or G19"),
    ] {
        assert!(refusal(text).contains(part), "{text}: {}", refusal(text));
    }
}

#[test]
fn coordinate_systems_and_shifts_place_what_is_cut() {
    // G92 names the place where the tool is; G52 shifts; G10 L2 places a system, L20 by where the tool is.
    let line = |x: f64, to: f64| [x, 0.0, 0.0, to, 0.0, 0.0];
    assert_ends("G21 G0 X10\nG92 X0\nG1 X5\nG92.1\nG0 X0\nG1 X1", &[line(10.0, 15.0), line(0.0, 1.0)]);
    assert_ends("G21 G52 X100\nG0 X0\nG1 X5\nG52 X0\nX107", &[line(100.0, 107.0)]);
    assert_ends("G21 G10 L2 P2 X50\nG55 G0 X0\nG1 X5\nG54 G0 X0\nG1 X5", &[line(50.0, 55.0), line(0.0, 5.0)]);
    assert_ends("G21 G0 X30\nG10 L20 P1 X0\nG1 X5", &[line(30.0, 35.0)]);
    let told = import("G21 G54 G1 X5\nG56 G1 X9").warnings.join("\n");
    assert!(told.contains("does not place G56"), "{told}");
    // Polar: 10 mm at 0 and at 90 degrees about the active zero, and 90 degrees further.
    assert_ends("G21 G52 X1\nG0 @10 ^0\nG1 ^90", &[[11.0, 0.0, 0.0, 1.0, 10.0, 0.0]]);
    assert_ends("G21 G0 @10 ^0\nG91 G1 ^90", &[[10.0, 0.0, 0.0, 0.0, 10.0, 0.0]]);
    assert!(refusal("G21 G91 G1 @5").contains("go on from the zero"));
    assert!(refusal("G21 G1 @5 X3").contains("polar words beside X or Y"));
}
