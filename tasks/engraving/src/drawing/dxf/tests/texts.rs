//! Texts: where they stand, their letters, attributes.

use super::*;

fn bounds(entities: &str) -> crate::drawing::Bounds {
    import("", entities).drawing.bounds().unwrap()
}

fn file_of(text: &str) -> Import {
    read_str("a.dxf", text, Limits::default()).unwrap()
}

#[test]
fn texts_are_written_at_their_places() {
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    // H: its stems 4 and 18 units from the left edge of 22, in capitals of 21 units that are 42 high.
    let left = bounds("0 TEXT 10 10 20 5 40 42 1 H");
    assert!(
        near(left.min.x, 18.0) && near(left.max.x, 46.0) && near(left.min.y, 5.0) && near(left.max.y, 47.0)
    );
    let centred = bounds("0 TEXT 10 0 20 0 11 10 21 5 40 42 72 4 1 H");
    assert!(near(centred.centre().x, 10.0) && near(centred.centre().y, 5.0), "{centred:?}");
    let turned = bounds("0 TEXT 10 10 20 5 40 42 50 90 1 H");
    assert!(near(turned.max.x, 10.0) && near(turned.min.x, -32.0) && near(turned.min.y, 13.0), "{turned:?}");
    let fitted = bounds("0 TEXT 10 0 20 0 11 88 21 0 40 42 72 5 1 H");
    assert!(near(fitted.min.x, 16.0) && near(fitted.max.x, 72.0) && near(fitted.max.y, 42.0), "{fitted:?}");
    // The lower right corner of two lines: 1 + 5/3 capitals high, the second line on the baseline.
    let lines = bounds("0 MTEXT 10 10 20 5 40 42 71 9 1 H\\PH");
    assert!(
        near(lines.max.x, 10.0 - 8.0) && near(lines.min.y, 5.0) && near(lines.max.y, 5.0 + 42.0 * 8.0 / 3.0)
    );
    let told = import("", "0 TEXT 10 1 20 1 40 2 1 Hi").warnings;
    assert!(told.iter().any(|w| w.contains("a text is written in a single-stroke font")), "{told:?}");
}

#[test]
fn letters_that_the_font_lacks_are_left_out_and_named() {
    let import = import("", "0 TEXT 10 1 20 1 40 2 1 Ж1漢Ż 0 TEXT 10 1 20 9 40 2 1 漢");
    let told = import.warnings.join("\n");
    assert!(
        told.contains("letters left out of 2 texts") && told.contains("Ж (U+0416), 漢 (U+6F22)"),
        "{told}"
    );
    assert!(!told.contains('Ż') && import.drawing.length() > 2.0);
}

/// The groups behind 101 belong to the embedded object: the entity's own are those of the same MTEXT without it.
#[test]
fn an_embedded_object_changes_nothing_of_its_mtext() {
    let text = include_str!("files/d02b_mtext_embedded.dxf");
    let start = text.find("101\nEmbedded Object").unwrap();
    let end = start + text[start..].find("  0\nENDSEC").unwrap();
    let without = format!("{}{}", &text[..start], &text[end..]);
    let (with, without) = (file_of(text), file_of(&without));
    assert_eq!(with.drawing, without.drawing);
    // ezdxf: at (10, 30), 5 high, attached by its upper left corner, not turned. Round letters swell by a hundredth.
    let bounds = with.drawing.bounds().unwrap();
    assert!((bounds.max.y - 30.0).abs() < 0.1, "{bounds:?}");
}

