//! Pens of plotters: which word lifts them, what is found, and what is no pen.
//!
//! M280 P S sets servo P to S degrees (Marlin's and RepRap's documentation); M300 S is the tone that drivers of
//! Inkscape's plotters (Unicorn) use for the pen, with S30 down and S50 up; servos on the spindle's pin take the S of M3.

use super::*;

fn import_with(text: &str, pen: PenLift) -> Import {
    let gcode = Switches { pen, ..Switches::default() };
    read_str("a.gcode", text, Reading { gcode, ..Reading::default() }).unwrap()
}

fn word(signal: Signal, down: Option<f64>) -> PenLift {
    PenLift::Word { signal, down }
}

/// The ends of strokes that a program draws at the depth of the run, as pairs of places.
fn lines(import: &Import) -> Vec<[f64; 4]> {
    let ends = |s: &crate::drawing::Stroke| [s.start().x, s.start().y, s.end().x, s.end().y];
    import.drawing.strokes.iter().map(ends).collect()
}

#[test]
fn the_pens_of_the_reports_are_found_and_told() {
    let servo = import(include_str!("files/g06e_servo_m280.gcode"));
    assert_eq!(lines(&servo), [[0.0, 0.0, 10.0, 0.0], [20.0, 0.0, 20.0, 10.0]]);
    assert!(servo.warnings[0].contains("M280 lifts a pen: S30 is down, S90 is up"), "{:?}", servo.warnings);
    assert!(servo.warnings.iter().all(|w| !w.contains("left out")), "{:?}", servo.warnings);
    let spindle = import(include_str!("files/g06f_m3s_pen.gcode"));
    assert_eq!(lines(&spindle), [[10.0, 0.0, 10.0, 10.0]]);
    assert!(spindle.warnings[0].contains("2 feed moves are not cut"), "{:?}", spindle.warnings);
}

#[test]
fn a_pen_that_the_word_for_tones_lifts_is_found_and_its_rests_are_told_once() {
    // As Unicorn writes: a registration test, then lines, each with a rest of 150 "milliseconds".
    let pen = |s: f64| format!("M300 S{s:.2} (pen)\nG4 P150\n");
    let mut text = format!("G21\nG90\nG92 X0.00 Y0.00 Z0.00\n{}{}M18\nM01\nM17\n", pen(30.0), pen(50.0));
    for k in 0..17 {
        let y = f64::from(k);
        text += &format!("G1 X0 Y{y} F3500\n{}G1 X10 Y{y}\n{}", pen(30.0), pen(50.0));
    }
    let read = import(&text);
    assert!((read.drawing.length() - 170.0).abs() < 1e-9, "{}", read.drawing.length());
    assert!(read.warnings[0].contains("M300 lifts a pen: S30 is down, S50 is up"), "{:?}", read.warnings);
    let rests: Vec<_> = read.warnings.iter().filter(|w| w.contains("a rest of 150 s")).collect();
    assert_eq!(rests.len(), 1, "{:?}", read.warnings);
    assert!(rests[0].starts_with("line 5: ") && rests[0].ends_with("(36 times, first here)"), "{rests:?}");
}

#[test]
fn what_the_program_does_tells_which_value_is_down() {
    // Rapid moves are made with the pen up, although the first stroke is drawn.
    let text = "G21\nM280 P0 S90\nG1 X5 F900\nM280 P0 S20\nG0 X10\nM280 P0 S90\nG1 X15\nM280 P0 S20\nG0 X0";
    assert_eq!(lines(&import(text)), [[0.0, 0.0, 5.0, 0.0], [10.0, 0.0, 15.0, 0.0]]);
    // The first stroke is made with the pen up: S120 is down.
    let text = "G21\nM280 S40\nG1 X5 F900\nM280 S120\nG1 X10\nM280 S40\nG1 X15";
    assert_eq!(lines(&import(text)), [[5.0, 0.0, 10.0, 0.0]]);
    // Nothing was said before the first stroke.
    let text = "G21\nG1 X5 F900\nM280 S120\nG1 X10\nM280 S40\nG1 X15";
    assert_eq!(lines(&import(text)), [[5.0, 0.0, 10.0, 0.0]]);
    // It begins to draw where it is: the first move is drawn, but the program begins and ends by lifting.
    let text = "G21\nM280 S90\nM280 S30\nG1 X5 F900\nM280 S90\nG1 X10\nM280 S30\nG1 X15\nM280 S90";
    assert_eq!(lines(&import(text)), [[0.0, 0.0, 5.0, 0.0], [10.0, 0.0, 15.0, 0.0]]);
    // The pen goes down by steps.
    let text = "G21\nM280 S90\nG1 X5 F900\nM280 S60\nM280 S45\nM280 S30\nG1 X10\nM280 S90\nG1 X15";
    assert_eq!(lines(&import(text)), [[5.0, 0.0, 10.0, 0.0]]);
    // A servo on the spindle's pin: always on, two values.
    let text = "G21\nM3 S90\nG1 X5 F900\nM3 S30\nG4 P0.2\nG1 X10\nM3 S90\nG4 P0.2\nG1 X15\nM3 S30\nG1 Y5\nM5";
    let read = import(text);
    assert_eq!(lines(&read), [[5.0, 0.0, 10.0, 0.0], [15.0, 0.0, 15.0, 5.0]]);
    assert!(read.warnings[0].contains("M3 lifts a pen: S30 is down"), "{:?}", read.warnings);
    // The rests of 0.2 s are those of the servo with the pen up, and with it down at the start of a line.
    assert!(read.drawing.strokes.iter().all(|stroke| stroke.manner().dwell == 0.0));
    let lifted_by_m5 = "G21\nM5\nG1 X5 F900\nM3 S30\nG1 X10\nM5\nG1 X15";
    assert_eq!(lines(&import(lifted_by_m5)), [[5.0, 0.0, 10.0, 0.0]]);
}

