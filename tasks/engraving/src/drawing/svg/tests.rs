//! SVG: shapes, units, what is refused, and that nothing panics.

mod seen;

use crate::drawing::{Drawing, Limits, Vec2, read_str};

fn drawn(body: &str) -> Drawing {
    let text = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='100mm' height='50mm' viewBox='0 0 100 50'>{body}</svg>"
    );
    read_str("a.svg", &text, Limits::default()).unwrap().drawing
}

fn refusal(text: &str) -> String {
    read_str("a.svg", text, Limits::default()).unwrap_err().to_string()
}

#[test]
fn a_circle_lies_where_it_is_drawn_with_y_up() {
    let bounds = drawn("<circle cx='10' cy='10' r='5'/>").bounds().unwrap();
    assert!((bounds.centre() - Vec2::new(10.0, 40.0)).norm() < 1e-9);
    assert!((bounds.size() - Vec2::new(10.0, 10.0)).norm() < 1e-9);
}

#[test]
fn ninety_six_px_are_an_inch() {
    let text =
        "<svg xmlns='http://www.w3.org/2000/svg' width='2in' height='96'><line x2='1in' y2='0'/></svg>";
    let drawing = read_str("a.svg", text, Limits::default()).unwrap().drawing;
    assert!((drawing.length() - 25.4).abs() < 1e-9);
}

#[test]
fn all_shapes_have_their_lengths() {
    let tau = std::f64::consts::TAU;
    assert!((drawn("<rect width='4' height='3'/>").length() - 14.0).abs() < 1e-9);
    assert!((drawn("<rect width='40' height='30' rx='5'/>").length() - (100.0 + 5.0 * tau)).abs() < 1e-9);
    assert!((drawn("<polygon points='0,0 3,0 3,4'/>").length() - 12.0).abs() < 1e-9);
    assert!((drawn("<polyline points='0,0 3,0 3,4'/>").length() - 7.0).abs() < 1e-9);
    assert!((drawn("<path d='M10 10 a5 5 0 1 1 0 10 z'/>").length() - (5.0 * tau / 2.0 + 10.0)).abs() < 1e-9);
    assert!((drawn("<path d='M0 0 q5 0 10 0 t 10 0'/>").length() - 20.0).abs() < 1e-9);
}

#[test]
fn transforms_and_uses_nest() {
    let body = "<defs><g id='a'><line x2='2' y2='0' transform='scale(3)'/></g></defs>\
                <g transform='rotate(90)'><use href='#a' x='1' transform='translate(0 -20)'/></g>";
    let bounds = drawn(body).bounds().unwrap();
    assert!((bounds.min - Vec2::new(20.0, 43.0)).norm() < 1e-9, "{bounds:?}");
    assert!((bounds.max - Vec2::new(20.0, 49.0)).norm() < 1e-9);
}

/// Sums of lengths by equation: `n` whole dashes and what is left of the last one.
#[test]
fn dashed_outlines_are_cut_as_their_dashes() {
    let dashed = |style: &str| {
        let drawing = drawn(&format!("<line x2='50' y1='9' y2='9' {style}/>"));
        (drawing.strokes.len(), drawing.length())
    };
    let near = |(n, length): (usize, f64), (m, expected): (usize, f64)| {
        assert!(n == m && (length - expected).abs() < 1e-9, "{n} {length}, {m} {expected}");
    };
    // Dashes at 0, 14, 28 and 42: three of 10, and 8 of the last one.
    near(dashed("stroke-dasharray='10 4'"), (4, 38.0));
    near(dashed("style='stroke:black;stroke-dasharray: 10, 4'"), (4, 38.0));
    // An odd list is doubled: 5 on, 3 off, 7 on, 5 off, 3 on, 7 off: two periods of 30 would be 60.
    near(dashed("stroke-dasharray='5,3,7'"), (5, 15.0 + 5.0 + 7.0));
    // It begins 12 into the pattern: a gap of 2, then 10 and 4.
    near(dashed("stroke-dasharray='10 4' stroke-dashoffset='12'"), (4, 10.0 + 10.0 + 10.0 + 6.0));
    near(dashed("stroke-dasharray='10 4' stroke-dashoffset='-2'"), (4, 10.0 + 10.0 + 10.0 + 6.0));
    // Of the viewport, 100 by 50: its diagonal by the root of 2 is 79.06.
    let percent = (12_500.0_f64 / 2.0).sqrt() / 100.0;
    near(dashed("stroke-dasharray='20% 10'"), (2, 40.0 * percent));
    // An inch is 96 px, which are the view box's units.
    near(dashed("stroke-dasharray='0.125in 0.25in'"), (2, 12.0 + 12.0));
    // What the author takes for its length counts: 100 for 50.
    near(dashed("pathLength='100' stroke-dasharray='20 8'"), (4, 38.0));
    for whole in ["none", "0 0", "0"] {
        near(dashed(&format!("stroke-dasharray='{whole}'")), (1, 50.0));
    }
    near(dashed("stroke='none' fill='red' stroke-dasharray='10 4'"), (1, 50.0));
    near(dashed("pathLength='0' stroke-dasharray='10 4'"), (1, 50.0));
}

