//! SVG: shapes, units, what is refused, and that nothing panics.

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
    let refused = refusal("<svg xmlns='http://www.w3.org/2000/svg'>\n<text x='3'>Żółć</text></svg>");
    assert!(
        refused.contains("a.svg:2:1: text with 'Ż'") && refused.contains("nothing to engrave"),
        "{refused}"
    );
    let told = text("<text y='9'>é</text><text y='9'>e</text>").warnings.join("\n");
    assert!(told.contains("text with 'é', which no font here has, left out"), "{told}");
    let told = text("<text y='9' rotate='30'>H<textPath>on</textPath></text>").warnings.join("\n");
    assert!(told.contains("rotate left out") && told.contains("text along a path left out"), "{told}");
}

#[test]
fn images_are_told_of_once_after_whatever_was_told_before() {
    let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='100' height='100'><text y='9'>é</text>\n\
               <image width='9' height='9'/>\n<image width='9' height='9'/><rect width='9' height='9'/></svg>";
    let told = read_str("a.svg", svg, Limits::default()).unwrap().warnings;
    let images: Vec<_> = told.iter().filter(|told| told.contains("images are not engraved")).collect();
    assert!(told[0].contains("text with 'é'"), "{told:?}");
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
