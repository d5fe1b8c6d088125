//! G-code: moves, rules for cutting, what is refused, and that nothing panics.

use super::{BlockDelete, Switches};
use crate::drawing::{Closure, Drawing, Import, Limits, Reading, Vec2, Vec3, read_str};
use std::f64::consts::{PI, TAU};

fn import(text: &str) -> Import {
    read_str("a.ngc", text, Limits::default()).unwrap()
}

fn drawn(text: &str) -> Drawing {
    import(text).drawing
}

fn refusal(text: &str) -> String {
    read_str("a.ngc", text, Limits::default()).unwrap_err().to_string()
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9
}

#[test]
fn travel_separates_strokes_and_words_may_touch() {
    let drawing =
        drawn("%\nN10 G21G90 (start)\nG0X1Y1\nG1 X4 f100 ; cut\nY5\ng 0 x 1 0\ng1 y 2\nM2\nG1 X99\n");
    assert_eq!(drawing.strokes.len(), 2);
    assert!(near(drawing.length(), 3.0 + 4.0 + 3.0));
}

#[test]
fn arcs_by_centre_and_by_radius_agree() {
    assert!(near(drawn("G21 G0 X10\nG3 X0 Y10 I-10 J0").length(), 5.0 * PI));
    assert!(near(drawn("G21 G0 X10\nG3 X0 Y10 R10").length(), 5.0 * PI));
    assert!(near(drawn("G21 G0 X10\nG3 X0 Y10 R-10").length(), 15.0 * PI));
    assert!(near(drawn("G21 G0 X10\nG2 X0 Y10 I-10").length(), 15.0 * PI));
    assert!(near(drawn("G21 G90.1 G0 X10 Y2\nG3 X0 Y12 I0 J2").length(), 5.0 * PI));
    let circle = drawn("G21 G0 X10\nG2 I-10");
    assert!(near(circle.length(), 10.0 * TAU));
    assert_eq!(circle.strokes[0].closure(), Closure::Closed);
}

#[test]
fn inches_and_relative_moves_are_converted() {
    let bounds = drawn("G20 G91 G0 X1\nG1 X1 Y2").bounds().unwrap();
    assert!((bounds.min - Vec2::new(25.4, 0.0)).norm() < 1e-9);
    assert!((bounds.max - Vec2::new(50.8, 50.8)).norm() < 1e-9);
}

#[test]
fn expressions_follow_rs274_precedence() {
    // 2 + 3 * 4 ** 2 / 8 = 8; sqrt[9] * cos[60] = 1.5; atan[1]/[1] = 45
    let text = "G21 G0 X0 Y0\n#1=[2 + 3*4**2/8] #<Size>=sqrt[9]\nG1 X#1 Y[#<size>*COS[60]]\nX[atan[1]/[1]]\nX-[7 mod 4]";
    let drawing = drawn(text);
    let ends: Vec<Vec2> = drawing.strokes[0].pieces().iter().map(|piece| piece.end()).collect();
    assert!((ends[0] - Vec2::new(8.0, 1.5)).norm() < 1e-9);
    assert!(near(ends[1].x, 45.0) && near(ends[2].x, -3.0));
}

#[test]
fn a_parameter_gets_its_value_after_its_line() {
    let drawing = drawn("G21 G0 X0\n#3=5\n#3=9 G1 X#3\nX#3");
    assert!(near(drawing.strokes[0].pieces()[0].end().x, 5.0));
    assert!(near(drawing.strokes[0].end().x, 9.0));
}

#[test]
fn below_zero_cuts_and_above_travels() {
    let drawing = drawn("G21 G0 Z2\nG1 X5 F100\nZ-0.5\nX10\nY5\nZ1\nX0");
    // Down 0.5, along 5 and 5, up 0.5: what is below the surface.
    assert_eq!(drawing.strokes.len(), 1);
    assert!(near(drawing.length(), 11.0));
    assert_eq!(drawing.strokes[0].height_range(), (-0.5, 0.0));
}

