//! What of a drawing is seen, and where: `use`, `switch`, styles, transforms, viewports and clips. Expected values are
//! computed by hand from the SVG 2 and CSS Transforms specifications.

use crate::drawing::{Import, Limits, Vec2, read_str};

const HEAD: &str = "<svg xmlns='http://www.w3.org/2000/svg' xmlns:xlink='http://www.w3.org/1999/xlink'";

fn import(body: &str) -> Import {
    let text = format!("{HEAD} width='100mm' height='50mm' viewBox='0 0 100 50'>{body}</svg>");
    read_str("a.svg", &text, Limits::default()).unwrap()
}

/// Start and end of each stroke \[mm\], y down from the top of a page of 50 mm.
fn ends(import: &Import) -> Vec<[f64; 4]> {
    let strokes = import.drawing.strokes.iter();
    strokes.map(|s| [s.start().x, 50.0 - s.start().y, s.end().x, 50.0 - s.end().y]).collect()
}

fn drawn_at(body: &str, expected: &[[f64; 4]]) {
    let drawn = ends(&import(body));
    assert_eq!(drawn.len(), expected.len(), "{body}: {drawn:?}");
    for (a, b) in drawn.iter().flatten().zip(expected.iter().flatten()) {
        assert!((a - b).abs() < 1e-6, "{body}: {drawn:?}, not {expected:?}");
    }
}

#[test]
fn a_use_gives_its_size_to_a_symbol_and_to_a_drawing_in_the_drawing() {
    // Scales of 12 / 24 and 24 / 24.
    let icon = "<symbol id='i' viewBox='0 0 24 24'><path d='M2 12H22'/></symbol>\
                <use href='#i' x='10' y='10' width='12' height='12'/>\
                <use xlink:href='#i' x='40' y='10' width='24' height='24'/>";
    drawn_at(icon, &[[11.0, 16.0, 21.0, 16.0], [42.0, 22.0, 62.0, 22.0]]);
    // The use's size stands for its own: 40 / 10.
    let nested = "<defs><svg id='n' viewBox='0 0 10 10' width='20' height='20'><path d='M0 0H10'/></svg></defs>\
                  <use href='#n' x='10' y='10' width='40' height='40'/>";
    drawn_at(nested, &[[10.0, 10.0, 50.0, 10.0]]);
    let own = "<defs><svg id='n' viewBox='0 0 10 10' width='20' height='20'><path d='M0 0H10'/></svg></defs>\
               <use href='#n' x='10' y='10'/>";
    drawn_at(own, &[[10.0, 10.0, 30.0, 10.0]]);
    // 256 of 512 px: 64 px of the view box are 256.
    let text = format!(
        "{HEAD} width='512' height='512'><defs><symbol id='t' viewBox='0 0 64 64'><rect width='64' height='64'/>\
         </symbol></defs><use width='256' height='256' href='#t'/></svg>"
    );
    let size = read_str("a.svg", &text, Limits::default()).unwrap().drawing.bounds().unwrap().size();
    assert!((size - Vec2::new(256.0, 256.0) * 25.4 / 96.0).norm() < 1e-6, "{size:?}");
}

#[test]
fn a_circle_in_percent_of_a_symbol_is_a_circle_and_not_cubics() {
    // The viewport is the view box, 10 by 10, 20 mm wide on the page: the radius is 2 of 10.
    let import = import(
        "<symbol id='s' viewBox='0 0 10 10'><circle cx='50%' cy='50%' r='20%'/></symbol>\
         <use href='#s' x='10' y='10' width='20' height='20'/>",
    );
    let [stroke] = import.drawing.strokes.as_slice() else { panic!("{:?}", import.drawing) };
    for k in 0..=100 {
        let p = stroke.pieces()[0].point(f64::from(k) / 100.0);
        assert!(((p - Vec2::new(20.0, 30.0)).norm() - 4.0).abs() < 1e-5);
    }
}

#[test]
fn of_a_switch_the_first_that_can_be_shown_is_drawn() {
    let illustrator = "<switch><foreignObject requiredExtensions='http://ns.adobe.com/AdobeIllustrator/10.0/' \
                       width='1' height='1'/><g><path d='M10 10H60'/></g></switch>";
    drawn_at(illustrator, &[[10.0, 10.0, 60.0, 10.0]]);
    let languages = "<switch><path systemLanguage='de' d='M0 1H9'/><path systemLanguage='en' d='M0 2H9'/>\
                     <path d='M0 3H9'/></switch>";
    drawn_at(languages, &[[0.0, 2.0, 9.0, 2.0]]);
    let drawio = "<switch><foreignObject width='100%' height='100%' \
                  requiredFeatures='http://www.w3.org/TR/SVG11/feature#Extensibility'/>\
                  <text x='20' y='30' font-size='10'>Part 7</text></switch>";
    assert_eq!(
        import(drawio).drawing.strokes,
        import("<text x='20' y='30' font-size='10'>Part 7</text>").drawing.strokes
    );
}

