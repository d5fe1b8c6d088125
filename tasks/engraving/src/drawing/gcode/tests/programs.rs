//! O-words, numbered programs, block delete, and what is refused of them.

use super::*;

#[test]
fn o_words_call_loop_and_choose() {
    // The manual's saw: ten teeth, each back 1 and a tenth up.
    let saw = "G21 G0 X1 Y0\n#1 = 0\nF25\no101 while [#1 LT 10]\nG1 X0\nG1 Y[#1/10] X1\n#1 = [#1+1]\no101 endwhile\nM2";
    let expected = 10.0 + (0..10).map(|k| if k == 0 { 1.0 } else { 1f64.hypot(0.1) }).sum::<f64>();
    assert!(near(drawn(saw).length(), expected), "{}", drawn(saw).length());
    let x = |text: &str| drawn(&format!("G21 G0 X0\n{text}")).strokes.last().unwrap().end().x;
    // Arguments are the subroutine's own, a value comes back, names with _ are everybody's.
    let sub =
        "o<add> sub\n#<_calls> = [1 + #1]\n#1 = 99\no<add> endsub [#2 * 3]\n#1 = 5\no<add> call [7] [4]\n";
    assert_eq!(x(&format!("{sub}G1 X[#1 + #<_value> + #<_calls>]")), 5.0 + 12.0 + 8.0);
    // It calls itself: 5!.
    let factorial =
        "o1 sub\no2 if [#1 LE 1]\no1 return [1]\no2 endif\no1 call [#1 - 1]\no1 endsub [#1 * #<_value>]\n";
    assert_eq!(x(&format!("{factorial}o1 call [5]\nG1 X#<_value>")), 120.0);
    let branch = |n: u32| {
        x(&format!("#3={n}\no5 if [#3 EQ 1]\nG1 X1\no5 elseif [#3 EQ 2]\nG1 X2\no5 else\nG1 X3\no5 endif"))
    };
    assert_eq!([branch(1), branch(2), branch(7)], [1.0, 2.0, 3.0]);
    assert_eq!(x("G91\no1 repeat [3]\no2 repeat [4]\nG1 X1\no2 endrepeat\no1 endrepeat"), 12.0);
    assert_eq!(
        x("#1=0\no1 do\n#1=[#1+1]\no2 if [#1 EQ 4]\no1 break\no2 endif\no1 while [#1 LT 9]\nG1 X#1"),
        4.0
    );
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
        ("G1 X1\no1 endif", "a.ngc:2: o.. endif that ends nothing"),
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
    assert!(
        skipped.warnings.iter().any(|w| w.contains("3 lines that begin with / left out")),
        "{:?}",
        skipped.warnings
    );
    let off = Reading {
        gcode: Switches { block_delete: BlockDelete::Off, ..Switches::default() },
        ..Reading::default()
    };
    assert!(near(read_str("a.ngc", text, off).unwrap().drawing.length(), 9.0));
    let told = import("G21 G1 X5 R3 Q7\nX6 R3").warnings;
    assert_eq!(told.iter().filter(|w| w.contains("it says nothing in this line")).count(), 2, "{told:?}");
    assert!(told[0].contains("line 1: R3"), "{told:?}");
}