#[test]
fn dashes_begin_anew_with_each_subpath_are_inherited_and_scaled_with_what_they_draw() {
    // Each of 10: a dash of 8.
    let drawing = drawn("<path stroke-dasharray='8 6' d='M0 0h10M0 5h10M0 9h10'/>");
    assert!((drawing.length() - 24.0).abs() < 1e-9 && drawing.strokes.len() == 3);
    // By twice in x: dashes of 16 and gaps of 12 on 60.
    let body = "<g stroke-dasharray='8 6' transform='scale(2 1)'><line x2='30'/>\
                <line x2='30' y1='9' y2='9' stroke-dasharray='none'/></g>";
    let lengths: Vec<_> = drawn(body).strokes.iter().map(|stroke| stroke.length()).collect();
    assert!(lengths.iter().zip([16.0, 16.0, 4.0, 60.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{lengths:?}");
    // A circle is one outline of 2 pi r from three o'clock: dashes of a quarter and gaps of a twelfth are three.
    let tau = std::f64::consts::TAU;
    let circle =
        format!("<circle cx='20' cy='20' r='10' stroke-dasharray='{} {}'/>", 2.5 * tau, 2.5 * tau / 3.0);
    let drawing = drawn(&circle);
    assert!((drawing.length() - 7.5 * tau).abs() < 1e-9 && drawing.strokes.len() == 3);
    assert!((drawing.strokes[0].start() - Vec2::new(30.0, 30.0)).norm() < 1e-9);
}

#[test]
fn dashes_that_say_nothing_and_dashes_without_number_are_refused_and_dots_are_told() {
    let svg = |inside: &str| {
        format!("<svg xmlns='http://www.w3.org/2000/svg' width='100' height='100'>\n{inside}</svg>")
    };
    for (list, why) in [("4 -1", "negative"), ("4 x", "stroke-dasharray"), ("", "no length")] {
        let message = refusal(&svg(&format!("<line x2='9' stroke-dasharray='{list}'/>")));
        assert!(message.starts_with("a.svg:2:") && message.contains(why), "{message}");
    }
    let message = refusal(&svg("<line x2='9' stroke-dashoffset='far'/>"));
    assert!(message.contains("bad stroke-dashoffset"), "{message}");
    let message = refusal(&svg("<line x2='90000' stroke-dasharray='0.0001'/>"));
    assert!(message.contains("more than 250000 curve pieces"), "{message}");
    let dots = svg("<line x2='90' stroke-linecap='round' stroke-dasharray='0 5 5 5'/>");
    let told = read_str("a.svg", &dots, Limits::default()).unwrap().warnings;
    assert_eq!(told, ["a.svg:2:1: the dots of a dashed line are not engraved: draw them as small circles"]);
}

#[test]
fn hidden_things_are_not_engraved() {
    let body = "<g style='display:none'><line x2='9'/></g><g visibility='hidden'><line x2='9'/>\
                <line x2='3' visibility='visible'/></g><clipPath><rect width='9' height='9'/></clipPath>";
    assert!((drawn(body).length() - 3.0).abs() < 1e-9);
}

#[test]
fn text_is_written_at_its_place_in_its_size() {
    // Capitals are 0.7 of the size: 7 px of 25.4/96 mm. The baseline is at y = 20 of 100 px.
    let text = |inside: &str| {
        let head = "<svg xmlns='http://www.w3.org/2000/svg' width='100' height='100'>";
        read_str("a.svg", &format!("{head}{inside}</svg>"), Limits::default()).unwrap()
    };
    let px = 25.4 / 96.0;
    let import = text("<g style='font-size:10px'><text x='30' y='20'>H</text></g>");
    assert!(import.warnings.iter().any(|w| w.contains("single-stroke")), "{:?}", import.warnings);
    let bounds = import.drawing.bounds().unwrap();
    assert!(
        (bounds.min.y - 80.0 * px).abs() < 1e-9 && (bounds.size().y - 7.0 * px).abs() < 1e-9,
        "{bounds:?}"
    );
    // H: 4 units from its left edge to the stem, 22 in all, 21 a capital.
    let unit = 7.0 / 21.0;
    assert!((bounds.min.x - (30.0 + 4.0 * unit) * px).abs() < 1e-9, "{bounds:?}");
    let moved = |inside: &str| text(inside).drawing.bounds().unwrap().min.x / px;
    let middle = moved("<text x='30' y='20' font-size='10' text-anchor='middle'>H</text>");
    assert!((middle - (30.0 - 11.0 * unit + 4.0 * unit)).abs() < 1e-9);
    let end = moved("<text x='30' y='20' font-size='10' style='text-anchor:end'><tspan>H</tspan></text>");
    assert!((end - (30.0 - 22.0 * unit + 4.0 * unit)).abs() < 1e-9);
    // A tspan goes on behind the letters before it, or at a place of its own; blanks in a row are one.
    let spans = |inside: &str| text(inside).drawing.strokes.len();
    let one = spans("<text font-size='10'>HH</text>");
    assert_eq!(
        spans("<text font-size='10'> H<tspan dx='3'>\n  </tspan><tspan x='50' y='9'>H</tspan></text>"),
        one
    );
    assert_eq!(spans("<text font-size='10'>H<tspan display='none'>x</tspan>H</text>"), one);
    let refused = refusal("<svg xmlns='http://www.w3.org/2000/svg'>\n<text x='3'>漢</text></svg>");
    assert!(
        refused.contains("a.svg:2:1: text with '漢'") && refused.contains("nothing to engrave"),
        "{refused}"
    );
    let told = text("<text y='9'>漢</text><text y='9'>e</text>").warnings.join("\n");
    assert!(told.contains("text with '漢', which no font here has, left out"), "{told}");
    let told = text("<text y='9' rotate='30'>H<textPath>on</textPath></text>").warnings.join("\n");
    assert!(told.contains("rotate left out") && told.contains("text along a path left out"), "{told}");
}

#[test]
fn images_are_told_of_once_after_whatever_was_told_before() {
    let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='100' height='100'><text y='9'>漢</text>\n\
               <image width='9' height='9'/>\n<image width='9' height='9'/><rect width='9' height='9'/></svg>";
    let told = read_str("a.svg", svg, Limits::default()).unwrap().warnings;
    let images: Vec<_> = told.iter().filter(|told| told.contains("images are not engraved")).collect();
    assert!(told[0].contains("text with '漢'"), "{told:?}");
    assert_eq!(images, ["a.svg:2:1: images are not engraved: trace them to paths first"]);
}

#[test]
fn bad_path_data_is_pointed_at() {
    let message = refusal("<svg xmlns='http://www.w3.org/2000/svg'>\n<path d='M 1 2 L 3 zap'/></svg>");
    assert!(
        message.contains("a.svg:2:") && message.contains("<path> has a bad d") && message.contains('^'),
        "{message}"
    );
}

#[test]
fn a_shape_of_a_negative_size_is_refused_and_not_drawn_as_another() {
    for shape in ["<circle r='-5'/>", "<ellipse rx='4' ry='-5'/>", "<rect width='-4' height='3'/>"] {
        let message = refusal(&format!("<svg xmlns='http://www.w3.org/2000/svg'>{shape}</svg>"));
        assert!(message.contains("it is negative") && message.contains('^'), "{message}");
    }
    // One without a size is not drawn.
    assert!((drawn("<rect width='0' height='3'/><line x2='3'/>").length() - 3.0).abs() < 1e-9);
}

#[test]
fn a_truncated_file_says_so() {
    let message = refusal("<svg xmlns='http://www.w3.org/2000/svg'><g><path d='M 1 2");
    assert!(message.contains("ends inside an element") && message.contains("cut short"), "{message}");
}

#[test]
fn entities_are_refused() {
    let bomb = "<!DOCTYPE svg [<!ENTITY a 'lol'><!ENTITY b '&a;&a;&a;&a;'>]><svg>&b;</svg>";
    assert!(refusal(bomb).contains("entities are not read"));
}

#[test]
fn a_use_of_itself_ends_with_an_error() {
    let message = refusal("<svg xmlns='http://www.w3.org/2000/svg'><g id='a'><use href='#a'/></g></svg>");
    assert!(message.contains("nested more than 64 deep") && message.contains("contains itself"), "{message}");
}

#[test]
fn a_bomb_of_uses_is_refused() {
    let mut body = "<line id='a0' x2='1'/>".to_owned();
    for i in 1..30 {
        body += &format!("<g id='a{i}'>{}</g>", format!("<use href='#a{}'/>", i - 1).repeat(10));
    }
    let message = refusal(&format!("<svg xmlns='http://www.w3.org/2000/svg'>{body}</svg>"));
    assert!(message.contains("more than 100000 curve pieces"), "{message}");
}

#[test]
fn very_deep_nesting_is_refused() {
    let deep = format!("<svg xmlns='http://www.w3.org/2000/svg'>{}", "<g>".repeat(1_000_000));
    assert!(refusal(&deep).contains("nested more than"));
}

#[test]
fn fault_76_attributes_and_namespaces_without_measure_are_refused() {
    let attributes: String = (0..60_000).map(|i| format!(" a{i}=''")).collect();
    let message = refusal(&format!("<svg>\n<g{attributes}><path d='M0 0h1'/></g></svg>"));
    assert!(message.starts_with("a.svg:2: more than 128 attributes of an element\n help: "), "{message}");
    // Within the depth that is allowed: in two of the levels, most of what there may be of attributes.
    let declared = |from: usize| (from..from + 100).map(|i| format!(" xmlns:n{i}='u'")).collect::<String>();
    let message = refusal(&format!("<svg{}>\n<g{}><path d='M0 0h1'/></g></svg>", declared(0), declared(100)));
    let told = "a.svg:1: more than 32 declarations of namespaces within one another\n help: ";
    assert!(message.starts_with(told), "{message}");
    // What drawing programs write is read: a dozen namespaces, and again in what was copied from elsewhere.
    let declared = |n: usize| (0..n).map(|i| format!(" xmlns:n{i}='u{i}'")).collect::<String>();
    let copied = format!("<g{} n1:a='b'><path d='M0 0h1'/></g>", declared(12));
    assert!((drawn(&copied.repeat(100)).length() - 100.0).abs() < 1e-9);
}

#[test]
fn a_path_of_too_many_pieces_is_refused_and_never_cut_short() {
    for step in [" L1 1", " M0 0 L1 1"] {
        let data = step.repeat(250_001);
        let message =
            refusal(&format!("<svg xmlns='http://www.w3.org/2000/svg'><path d='M0 0{data}'/></svg>"));
        assert!(message.contains("more than 250000 curve pieces"), "{message}");
    }
}

#[test]
fn an_empty_drawing_says_what_to_check() {
    assert!(refusal("<svg xmlns='http://www.w3.org/2000/svg'/>").contains("hidden layers"));
    assert!(refusal("<html/>").contains("not <svg>"));
}

#[test]
fn numbers_beyond_any_plate_are_refused() {
    let message = refusal("<svg xmlns='http://www.w3.org/2000/svg'><line x2='1e300'/></svg>");
    assert!(message.contains("below 10 000 000 mm"), "{message}");
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig { failure_persistence: None, ..proptest::prelude::ProptestConfig::with_cases(1000) })]

    #[test]
    fn no_document_panics(body in "[ -~\n]{0,120}", d in "[MmLlHhVvCcSsQqTtAaZz0-9eE., +-]{0,60}", t in "[a-zX0-9(), .-]{0,30}") {
        let _ = read_str("a.svg", &body, Limits::default());
        let _ = read_str("a.svg", &format!("<svg>{body}</svg>"), Limits::default());
        let _ = read_str("a.svg", &format!("<svg viewBox='{d}'><path d='{d}'/><g transform='{t}'><path d='M0 0 {d}'/><rect width='{d}'/></g></svg>"), Limits::default());
    }
}