#[test]
fn a_laser_cuts_only_while_it_is_on() {
    let drawing = drawn("G21 M3 S500\nG1 X5 F100\nM5\nX10\nM3\nX12 S0\nX13 S9");
    assert!(near(drawing.length(), 6.0));
    assert_eq!(drawing.strokes.len(), 2);
}

#[test]
fn splines_of_linuxcnc_are_exact() {
    // LinuxCNC's manual: a G5 from 0,0 with its tangent carried on.
    let drawing = drawn("G21 G17 G0 X0 Y0\nG5 I0 J3 P0 Q-3 X1 Y1\nG5 P0 Q-3 X2 Y2");
    assert_eq!(drawing.strokes[0].pieces().len(), 2);
    let second = drawing.strokes[0].pieces()[1].point(0.5);
    // Bézier (1,1) (1,4) (2,-1) (2,2) at a half: (1.5, 1.5).
    assert!((second - Vec2::new(1.5, 1.5)).norm() < 1e-12);
    // A quadratic NURBS on three points is the quadratic Bézier curve.
    let drawing = drawn("G21 G0 X0 Y0\nG5.2 X1 Y2 P1 L3\nX2 Y0 P1\nG5.3\nG1 X5");
    assert!((drawing.strokes[0].point(0.5) - Vec2::new(1.0, 1.0)).norm() < 1e-12);
    assert!((drawing.strokes[0].end() - Vec2::new(5.0, 0.0)).norm() < 1e-12);
}

#[test]
fn refusals_point_at_the_word_and_say_what_to_do() {
    for (text, parts) in [
        ("G21\nG1 X1 Q[3", vec!["a.ngc:2:", "without its ]", "close the bracket"]),
        ("G21 G1 X", vec!["line ends where a number should be"]),
        ("G21 G1 X1.2.3", vec!["a.ngc:1:9", "is no number"]),
        ("G21 G0 X10\nG2 X0 Y9 I-10", vec!["a.ngc:2:4", "radius mismatch", "10.0000 mm", "9.0000 mm"]),
        ("G21 G0 X10\nG2 X0 Y9 R2", vec!["radius mismatch"]),
        ("G1 X1 F0", vec!["F0", "never arrive", "positive F"]),
        ("G18 G5 X1 P1 Q1 I1 J1", vec!["a spline in the plane G18 or G19"]),
        ("O100 sub", vec!["a.ngc:1", "o.. sub without its end", "o.. endsub"]),
        ("G77 X1", vec!["G77", "no G word"]),
        ("G1 X1 E3", vec!["3-D printer"]),
        ("G1 X1 X2", vec!["a second X"]),
        ("X1", vec!["before any G0"]),
        ("G1 X1 (oops", vec!["comment without its )"]),
        ("G1 X[1/0]", vec!["inf", "finite"]),
        ("G1 X[ln[-1]]", vec!["NaN"]),
        ("G1 X1e5", vec!["a.ngc:1:6", "an E word"]),
        ("G1 X#<a>", vec!["never set"]),
        ("G1 X999999999", vec!["below 10 000 000 mm"]),
        ("G21 G0 Z-1\nG1 X5\nG0 X9", vec!["a.ngc:3", "a rapid move (G0) through the plate"]),
        ("G5.2 X1 Y1\nX2 Y2", vec!["between G5.2 and G5.3"]),
        ("G0 X4", vec!["nothing to engrave", "M3/M4"]),
        ("G92", vec!["a shift without X, Y or Z"]),
    ] {
        let message = refusal(text);
        for part in parts {
            assert!(message.contains(part), "{text:?} gave {message:?} without {part:?}");
        }
    }
}

#[test]
fn deep_brackets_are_refused() {
    assert!(refusal(&format!("G1 X{}", "[".repeat(60_000))).contains("nested more than 64 deep"));
    assert!(refusal(&format!("G1 X{}1", "-".repeat(60_000))).contains("nested more than 64 deep"));
    assert!(refusal(&format!("G1 X{}1", "#".repeat(60_000))).contains("nested more than 64 deep"));
}

