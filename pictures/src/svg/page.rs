//! The document: a page of a size, with a title.

use std::fmt::Write as _;

use super::colour::Colour;
use super::number::Number;
use super::palette::WHITE;
use super::text::Escaped;
use super::writer::Svg;

/// The fonts of all text, the first that the viewer has: without serifs, and with digits of one width where it can.
const FONTS: &str = "Inter, 'Segoe UI', 'Helvetica Neue', Arial, 'DejaVu Sans', sans-serif";

/// An SVG document that is about to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct Page<'a> {
    title: &'a str,
    width: f64,
    height: f64,
    unit: Unit,
    ground: Colour,
    style: &'static str,
}

#[derive(Clone, Copy, Debug)]
enum Unit {
    Pixels,
    Millimetres,
}

impl Unit {
    /// What is written after a size.
    fn suffix(self) -> &'static str {
        match self {
            Unit::Pixels => "",
            Unit::Millimetres => "mm",
        }
    }

    /// Digits after the point that nobody sees more of.
    fn digits(self) -> u32 {
        match self {
            Unit::Pixels => 1,
            Unit::Millimetres => 3,
        }
    }
}

impl<'a> Page<'a> {
    /// A white page of this width and height \[px\], > 0. A browser shows the title as the picture's name.
    #[must_use]
    pub fn new(title: &'a str, width: f64, height: f64) -> Page<'a> {
        Page { title, width, height, unit: Unit::Pixels, ground: WHITE, style: "" }
    }

    /// The same in mm: all places and sizes are then in mm, written to a thousandth, where pixels are to a tenth.
    #[must_use]
    pub fn in_millimetres(self) -> Page<'a> {
        Page { unit: Unit::Millimetres, ..self }
    }

    /// The same with a ground of another colour.
    #[must_use]
    pub fn ground(self, ground: Colour) -> Page<'a> {
        Page { ground, ..self }
    }

    /// The same with rules of a style sheet, of this crate's making.
    pub(crate) fn style(self, style: &'static str) -> Page<'a> {
        Page { style, ..self }
    }

    /// The document, with what `content` draws on it.
    #[must_use]
    pub fn draw(self, content: impl FnOnce(&mut Svg)) -> String {
        let digits = self.unit.digits();
        let unit = self.unit.suffix();
        let width = Number { value: self.width, digits };
        let height = Number { value: self.height, digits };
        let mut svg = Svg::new(digits);
        let attributes = format_args!(
            " xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}{unit}\" height=\"{height}{unit}\" viewBox=\"0 0 {width} {height}\" font-family=\"{FONTS}\""
        );
        svg.containing("svg", attributes, |svg| {
            // Writing to a String cannot fail.
            let _ = writeln!(svg.text, "<title>{}</title>", Escaped(self.title));
            if !self.style.is_empty() {
                let _ = writeln!(svg.text, "<style>{}</style>", self.style);
            }
            svg.element("rect", format_args!(" width=\"100%\" height=\"100%\" fill=\"{}\"", self.ground));
            content(svg);
        });
        svg.finish()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use crate::svg::{Look, palette};

    #[test]
    fn a_page_has_its_size_in_its_unit_and_its_title() {
        let text = Page::new("a <b>", 300.0, 200.55).in_millimetres().draw(|svg| {
            let points = [Vector2::new(0.12345, 1.0), Vector2::new(2.0, 3.0)];
            svg.polyline(&points, Look::line(palette::INK, 0.12));
        });
        let document = roxmltree::Document::parse(&text).unwrap();
        let root = document.root_element();
        let of = |name| root.attribute(name).unwrap();
        assert_eq!([of("width"), of("height"), of("viewBox")], ["300mm", "200.55mm", "0 0 300 200.55"]);
        let title = document.descendants().find(|node| node.has_tag_name("title")).unwrap();
        assert_eq!(title.text(), Some("a <b>"));
        let line = document.descendants().find(|node| node.has_tag_name("polyline")).unwrap();
        assert_eq!(line.attribute("points"), Some("0.123,1 2,3"));
    }
}
