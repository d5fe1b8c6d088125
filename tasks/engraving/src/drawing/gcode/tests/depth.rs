//! Depths, feeds, helices, arcs in all planes, splines.

use super::*;

#[test]
fn depth_and_feed_come_from_z_and_f() {
    let drawing = drawn("G21 G0 X0 Y0 Z5\nG1 Z-5 F100\nG1 X10");
    assert!(near(drawing.length(), 15.0));
    assert_eq!(drawing.strokes[0].height_range(), (-5.0, 0.0));
    assert_eq!(drawing.strokes[0].manner().feed, Some(100.0 / 60.0));
    assert_eq!(drawing.strokes[0].manner().approach, Some(5.0));
    // Inches in a minute, in a turn at 120 turns in a minute, and half a minute for 10 mm.
    for (text, mm_per_s) in
        [("G20 G1 X1 F60", 25.4), ("G21 G95 S120 M3 G1 X10 F0.5", 1.0), ("G21 G93 G1 X10 F2", 1.0 / 3.0)]
    {
        let feed = drawn(text).strokes[0].manner().feed.unwrap();
        assert!(near(feed, mm_per_s), "{text}: {feed}");
    }
    // A change of feed begins a stroke that goes on without lifting.
    let drawing = drawn("G21 G1 X10 Z-1 F600\nX20 F60\nX30\nG4 P0.5\nX40");
    let manners: Vec<_> = drawing.strokes.iter().map(|stroke| *stroke.manner()).collect();
    assert_eq!(manners.iter().map(|m| m.feed.unwrap()).collect::<Vec<_>>(), [10.0, 1.0, 1.0]);
    assert_eq!(manners.iter().map(|m| m.goes_on).collect::<Vec<_>>(), [false, true, true]);
    assert_eq!(manners.iter().map(|m| m.dwell).collect::<Vec<_>>(), [0.0, 0.5, 0.0]);
}

#[test]
fn only_what_is_below_the_surface_is_cut() {
    // From Z1 down to Z-3 over 40 mm: the surface is passed after 10.
    assert_ends("G21 G0 Z1\nG1 X40 Z-3\nG0 Z1", &[[10.0, 0.0, 0.0, 40.0, 0.0, -3.0]]);
    let message = refusal("G21 G0 Z5\nG1 X10 F100\nG1 Y10");
    assert!(
        message.contains("all 2 feed moves are above the plate, at Z5.000") && message.contains("--surface"),
        "{message}"
    );
    let message = refusal("G21 G0 Z5\nG1 X10 Z-25 F100");
    assert!(
        message.contains("a.ngc:2: 25.000 mm below the plate") && message.contains("at most 20 mm"),
        "{message}"
    );
    // The surface of the file may lie elsewhere.
    let reading = Reading { gcode: Switches { surface: 5.0, ..Switches::default() }, ..Reading::default() };
    let import = read_str("a.ngc", "G21 G0 Z9\nG1 Z4\nX10", reading).unwrap();
    assert_eq!(import.drawing.strokes[0].height_range(), (-1.0, 0.0));
}

#[test]
fn a_helix_has_its_depth_and_its_turns() {
    let drawing = drawn("G21 G0 X10 Z0\nG2 X10 Y0 I-10 Z-2 P4");
    // Each turn is the hypotenuse of its circumference and half a millimetre.
    assert!(near(drawing.length(), 4.0 * (10.0 * TAU).hypot(0.5)), "{}", drawing.length());
    let tip = drawing.strokes[0].tip(2.5);
    assert!((tip - Vec3::new(-10.0, 0.0, -1.25)).norm() < 1e-9, "{tip}");
    // A quarter and two whole turns.
    assert!(near(drawn("G21 G0 X10\nG3 X0 Y10 I-10 P3").length(), 10.0 * (TAU / 4.0 + 2.0 * TAU)));
    assert!(refusal("G21 G0 X10\nG3 X0 Y10 I-10 P1.5").contains("P1.5 turns"));
}

#[test]
fn arcs_in_the_other_planes_are_arcs() {
    // A half circle of 5 mm below the surface: G18 turns from Z to X, G19 from Y to Z.
    for text in ["G21 G18 G0 X0 Z0\nG3 X-10 Z0 I-5 K0", "G21 G19 G0 Y0 Z0\nG3 Y10 Z0 J5 K0"] {
        let drawing = drawn(text);
        assert!((drawing.length() - 5.0 * PI).abs() < 1e-6, "{text}: {}", drawing.length());
        assert!((drawing.strokes[0].height_range().0 + 5.0).abs() < 1e-6);
        let bounds = drawing.bounds().unwrap();
        assert!((bounds.size().amax() - 10.0).abs() < 1e-9 && bounds.size().amin() < 1e-9);
    }
    // The other way round it stays above the plate.
    assert!(refusal("G21 G18 G0 X0 Z0\nG2 X-10 Z0 I-5 K0").contains("above the plate"));
    // Every point of a screw about Y lies 5 mm from its axis.
    let drawing = drawn("G21 G18 G0 X0 Z0\nG3 X-10 Z0 Y6 I-5 K0");
    for k in 0..=200 {
        let tip = drawing.strokes[0].tip(f64::from(k) / 200.0 * drawing.strokes[0].pieces().len() as f64);
        assert!(((tip.x + 5.0).hypot(tip.z) - 5.0).abs() < 1e-6, "{tip}");
    }
}

#[test]
fn the_weight_of_the_first_point_and_knots_are_those_of_scipy() {
    let programs = [
        (
            "linuxcnc",
            "G21 G0 X0 Y0\nF10\nG5.2 P1 L3\nX0 Y1 P1\nX2 Y2 P1\nX2 Y0 P1\nX0 Y0 P2\nG5.3\nG0 X0 Y1\nM2",
        ),
        ("heavy_start", "G21 G0 X0 Y0\nG5.2 P5 L4\nX10 Y20 P1\nX25 Y-5 P2\nX40 Y10 P0.5\nX30 Y30\nG5.3"),
        (
            "knotted",
            "G21 G0 X0 Y0\nG6.2 P4 K0 X0 Y0 R1\nK0 X5 Y12 R2\nK0 X15 R0.7\nK0 X22 Y-3\nK0.3 X30 Y4 R1.5\nK1\nK1\nK1\nK1\nG0 X0",
        ),
    ];
    let rows = include_str!("reference/nurbs.csv").lines().skip(1);
    for (row, (name, program)) in rows.zip(programs) {
        let fields: Vec<&str> = row.split(',').collect();
        assert_eq!(fields[0], name);
        let number = |k: usize| fields[k].parse::<f64>().unwrap();
        let drawing = drawn(program);
        assert!((drawing.length() - number(1)).abs() < 1e-5 * number(1), "{name}: {}", drawing.length());
        // The middle of the parameter lies on the curve.
        let stroke = &drawing.strokes[0];
        let middle = Vec2::new(number(2), number(3));
        let polyline = stroke.flattened(1e-6);
        let distance = |w: &[Vec2]| {
            let along = w[1] - w[0];
            let t = ((middle - w[0]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            (w[0] + along * t - middle).norm()
        };
        let near = polyline.windows(2).map(distance).fold(f64::MAX, f64::min);
        assert!(near < 1e-5, "{name}: {near}");
    }
}