#[test]
fn codes_and_blanks_of_texts_keep_their_letters() {
    // One letter with its stroke, then a 5: by ezdxf's plain text. Both texts have the same letters.
    let same = |text: &str, other: &str| {
        let of = |content: &str| {
            let text = file("", "0 TEXT 10 0 20 0 40 21 1 @", 4).replace('@', content);
            file_of(&text).drawing
        };
        assert_eq!(of(text), of(other), "{text}");
    };
    same("R\\U+00D85", "RØ5");
    same("%%c5%%%", "Ø5%");
    same("%%uA%%u", "A");
    assert!(file_of(include_str!("files/d04a_unicode.dxf")).warnings.iter().all(|w| !w.contains("left out")));
    let widest = |text: &str| file_of(text).drawing.bounds().unwrap().max.x;
    // `A\: B` is five letters: the stems of B are 7 units wide, after A (18), \ (14), : (10) and a blank (16).
    let colon = widest(include_str!("files/d05i_mtext.dxf"));
    let font = crate::drawing::hershey::Font::open("futural").unwrap();
    let width = font.width("A\\: B").unwrap() * 5.0;
    assert!(colon < width && colon > width - 5.0, "{colon} {width}");
    // The blank at the end of a chunk stands between its letters and those of the next.
    let chunks = file_of(include_str!("files/d05q_mtext_chunk.dxf"));
    let letters = format!("{} AB", "x".repeat(249));
    let expected = font.line(&letters).unwrap().iter().map(|s| s.bounds().max.x).fold(0.0, f64::max) * 0.1;
    assert!(near(chunks.drawing.bounds().unwrap().max.x, expected));
    // Blanks at the start shift what follows, by 16 units of 21 each.
    let at = |text: &str| file_of(text).drawing.bounds().unwrap().min.x;
    for kind in ["TEXT", "MTEXT"] {
        let plain = file("", &format!("0 {kind} 10 0 20 0 40 21 1 @"), 4);
        assert!(near(at(&plain.replace('@', "  H")) - at(&plain.replace('@', "H")), 32.0));
        // The last chunk is the one of group 1, wherever it stands.
        let two = file("", &format!("0 {kind} 10 0 20 0 40 21 1 B 3 A"), 4);
        if kind == "MTEXT" {
            assert_eq!(file_of(&two).drawing, file_of(&plain.replace('@', "AB")).drawing);
        }
    }
}

#[test]
fn attributes_stand_where_they_say_whatever_their_block_has() {
    // ezdxf: ATTRIB A17 at (15, 15), 5 high, with no ATTDEF in the block.
    let import = file_of(include_str!("files/d03b_attrib_nodef.dxf"));
    let lone = bounds("0 TEXT 10 15 20 15 40 5 1 A17");
    let letters: Vec<_> = import.drawing.strokes.iter().filter(|s| s.bounds().min.y > 14.9).collect();
    let found = letters.iter().map(|s| s.bounds()).reduce(|a, b| a.union(&b)).unwrap();
    assert!((found.min - lone.min).norm() < 1e-9 && (found.max - lone.max).norm() < 1e-9, "{found:?}");
}

#[test]
fn attributes_and_their_definitions() {
    let read = |blocks: &str, entities: &str| super::import(blocks, entities);
    let block = "0 BLOCK 2 A 10 0 20 0 0 LINE 10 0 20 0 11 9 21 0 0 ATTDEF 10 0 20 0 40 5 2 TAG 1 DEFAULT 70 0 0 ENDBLK";
    // The definition is not drawn inside an insert.
    assert!(near(read(block, "0 INSERT 2 A 10 0 20 0").drawing.length(), 9.0));
    // In an attribute group 74 aligns, 73 is the length of the field.
    let aligned = |groups: &str| {
        read(
            block,
            &format!(
                "0 INSERT 66 1 2 A 10 0 20 0 0 ATTRIB 2 T 10 0 20 0 11 50 21 30 40 21 1 H {groups} 0 SEQEND"
            ),
        )
    };
    let top = aligned("73 8 72 2 74 3").drawing.bounds().unwrap();
    assert!(near(top.max.y, 30.0) && near(top.max.x, 46.0), "{top:?}");
    let hidden = aligned("70 1");
    assert!(near(hidden.drawing.length(), 9.0));
    let told = hidden.warnings.join("\n");
    assert!(told.contains("1 entity, 56.0 mm long, attributes of blocks that are invisible"), "{told}");
    // A constant definition is its own attribute.
    let constant = block.replace("1 DEFAULT 70 0", "1 H 70 2");
    assert!(near(read(&constant, "0 INSERT 2 A 10 0 20 0").drawing.length(), 9.0 + 56.0 * 5.0 / 21.0));
    // An attribute of an insert in a block moves with it, and goes with a frozen insert.
    let nested = format!(
        "{block} 0 BLOCK 2 B 10 0 20 0 0 INSERT 66 1 2 A 10 0 20 0 0 ATTRIB 2 T 10 1 20 2 40 21 1 H 0 SEQEND 0 ENDBLK"
    );
    let bounds = read(&nested, "0 INSERT 2 B 10 100 20 50").drawing.bounds().unwrap();
    assert!(near(bounds.max.x, 119.0) && near(bounds.max.y, 73.0), "{bounds:?}");
    // Several lines: as the MTEXT within says.
    let lines = read(
        block,
        "0 INSERT 66 1 2 A 10 0 20 0 0 ATTRIB 2 T 10 0 20 0 40 5 1 H 101 Embedded_Object 10 10 20 60 40 21 71 1 1 H\\PH 0 SEQEND",
    );
    let bounds = lines.drawing.bounds().unwrap();
    assert!(near(bounds.max.y, 60.0) && near(bounds.max.x, 28.0), "{bounds:?}");
}
