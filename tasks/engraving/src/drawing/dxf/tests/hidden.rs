//! What the drawing does not show is not engraved, and told.

use super::*;

/// A file whose LAYER table has `OFFL` off, `FROZ` frozen and `NOPLOT` not plotted.
fn with_layers(blocks: &str, entities: &str) -> Import {
    let layer = |name: &str, more: &str| format!("0 LAYER 2 {name} {more} ");
    let layers = layer("0", "70 0 62 7")
        + &layer("OFFL", "70 0 62 -7")
        + &layer("FROZ", "70 1 62 7")
        + &layer("NOPLOT", "70 0 62 7 290 0")
        + &layer("SHOWN", "70 4 62 3 290 1");
    let tables = format!("0 SECTION 2 TABLES 0 TABLE 2 LAYER 70 4 {layers} 0 ENDTAB 0 ENDSEC ");
    let text = format!(
        "0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC {tables} 0 SECTION 2 BLOCKS {blocks} 0 ENDSEC \
         0 SECTION 2 ENTITIES {entities} 0 ENDSEC 0 EOF"
    );
    let tags = text.split_whitespace().collect::<Vec<_>>().join("\n");
    read_str("a.dxf", &tags, Limits::default()).unwrap()
}

/// A line of this length on this layer, with more groups.
fn line(layer: &str, length: u32, more: &str) -> String {
    format!("0 LINE 8 {layer} {more} 10 0 20 {length} 11 {length} 21 {length} ")
}

#[test]
fn layers_that_are_off_frozen_or_not_plotted_are_left_out_and_told() {
    // The issue: 50 mm of each, of which one line is to be seen.
    let text = include_str!("files/d01_layers_off_frozen.dxf");
    let import = read_str("a.dxf", text, Limits::default()).unwrap();
    assert!(near(import.drawing.length(), 50.0), "{}", import.drawing.length());
    let told = import.warnings.join("\n");
    for part in [
        "1 entity, 50.0 mm long, on the layer OFFL, which is off",
        "1 entity, 50.0 mm long, on the layer FROZ, which is frozen",
        "1 entity, 50.0 mm long, on the layer NOPLOT, which is not plotted",
    ] {
        assert!(told.contains(part), "{told}");
    }
}

#[test]
fn entities_that_are_invisible_or_on_such_layers_are_counted_with_their_lengths() {
    let entities = line("SHOWN", 1, "")
        + &line("offl", 2, "")
        + &line("FROZ", 4, "")
        + &line("FROZ", 8, "")
        + &line("0", 16, "60 1")
        + &line("Defpoints", 32, "")
        + &line("UNKNOWN", 64, "");
    let import = with_layers("", &entities);
    assert!(near(import.drawing.length(), 65.0), "{}", import.drawing.length());
    let told = import.warnings.join("\n");
    for part in [
        "1 entity, 2.0 mm long, on the layer offl, which is off",
        "2 entities, 12.0 mm long, on the layer FROZ, which is frozen",
        "1 entity, 32.0 mm long, on the layer Defpoints, which is not plotted",
        "1 entity, 16.0 mm long, invisible",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
}

/// AutoCAD's help (About Layers in Blocks): what is on layer 0 of a block takes the layer of the insert; an insert on a
/// frozen layer shows nothing, one on a layer that is off shows what is on other layers.
#[test]
fn entities_of_blocks_are_shown_as_their_inserts_layers_say() {
    let blocks = format!(
        "0 BLOCK 2 A 10 0 20 0 {}{}{} 0 ENDBLK 0 BLOCK 2 B 10 0 20 0 0 INSERT 8 0 2 A 10 0 20 0 0 ENDBLK",
        line("0", 1, ""),
        line("SHOWN", 2, ""),
        line("OFFL", 4, "")
    );
    for (insert, length) in [
        ("8 0 2 A", 3.0),
        ("8 SHOWN 2 A", 3.0),
        ("8 OFFL 2 A", 2.0),
        ("8 NOPLOT 2 A", 2.0),
        ("8 NOPLOT 2 B", 2.0),
        ("8 SHOWN 2 B", 3.0),
    ] {
        let import = with_layers(&blocks, &format!("0 INSERT {insert} 10 0 20 0"));
        assert!(near(import.drawing.length(), length), "{insert}: {}", import.drawing.length());
    }
    for insert in ["8 FROZ 2 A", "8 FROZ 2 B", "8 0 60 1 2 A"] {
        let import = with_layers(&blocks, &format!("0 INSERT {insert} 10 0 20 0 {}", line("0", 9, "")));
        assert!(near(import.drawing.length(), 9.0), "{insert}: {}", import.drawing.length());
        assert!(import.warnings[0].starts_with("3 entities, 7.0 mm long,"), "{:?}", import.warnings);
    }
}

#[test]
fn hidden_entities_do_not_use_up_what_a_drawing_may_have() {
    let many = line("FROZ", 3, "").repeat(60_000);
    let import = with_layers("", &(many + &line("0", 9, "")));
    assert!(near(import.drawing.length(), 9.0));
    assert!(
        import.warnings[0].contains("at least") && import.warnings[0].contains("frozen"),
        "{:?}",
        import.warnings
    );
    // An array that is too large to be counted.
    let block = format!("0 BLOCK 2 A 10 0 20 0 {} 0 ENDBLK", line("0", 1, ""));
    let array = "0 INSERT 8 FROZ 2 A 10 0 20 0 70 30000 71 30000 ";
    let import = with_layers(&block, &format!("{array}{}", line("0", 9, "")));
    assert!(import.warnings[0].contains("more entities than are counted"), "{:?}", import.warnings);
    // Blocks of blocks that are hidden end as well.
    let mut blocks = format!("0 BLOCK 2 b0 {} 0 ENDBLK ", line("0", 1, ""));
    for k in 1..30 {
        let insert = format!("0 INSERT 2 b{} 10 0 20 0 ", k - 1);
        blocks += &format!("0 BLOCK 2 b{k} {insert}{insert} 0 ENDBLK ");
    }
    let import = with_layers(&blocks, &format!("0 INSERT 8 FROZ 2 b29 10 0 20 0 {}", line("0", 9, "")));
    assert!(near(import.drawing.length(), 9.0));
}