#[test]
fn transforms_are_about_their_origin_and_have_units_in_styles() {
    let turned = [[30.0, 20.0, 30.0, 40.0]];
    drawn_at("<path transform='rotate(90)' transform-origin='30 20' d='M30 20H50'/>", &turned);
    drawn_at("<path style='transform:rotate(90deg);transform-origin:30px 20px' d='M30 20H50'/>", &turned);
    drawn_at(
        "<style>.a{Transform : Rotate(.25TURN);transform-origin:30px 20px}</style><path class='a' d='M30 20H50'/>",
        &turned,
    );
    let moved = [[10.0, 5.0, 12.0, 5.0]];
    drawn_at("<g style='transform: translate(10px, 5px)'><path d='M0 0H2'/></g>", &moved);
    drawn_at(
        "<g style='transform: translateX(10px) translateY(5px) scaleX(2)'><path d='M0 0H1'/></g>",
        &moved,
    );
    // A style wins over an attribute.
    drawn_at("<g transform='scale(9)' style='transform:translate(10px,5px)'><path d='M0 0H2'/></g>", &moved);
}

#[test]
fn a_transform_of_the_root_moves_the_page_in_px() {
    let text = format!(
        "{HEAD} width='100mm' height='50mm' viewBox='0 0 100 50' transform='translate(10 5)'><path d='M0 0H20'/></svg>"
    );
    let drawing = read_str("a.svg", &text, Limits::default()).unwrap().drawing;
    let px = 25.4 / 96.0;
    assert!((drawing.strokes[0].start() - Vec2::new(10.0 * px, 50.0 - 5.0 * px)).norm() < 1e-6);
}

#[test]
fn style_sheets_are_applied() {
    let sheet = "<style>.st0{display:none}.st1{fill:none;stroke:#000}</style>\
                 <g class='st0'><path d='M1 1H90'/></g><path class='st1' d='M10 10H60'/>";
    drawn_at(sheet, &[[10.0, 10.0, 60.0, 10.0]]);
    let in_print = "<style><![CDATA[/* no */ @media print { path {display:none} } g > .x {visibility:hidden}]]></style>\
                    <g><path class='x' d='M1 1H90'/></g><path d='M10 10H60'/>";
    drawn_at(in_print, &[[10.0, 10.0, 60.0, 10.0]]);
    let dashed = "<style>.d{stroke:#000;stroke-dasharray:10 5}</style><path class='d' d='M0 1H20'/>";
    drawn_at(dashed, &[[0.0, 1.0, 10.0, 1.0], [15.0, 1.0, 20.0, 1.0]]);
    // Capitals of 0.7 x 20, anchored at their end.
    let text =
        import("<style>.a{font-size:20px;text-anchor:end}</style><text class='a' x='80' y='30'>H</text>");
    let attributes = import("<text font-size='20' text-anchor='end' x='80' y='30'>H</text>");
    assert_eq!(text.drawing, attributes.drawing);
    assert!((text.drawing.bounds().unwrap().size().y - 14.0).abs() < 1e-6);
}

#[test]
fn outlines_that_nobody_sees_are_not_engraved() {
    for unseen in [
        "fill='none'",
        "fill='none' stroke='none'",
        "fill='none' stroke='#000' stroke-width='0'",
        "fill='none' stroke='#000' stroke-opacity='0'",
        "fill='transparent'",
        "fill-opacity='0'",
        "opacity='0'",
        "display='none'",
        "visibility='hidden'",
        "style='/* hidden: */ display : none'",
        "style='DISPLAY:none'",
        "style='display:none !important;display:inline'",
        "style='opacity:0%'",
    ] {
        drawn_at(&format!("<path {unseen} d='M1 1H90'/><path d='M10 10H60'/>"), &[[10.0, 10.0, 60.0, 10.0]]);
    }
    drawn_at("<g opacity='0'><path d='M1 1H90'/></g><path d='M10 10H60'/>", &[[10.0, 10.0, 60.0, 10.0]]);
    let text = "<text y='20' fill='none'>H</text><path d='M10 10H60'/>";
    drawn_at(text, &[[10.0, 10.0, 60.0, 10.0]]);
}

#[test]
fn a_document_type_without_entities_is_passed_over() {
    let kept = |declared: &str| {
        let text =
            format!("<?xml version='1.0'?><!-- by hand -->\n{declared}\n{HEAD}>\n<path d='zap'/></svg>");
        read_str("a.svg", &text, Limits::default()).unwrap_err().to_string()
    };
    let public =
        "<!DOCTYPE svg PUBLIC '-//W3C//DTD SVG 1.1//EN' 'http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd'>";
    // Lines and columns count as before.
    for declared in [public, "<!DOCTYPE svg [ <!ATTLIST svg x CDATA '>'> ]>"] {
        assert!(kept(declared).starts_with("a.svg:4:10: <path> has a bad d"), "{}", kept(declared));
    }
    let entities = kept("<!DOCTYPE svg [\n<!ENTITY a 'b'>]>");
    assert!(entities.starts_with("a.svg:3:1: ") && entities.contains("entities are not read"), "{entities}");
}