#[test]
fn a_million_moves_are_refused_at_the_limit() {
    let text: String = (0..1_000_000).map(|i| if i % 2 == 0 { "G1X1\n" } else { "G1X0\n" }).collect();
    assert!(refusal(&text).contains("more than 250000 curve pieces"));
    let long = format!("G1 X1 ; {}", "x".repeat(1 << 20));
    assert!(refusal(&long).contains("a line of 1048584 bytes"));
}

#[test]
fn what_does_not_matter_is_left_out_with_a_warning() {
    let import = import("T2 M6\nG41\nG1 X5\nG28\nG1 X6");
    assert!(
        import.warnings.iter().any(|w| w.contains("M6 left out: a tool change")),
        "{:?}",
        import.warnings
    );
    assert!(import.warnings.iter().any(|w| w.contains("G41")));
    assert!(import.warnings.iter().any(|w| w.contains("millimetres are assumed")));
    assert_eq!(import.drawing.strokes.len(), 2);
}

/// The ends of a drawing's strokes, which are where the tool went down and came up.
fn ends(drawing: &Drawing) -> Vec<[f64; 6]> {
    let six = |a: Vec3, b: Vec3| [a.x, a.y, a.z, b.x, b.y, b.z];
    drawing.strokes.iter().map(|stroke| six(stroke.tip(0.0), stroke.end_tip())).collect()
}

fn assert_ends(text: &str, expected: &[[f64; 6]]) {
    let found = ends(&drawn(text));
    assert_eq!(found.len(), expected.len(), "{text:?}: {found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{text:?}: {found:?} for {expected:?}");
    }
}

#[test]
fn depth_and_feed_come_from_z_and_f() {
    let drawing = drawn("G21 G0 X0 Y0 Z5\nG1 Z-5 F100\nG1 X10");
    assert!(near(drawing.length(), 15.0));
    assert_eq!(drawing.strokes[0].height_range(), (-5.0, 0.0));
    assert_eq!(drawing.strokes[0].manner().feed, Some(100.0 / 60.0));
    assert_eq!(drawing.strokes[0].manner().approach, Some(5.0));
    // Inches in a minute, in a turn at 120 turns in a minute, and half a minute for 10 mm.
    for (text, mm_per_s) in [
        ("G20 G1 X1 F60", 25.4),
        ("G21 G95 S120 M3 G1 X10 F0.5", 1.0),
        ("G21 G93 G1 X10 F2", 1.0 / 3.0),
    ] {
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
    assert!(message.contains("all 2 feed moves are above the plate, at Z5.000") && message.contains("--surface"), "{message}");
    let message = refusal("G21 G0 Z5\nG1 X10 Z-25 F100");
    assert!(message.contains("a.ngc:2: 25.000 mm below the plate") && message.contains("at most 20 mm"), "{message}");
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
        ("linuxcnc", "G21 G0 X0 Y0\nF10\nG5.2 P1 L3\nX0 Y1 P1\nX2 Y2 P1\nX2 Y0 P1\nX0 Y0 P2\nG5.3\nG0 X0 Y1\nM2"),
        ("heavy_start", "G21 G0 X0 Y0\nG5.2 P5 L4\nX10 Y20 P1\nX25 Y-5 P2\nX40 Y10 P0.5\nX30 Y30\nG5.3"),
        ("knotted", "G21 G0 X0 Y0\nG6.2 P4 K0 X0 Y0 R1\nK0 X5 Y12 R2\nK0 X15 R0.7\nK0 X22 Y-3\nK0.3 X30 Y4 R1.5\nK1\nK1\nK1\nK1\nG0 X0"),
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
        let near = stroke.flattened(1e-6).iter().map(|p| (p - middle).norm()).fold(f64::MAX, f64::min);
        assert!(near < 0.01, "{name}: {near}");
    }
}

