//! DXF: entities, blocks, units, what is refused, and that nothing panics.

mod hidden;
mod in_space;
mod texts;

use crate::drawing::{Closure, Import, Limits, Vec2, read_str};
use std::f64::consts::TAU;

/// A file of `code value` pairs given on one line each, in ENTITIES, behind a header in millimetres.
fn file(blocks: &str, entities: &str, units: u32) -> String {
    let tags = |text: &str| text.split_whitespace().collect::<Vec<_>>().join("\n");
    tags(&format!(
        "0 SECTION 2 HEADER 9 $INSUNITS 70 {units} 0 ENDSEC 0 SECTION 2 BLOCKS {blocks} 0 ENDSEC \
         0 SECTION 2 ENTITIES {entities} 0 ENDSEC 0 EOF"
    ))
}

fn import(blocks: &str, entities: &str) -> Import {
    read_str("a.dxf", &file(blocks, entities, 4), Limits::default()).unwrap()
}

fn refusal(text: &str) -> String {
    read_str("a.dxf", text, Limits::default()).unwrap_err().to_string()
}

fn length(entities: &str) -> f64 {
    import("", entities).drawing.length()
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-6
}

#[test]
fn curves_have_their_lengths() {
    assert!(near(length("0 LINE 10 1 20 1 11 4 21 5"), 5.0));
    assert!(near(length("0 CIRCLE 10 1 20 1 40 3"), 3.0 * TAU));
    assert!(near(length("0 ARC 10 1 20 1 40 3 50 350 51 80"), 3.0 * TAU / 4.0));
    assert!(near(length("0 ELLIPSE 10 0 20 0 11 2 21 0 40 1 41 0 42 6.283185307179586"), 2.0 * TAU));
    assert!(near(length("0 LWPOLYLINE 70 1 10 0 20 0 10 3 20 0 10 3 20 4"), 12.0));
    assert!(near(length("0 LWPOLYLINE 70 0 10 0 20 0 42 1 10 4 20 0"), TAU));
    assert!(near(
        length("0 POLYLINE 70 1 0 VERTEX 10 0 20 0 0 VERTEX 10 3 20 0 0 VERTEX 10 3 20 4 0 SEQEND"),
        12.0
    ));
    assert!(near(length("0 SPLINE 71 1 40 0 40 0 40 1 40 2 40 2 10 0 20 0 10 3 20 0 10 3 20 4"), 7.0));
    assert!(near(length("0 SPLINE 71 3 11 0 21 0 11 3 21 0 11 9 21 0"), 9.0));
}

#[test]
fn inches_become_millimetres() {
    let text = file("", "0 LINE 10 0 20 0 11 1 21 0", 1);
    assert!(near(read_str("a.dxf", &text, Limits::default()).unwrap().drawing.length(), 25.4));
    let text = file("", "0 LINE 10 0 20 0 11 1 21 0", 0);
    let import = read_str("a.dxf", &text, Limits::default()).unwrap();
    assert!(import.warnings[0].contains("millimetres are assumed"));
}

#[test]
fn an_insert_scales_turns_and_repeats() {
    let blocks = "0 BLOCK 2 bolt 10 1 20 0 0 LINE 10 1 20 0 11 2 21 0 0 ENDBLK";
    let import = import(blocks, "0 INSERT 2 BOLT 10 10 20 10 41 3 42 3 50 90 70 2 44 5");
    let bounds = import.drawing.bounds().unwrap();
    assert!((bounds.min - Vec2::new(10.0, 10.0)).norm() < 1e-9, "{bounds:?}");
    assert!((bounds.max - Vec2::new(10.0, 18.0)).norm() < 1e-9, "{bounds:?}");
}

#[test]
fn an_extrusion_downwards_mirrors() {
    let bounds = import("", "0 CIRCLE 10 5 20 1 40 1 230 -1").drawing.bounds().unwrap();
    assert!((bounds.centre() - Vec2::new(-5.0, 1.0)).norm() < 1e-9);
}

#[test]
fn touching_lines_become_one_stroke() {
    let import =
        import("", "0 LINE 10 0 20 0 11 4 21 0 0 LINE 10 0 20 3 11 0 21 0 0 LINE 10 4 20 0 11 0 21 3");
    assert_eq!(import.drawing.strokes.len(), 1);
    assert_eq!(import.drawing.strokes[0].closure(), Closure::Closed);
}

#[test]
fn other_entities_are_counted() {
    let import = import("", "0 HATCH 10 1 20 1 0 HATCH 10 1 20 1 0 LINE 10 0 20 0 11 1 21 0");
    assert!(import.warnings.iter().any(|w| w.contains("2 HATCH left out")), "{:?}", import.warnings);
}

#[test]
fn refusals_say_where_and_what() {
    let cut = file("", "0 LINE 10 0 20 0 11 1 21 0", 4);
    let cut = &cut[..cut.len() - 20];
    assert!(refusal(cut).contains("cut short"), "{}", refusal(cut));
    for (entities, part) in [
        ("0 LINE 10 0 20 0 11 abc 21 0", "group 11 is \"abc\""),
        ("0 LINE 10 0 20 0 11 inf 21 0", "not a number that a drawing can hold"),
        ("0 LINE 10 0 20 0 11 1e99 21 0", "below 10 000 000 mm"),
        ("0 LINE 10 0 20 0", "LINE without its group 11"),
        ("0 CIRCLE 10 0 20 0 40 0", "CIRCLE of radius 0"),
        ("0 SPLINE 71 3 40 0 40 1 10 0 20 0 10 1 20 1", "it needs 4 or more"),
        ("", "nothing to engrave"),
    ] {
        let message = refusal(&file("", entities, 4));
        assert!(message.contains(part), "{entities}: {message}");
    }
    assert!(refusal("0\nSECTION\n2\nENTITIES\nhello\nx").contains("a.dxf:5:1: no group code"));
}

#[test]
fn a_block_in_itself_is_refused() {
    let blocks = "0 BLOCK 2 A 10 0 20 0 0 INSERT 2 A 10 0 20 0 0 INSERT 2 A 10 0 20 0 0 ENDBLK";
    let message = refusal(&file(blocks, "0 INSERT 2 A 10 0 20 0", 4));
    assert!(message.contains("blocks nested more than 64 deep"), "{message}");
}

#[test]
fn a_million_lines_are_refused_at_the_limit() {
    let message = refusal(&file("", &"0 LINE 10 0 20 0 11 1 21 0 ".repeat(300_000), 4));
    assert!(message.contains("more than 250000 curve pieces"), "{message}");
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig { failure_persistence: None, ..proptest::prelude::ProptestConfig::with_cases(1000) })]

    #[test]
    fn no_file_panics(
        noise in ".{0,60}",
        entities in "(0 (LINE|ARC|CIRCLE|ELLIPSE|SPLINE|TEXT|MTEXT|LWPOLYLINE|POLYLINE|VERTEX|SEQEND|INSERT|ATTRIB|ATTDEF|BLOCK|ENDBLK) |(10|20|30|11|21|31|12|22|13|23|40|41|42|43|50|51|60|62|66|70|71|72|73|74|101|210|220|230|1|2|3|8) (-?[0-9]{1,3}(\\.5)?|A|1e300|%%065|\\\\U\\+00D8|1e-300) ){0,25}"
    ) {
        let _ = read_str("a.dxf", &noise, Limits::default());
        let _ = read_str("a.dxf", &file(&format!("0 BLOCK 2 A {entities} 0 ENDBLK"), &format!("0 INSERT 2 A {entities}"), 4), Limits::default());
    }
}