#[test]
fn an_em_is_the_size_of_the_font() {
    let text = format!(
        "{HEAD} width='10em' height='5em' font-size='20'><path d='M0 0H100'/><line y1='10' x2='5em' y2='10'/></svg>"
    );
    let drawing = read_str("a.svg", &text, Limits::default()).unwrap().drawing;
    let px = 25.4 / 96.0;
    // The page is 100 px high; 5 em are 100 px.
    assert!((drawing.strokes[0].start() - Vec2::new(0.0, 100.0 * px)).norm() < 1e-6);
    assert!((drawing.strokes[1].length() - 100.0 * px).abs() < 1e-6);
}

#[test]
fn elements_of_other_namespaces_are_not_drawn() {
    let others = "<i:path xmlns:i='http://www.inkscape.org/namespaces/inkscape' d='M1 1H90'/>\
                  <b:rect xmlns:b='http://example.org/b' width='5' height='5'/><path d='M10 10H60'/>";
    drawn_at(others, &[[10.0, 10.0, 60.0, 10.0]]);
    // A prefix for SVG's own namespace is none for others.
    let prefixed = "<s:svg xmlns:s='http://www.w3.org/2000/svg' width='100mm' height='50mm' viewBox='0 0 100 50'>\
                    <s:text y='20' font-size='10'>H</s:text><s:path d='M10 10H60'/></s:svg>";
    let import = read_str("a.svg", prefixed, Limits::default()).unwrap();
    assert!(import.drawing.strokes.len() > 1, "{:?}", import.drawing);
}

#[test]
fn what_is_clipped_masked_or_filled_with_a_pattern_is_told() {
    let told = |body: &str| import(body).warnings.join("\n");
    let clip = "<clipPath id='c'><rect width='50' height='50'/></clipPath><g clip-path='url(#c)'><path d='M10 25H90'/></g>";
    assert!(told(clip).contains("clip path and engraved whole"), "{}", told(clip));
    let within = clip.replace("H90", "H40");
    assert!(told(&within).is_empty(), "{}", told(&within));
    let mask =
        "<mask id='m'><rect width='50' height='50' fill='#fff'/></mask><path mask='url(#m)' d='M10 25H90'/>";
    assert!(told(mask).contains("masks are not applied"));
    let filter = "<filter id='f'><feGaussianBlur/></filter><path filter='url(#f)' d='M10 25H90'/>";
    assert!(told(filter).contains("filters are not applied"));
    let pattern = "<pattern id='p' width='4' height='4'><circle r='1'/></pattern><rect width='9' height='9' fill='url(#p)'/>";
    assert!(told(pattern).contains("patterns are not engraved"));
    assert!(told("<path d='M90 25H110'/>").contains("partly outside of the page"));
    // A nested viewport hides what lies outside of it.
    let nested = "<svg width='10' height='10'><path d='M20 20H30'/></svg><path d='M10 10H60'/>";
    drawn_at(nested, &[[10.0, 10.0, 60.0, 10.0]]);
    assert!(told(nested).contains("outside of a viewport or clip path and left out"));
}

#[test]
fn markers_are_drawn_where_they_stand() {
    // In units of the stroke's width, 2, and turned with the line's end.
    let marked = "<marker id='m' markerWidth='4' markerHeight='4' orient='auto' overflow='visible'>\
                  <path d='M0 -1V1'/></marker>\
                  <path d='M10 10V40' fill='none' stroke='#000' stroke-width='2' marker-end='url(#m)'/>";
    drawn_at(marked, &[[10.0, 10.0, 10.0, 40.0], [12.0, 40.0, 8.0, 40.0]]);
}

#[test]
fn rules_and_markers_without_measure_are_refused() {
    let refusal = |body: String| {
        read_str("a.svg", &format!("{HEAD}>{body}</svg>"), Limits::default()).unwrap_err().to_string()
    };
    let rules = ".a{fill:none}".repeat(6_000);
    assert!(refusal(format!("<style>{rules}</style><path d='M0 0h1'/>")).contains("rules of style sheets"));
    let inside = "<path d='M0 0h1'/>".repeat(100);
    let marks = format!(
        "<marker id='m'>{inside}</marker><path stroke='#000' marker-mid='url(#m)' d='M0 0{}'/>",
        "h1".repeat(1_000)
    );
    assert!(refusal(marks).contains("more than 100000"));
}
