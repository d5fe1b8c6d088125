//! G-code: moves, rules for cutting, what is refused, and that nothing panics.

mod depth;
mod pens;
mod places;
mod programs;

use super::{BlockDelete, PenLift, Signal, Switches};
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

/// The ends of a drawing's strokes, which are where the tool went down and came up.
fn ends(drawing: &Drawing) -> Vec<[f64; 6]> {
    let six = |a: Vec3, b: Vec3| [a.x, a.y, a.z, b.x, b.y, b.z];
    drawing.strokes.iter().map(|stroke| six(stroke.tip(0.0), stroke.end_tip())).collect()
}

fn assert_ends(text: &str, expected: &[[f64; 6]]) {
    let found = ends(&drawn(text));
    assert_eq!(found.len(), expected.len(), "{text:?}: {found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9),
            "{text:?}: {found:?} for {expected:?}"
        );
    }
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

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig { failure_persistence: None, ..proptest::prelude::ProptestConfig::with_cases(1000) })]

    #[test]
    fn no_program_panics(text in "([GMXYZIJKRPQLFSNO#\\[\\]0-9.+*/ ();=<>%\r\n-]{0,80}|.{0,40})", tail in "(G([0-5](\\.[123])?|6\\.2|1[0789]|5[2-9]|7[3]|8[0-9]|9[0-9](\\.[123])?)|M(3|4|5|280 P0|300)|[SXYZIJKRPQL@^]-?[0-9.]{1,5}|\n| ){0,40}") {
        let _ = read_str("a.ngc", &text, Limits::default());
        let _ = read_str("a.ngc", &tail, Limits::default());
    }
}