#[test]
fn the_option_decides_before_what_the_program_does() {
    let text = include_str!("files/g06e_servo_m280.gcode");
    let cut = |pen| import_with(text, pen);
    let other = cut(word(Signal::Servo, Some(90.0)));
    assert_eq!(lines(&other), [[10.0, 0.0, 20.0, 0.0]]);
    assert_eq!(lines(&cut(word(Signal::Servo, Some(30.0)))).len(), 2);
    assert_eq!(lines(&cut(word(Signal::Servo, None))).len(), 2);
    let by_height = cut(PenLift::Height);
    assert_eq!(by_height.drawing.length(), 30.0);
    assert!(
        by_height.warnings.iter().any(|w| w.contains("M280 left out; if it lifts the pen, say --pen m280"))
    );
    let inverse = "G21\nM3 S255\nG1 X5 F900\nM3 S0\nG1 X10\nM3 S255\nG1 X15";
    assert_eq!(lines(&import_with(inverse, word(Signal::Spindle, Some(0.0)))), [[5.0, 0.0, 10.0, 0.0]]);
    let gcode = Switches { pen: word(Signal::Tone, None), ..Switches::default() };
    let message = read_str("a.gcode", text, Reading { gcode, ..Reading::default() }).unwrap_err().to_string();
    assert!(message.contains("--pen m300 in a program whose M300 has no two values"), "{message}");
}

#[test]
fn what_is_no_pen_is_not_taken_for_one() {
    // A mill whose probe is a servo: what is below Z0 is cut.
    let read =
        import("G21\nM280 P0 S10\nM280 P0 S90\nG0 Z5\nG1 Z-1 F100\nG1 X10\nM280 P0 S10\nG1 X20\nG0 Z5");
    assert!((read.drawing.length() - 21.0).abs() < 1e-9, "{}", read.drawing.length());
    assert!(
        read.warnings.iter().any(|w| w.contains("M280 left out; if it lifts the pen")),
        "{:?}",
        read.warnings
    );
    // Tones have a duration.
    let read = import("G21\nM300 S440 P200\nG1 X10 F100\nM300 S880 P200\nG1 X20");
    assert!((read.drawing.length() - 20.0).abs() < 1e-9);
    // A laser with two powers, whose travel is rapid or dark.
    for text in [
        "G21\nM3 S200\nG1 X10 F100\nG0 X20\nM3 S800\nG1 X30\nG0 X40\nM3 S200\nG1 X50",
        "G21\nM3 S200\nG1 X10 F100\nM5\nG1 X20\nM3 S800\nG1 X30\nM5\nG1 X40\nM3 S200\nG1 X50",
        "G21\nG0 X20\nM4 S200\nG1 X30 F100\nS800\nG1 X40\nS200\nG1 X50",
    ] {
        assert!((import(text).drawing.length() - 30.0).abs() < 1e-9, "{text}");
    }
    // The S of another machine's word is not the spindle's.
    let read = import("G21\nM3 S100\nG1 X5 F100\nM204 S0\nG1 X10\nM5\nG1 X20");
    assert!((read.drawing.length() - 10.0).abs() < 1e-9, "{}", read.drawing.length());
}

#[test]
fn lines_may_end_with_carriage_returns_and_a_rotation_may_be_cancelled() {
    let read = import(include_str!("files/g07h_cr_only.nc"));
    assert_eq!(ends(&read.drawing), [[0.0, 0.0, 0.0, 10.0, 0.0, -1.0]]);
    assert!(near(import("G21 G90\rG1 X5 F100\rX5 Y5\n").drawing.length(), 10.0));
    assert!(refusal("G21 G90\rG1 X5 Q[1\rX5 Y5").contains("a.ngc:2:"));
    assert!(near(import("G21 G17 G40 G49 G69 G80\nG69\nG1 X5 F100").drawing.length(), 5.0));
    assert!(refusal("G21 G68 X0 Y0 R30\nG1 X5").contains("scaling or turning"));
}