#[test]
fn holes_are_drilled_as_the_manual_says() {
    // G81 at four places, the last two lower; G98 back to Z3.
    let four = "G21 G90 G98 G0 Z3\nG81 X1 Y0 Z-1 R1 F60\nX2\nZ-2 Y1\nX1\nG80";
    let hole = |x: f64, y: f64, z: f64| [x, y, 0.0, x, y, z];
    assert_ends(four, &[hole(1.0, 0.0, -1.0), hole(2.0, 0.0, -1.0), hole(2.0, 1.0, -2.0), hole(1.0, 1.0, -2.0)]);
    // The manual's example of increments: from (1, 2, 3), three times by (4, 5), R 1.8 above, Z 0.6 below R.
    let increments = "G21 G0 X1 Y2 Z-5\nG91 G98 G81 X4 Y5 Z-0.6 R1.8 L3";
    let low = |x: f64, y: f64| [x, y, -3.2, x, y, -3.8];
    assert_ends(increments, &[low(5.0, 7.0), low(9.0, 12.0), low(13.0, 17.0)]);
    // Pecks of 2 mm to 5 mm: G83 comes back to 0.254 mm above the bottom, from R; G73 backs off by as much.
    let pecks = [[0.0, 0.0, 0.0, 0.0, 0.0, -1.0], [0.0, 0.0, -0.746, 0.0, 0.0, -3.0], [0.0, 0.0, -2.746, 0.0, 0.0, -5.0]];
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

#[test]
fn o_words_call_loop_and_choose() {
    // The manual's saw: ten teeth, each back 1 and a tenth up.
    let saw = "G21 G0 X1 Y0\n#1 = 0\nF25\no101 while [#1 LT 10]\nG1 X0\nG1 Y[#1/10] X1\n#1 = [#1+1]\no101 endwhile\nM2";
    let expected = 10.0 + (0..10).map(|k| if k == 0 { 1.0 } else { 1f64.hypot(0.1) }).sum::<f64>();
    assert!(near(drawn(saw).length(), expected), "{}", drawn(saw).length());
    let x = |text: &str| drawn(&format!("G21 G0 X0\n{text}")).strokes.last().unwrap().end().x;
    // Arguments are the subroutine's own, a value comes back, names with _ are everybody's.
    let sub = "o<add> sub\n#<_calls> = [1 + #1]\n#1 = 99\no<add> endsub [#2 * 3]\n#1 = 5\no<add> call [7] [4]\n";
    assert_eq!(x(&format!("{sub}G1 X[#1 + #<_value> + #<_calls>]")), 5.0 + 12.0 + 8.0);
    // It calls itself: 5!.
    let factorial = "o1 sub\no2 if [#1 LE 1]\no1 return [1]\no2 endif\no1 call [#1 - 1]\no1 endsub [#1 * #<_value>]\n";
    assert_eq!(x(&format!("{factorial}o1 call [5]\nG1 X#<_value>")), 120.0);
    let branch = |n: u32| x(&format!("#3={n}\no5 if [#3 EQ 1]\nG1 X1\no5 elseif [#3 EQ 2]\nG1 X2\no5 else\nG1 X3\no5 endif"));
    assert_eq!([branch(1), branch(2), branch(7)], [1.0, 2.0, 3.0]);
    assert_eq!(x("G91\no1 repeat [3]\no2 repeat [4]\nG1 X1\no2 endrepeat\no1 endrepeat"), 12.0);
    assert_eq!(x("#1=0\no1 do\n#1=[#1+1]\no2 if [#1 EQ 4]\no1 break\no2 endif\no1 while [#1 LT 9]\nG1 X#1"), 4.0);
    let skip = "#1=0 #2=0\no1 while [#1 LT 5]\n#1=[#1+1]\no2 if [#1 MOD 2]\no1 continue\no2 endif\n#2=[#2+#1]\no1 endwhile\nG1 X#2";
    assert_eq!(x(skip), 6.0);
    assert_eq!(x("#7=8\no8 sub\nG1 X4\no8 endsub\no#7 call\no[#7] call"), 4.0);
    assert_eq!(x("#<a>=1\nG1 X[EXISTS[#<a>] + 2*EXISTS[#<b>]]"), 1.0);
    assert_eq!(x("G1 X4 Z0\nG1 X[#5420 + #<_x>]"), 8.0);
}

#[test]
fn programs_have_numbers_and_call_one_another() {
    // LinuxCNC's example: 5 times 1 and, within, 25 times 0.01.
    let text = "%\nO1 (MAIN)\nG21 #1 = 0\nM98 P100 L5\nG1 X#1\nM30\nO100\n#1 = [#1 + 1]\nM98 P200 L5\nM99\nO200\n#1 = [#1 + 0.01]\nM99\n%\n";
    assert!(near(drawn(text).strokes[0].end().x, 5.25));
    assert!(near(drawn("O32123 (PLATE)\nG21\nG1 X5\nM30").length(), 5.0));
    assert!(refusal("M98 P7").contains("no such program"));
}

#[test]
fn loops_without_an_end_and_words_astray_are_refused() {
    for (text, part) in [
        ("o1 while [1]\no1 endwhile", "a.ngc:"),
        ("o1 sub\no1 call\no1 endsub\no1 call", "calls nested more than 64 deep"),
        ("o1 do\nM98 P2\no1 while [1]\nO2\nM99", "goes on and on"),
        ("o1 repeat [1e9]\nG4 P1\no1 endrepeat", "a.ngc:1"),
        ("G1 X1\no1 endif", "a.ngc:2:1: o.. endif that ends nothing"),
        ("o1 if [1]\no2 endif", "ends nothing"),
        ("o1 frobnicate", "the O-word \"frobnicate\""),
        ("o<a> call", "a call of o<a>, which is no subroutine of this file"),
        ("o1 if [1] G1 X1\no1 endif", "more than its values"),
        ("#5221 = 3", "that the machine keeps"),
        ("IF [#1 EQ 0] GOTO 10", "a statement of Fanuc's macros"),
        ("G1 G2 X1 R1", "G1 and G2 in one line"),
        ("G21 G5.2 P1\nX1 Y1\nP2\nG5.3", "a weight without its point"),
        ("G21 G5.2 P1\nX1\nG5.3", "X or Y alone"),
        ("G21 G6.2 P3 K0 X1 Y0", "does not begin where the tool is"),
        ("G21 G6.2 P3 K0 X0 Y0\nK0 X1 Y1\nK0 X2 Y0\nK1\nK1\nG0 X0", "knots"),
        ("G21 G5 X1 Y1 Z2 I1 J1 P1 Q1", "a spline that changes Z"),
    ] {
        let message = refusal(text);
        assert!(message.contains(part), "{text:?} gave {message:?} without {part:?}");
    }
}

#[test]
fn block_delete_is_a_switch_and_words_astray_are_told() {
    let text = "G21 G1 X5\n/X9\n/ o1 repeat [2]\n/o1 endrepeat";
    let skipped = import(text);
    assert!(near(skipped.drawing.length(), 5.0));
    assert!(skipped.warnings.iter().any(|w| w.contains("3 lines that begin with / left out")), "{:?}", skipped.warnings);
    let off = Reading { gcode: Switches { block_delete: BlockDelete::Off, ..Switches::default() }, ..Reading::default() };
    assert!(near(read_str("a.ngc", text, off).unwrap().drawing.length(), 9.0));
    let told = import("G21 G1 X5 R3 Q7\nX6 R3").warnings;
    assert_eq!(told.iter().filter(|w| w.contains("it says nothing in this line")).count(), 2, "{told:?}");
    assert!(told[0].contains("line 1: R3"), "{told:?}");
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig { failure_persistence: None, ..proptest::prelude::ProptestConfig::with_cases(4000) })]

    #[test]
    fn no_program_panics(text in "([GMXYZIJKRPQLFSNO#\\[\\]0-9.+*/ ();=<>%\n-]{0,80}|.{0,40})", tail in "(G([0-5](\\.[123])?|6\\.2|1[0789]|5[2-9]|7[3]|8[0-9]|9[0-9](\\.[123])?)|[XYZIJKRPQL@^]-?[0-9.]{1,5}|\n| )") {0,40}"  {
        let _ = read_str("a.ngc", &text, Limits::default());
        let _ = read_str("a.ngc", &tail, Limits::default());
    }
}
