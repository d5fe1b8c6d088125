//! A page that is drawn by hand is one well-formed document, whatever it is given.

use mrroc_pictures::svg::{Area, Axes, Look, Page, Range, TextStyle, palette};
use nalgebra::Vector2;
use roxmltree::{Document, Node};

fn elements<'a>(document: &'a Document<'a>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    document.descendants().filter(move |node| node.has_tag_name(tag))
}

#[test]
fn text_of_anyone_is_text_and_nothing_else() {
    for text in ["</text><script/>", "\" onload=\"x", "&amp; & ]]>", "a\u{0}b\u{7f}\n", "\u{ffff} żółw", ""]
    {
        let page = Page::new(text, 100.0, 50.0).draw(|svg| {
            svg.text(Vector2::new(1.0, 10.0), TextStyle::new(9.0, palette::INK), text);
            svg.text_on_lines(
                Vector2::new(1.0, 20.0),
                TextStyle::new(9.0, palette::INK),
                palette::WHITE,
                text,
            );
        });
        let document = Document::parse(&page).unwrap();
        let title = elements(&document, "title").next().unwrap();
        let read = title.text().unwrap_or_default();
        assert_eq!(read.chars().count(), text.chars().count(), "{text:?}");
        assert_eq!(elements(&document, "text").filter(|node| node.text() == title.text()).count(), 3);
        assert_eq!(elements(&document, "script").count(), 0);
    }
}

#[test]
fn what_is_no_number_is_drawn_somewhere_and_the_document_stays_one() {
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -0.0];
    let page = Page::new("odd", 100.0, 50.0).draw(|svg| {
        for value in odd {
            let point = Vector2::new(value, value);
            svg.circle(point, value, Look::line(palette::INK, value).opacity(value));
            svg.polyline(&[point, point], Look::new().dashed(value, value));
            svg.rectangle(Area { x: value, y: 0.0, width: 1.0, height: value }, value, Look::new());
        }
        let frame = Area { x: 10.0, y: 10.0, width: 80.0, height: 30.0 };
        let axes = Axes::new(frame, Range::of(&[f64::NAN]), Range::with_zero(&odd[..1], 0.0));
        axes.draw_grid(svg);
        axes.draw_labels_below(svg);
        svg.polyline(&axes.curve(&[0.0, 1.0], &odd), Look::line(palette::INK, 1.0));
    });
    let document = Document::parse(&page).unwrap();
    for node in document.root_element().descendants().filter(Node::is_element) {
        for attribute in node.attributes() {
            let value = attribute.value();
            assert!(!value.contains("NaN") && !value.contains("inf"), "{}: {value}", attribute.name());
        }
    }
}

/// The page of 100 px and a plot of the line from (0, 0) to (4, 2): its ends are the corners of the frame.
#[test]
fn a_curve_is_drawn_where_the_axes_say() {
    let page = Page::new("a line", 100.0, 100.0).draw(|svg| {
        let frame = Area { x: 20.0, y: 10.0, width: 70.0, height: 80.0 };
        let across = [0.0, 1.0, 4.0];
        let up = [0.0, 0.5, 2.0];
        let axes = Axes::new(frame, Range::of(&across), Range::with_zero(&up, 0.0));
        svg.polyline(&axes.curve(&across, &up), Look::line(palette::joint(0), 1.5));
    });
    let document = Document::parse(&page).unwrap();
    let line = elements(&document, "polyline").next().unwrap();
    assert_eq!(line.attribute("points"), Some("20,90 90,10"));
    assert_eq!((line.attribute("stroke"), line.attribute("fill")), (Some("#0072b2"), Some("none")));
}
