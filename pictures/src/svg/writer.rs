//! Writes elements: shapes, groups, text.
//!
//! In: places in the page's unit, looks, text of anyone's. Out: well-formed XML.

use std::fmt::{self, Arguments, Display, Write as _};

use nalgebra::Vector2;

use super::area::Area;
use super::colour::Colour;
use super::look::Look;
use super::number::{Number, Points};
use super::text::{Anchor, Direction, Escaped, TextStyle, Weight};

/// What is drawn on a [`Page`](super::Page): grows with every call; what is drawn later lies above.
///
/// All places and sizes are in the page's unit, x to the right and y down, and are written with the page's digits.
#[derive(Debug)]
pub struct Svg {
    pub(super) text: String,
    digits: u32,
}

/// Width of the halo around text that lies on lines, for the page's pixels.
const HALO: f64 = 4.0;

impl Svg {
    /// Nothing so far; numbers will have so many digits after the point.
    pub(crate) fn new(digits: u32) -> Svg {
        Svg { text: String::new(), digits }
    }

    /// A straight line.
    pub fn line(&mut self, from: Vector2<f64>, to: Vector2<f64>, look: Look) {
        let [x1, y1, x2, y2] = [from.x, from.y, to.x, to.y].map(|value| self.number(value));
        let look = look.attributes(self.digits);
        self.element("line", format_args!(" x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\"{look}"));
    }

    /// Straight lines from point to point.
    pub fn polyline(&mut self, points: &[Vector2<f64>], look: Look) {
        let points = self.points(points);
        let look = look.attributes(self.digits);
        self.element("polyline", format_args!("{look} points=\"{points}\""));
    }

    /// Straight lines from point to point, and back to the first.
    pub fn polygon(&mut self, points: &[Vector2<f64>], look: Look) {
        let points = self.points(points);
        let look = look.attributes(self.digits);
        self.element("polygon", format_args!("{look} points=\"{points}\""));
    }

    /// Many lines from point to point as one element; nothing where there are none.
    pub fn path(&mut self, lines: &[impl AsRef<[Vector2<f64>]>], look: Look) {
        if lines.is_empty() {
            return;
        }
        let digits = self.digits;
        // What follows the first point of an M is drawn to.
        let data = Written(|f: &mut fmt::Formatter<'_>| {
            lines.iter().try_for_each(|line| write!(f, "M{}", Points { points: line.as_ref(), digits }))
        });
        let look = look.attributes(digits);
        self.element("path", format_args!("{look} d=\"{data}\""));
    }

    /// A rectangle, its corners rounded by this radius, at least 0.
    pub fn rectangle(&mut self, area: Area, corner_radius: f64, look: Look) {
        let [x, y, width, height] = [area.x, area.y, area.width, area.height].map(|value| self.number(value));
        let radius = self.number(corner_radius);
        let round = Written(
            |f: &mut fmt::Formatter<'_>| {
                if corner_radius > 0.0 { write!(f, " rx=\"{radius}\"") } else { Ok(()) }
            },
        );
        let look = look.attributes(self.digits);
        self.element(
            "rect",
            format_args!(" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"{round}{look}"),
        );
    }

    /// A circle.
    pub fn circle(&mut self, centre: Vector2<f64>, radius: f64, look: Look) {
        let [x, y, radius] = [centre.x, centre.y, radius].map(|value| self.number(value));
        let look = look.attributes(self.digits);
        self.element("circle", format_args!(" cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"{look}"));
    }

    /// A line of text; the left end of its baseline, or what its style says, is at `at`.
    pub fn text(&mut self, at: Vector2<f64>, style: TextStyle, text: &str) {
        let [x, y, size] = [at.x, at.y, style.size].map(|value| self.number(value));
        let anchor = match style.anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let weight = match style.weight {
            Weight::Normal => "",
            Weight::Bold => " font-weight=\"600\"",
        };
        let more = Written(|f: &mut fmt::Formatter<'_>| {
            match style.direction {
                Direction::Rightwards => {}
                Direction::Upwards => write!(f, " transform=\"rotate(-90 {x} {y})\"")?,
            }
            style.class.map_or(Ok(()), |class| write!(f, " class=\"{class}\""))
        });
        // Writing to a String cannot fail.
        let _ = writeln!(
            self.text,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" fill=\"{}\"{anchor}{weight}{more}>{}</text>",
            style.colour,
            Escaped(text)
        );
    }

    /// Text with a halo of the ground's colour, for places where lines are.
    pub fn text_on_lines(&mut self, at: Vector2<f64>, style: TextStyle, ground: Colour, text: &str) {
        let halo = self.number(HALO);
        let attributes =
            format_args!(" stroke=\"{ground}\" stroke-width=\"{halo}\" stroke-linejoin=\"round\"");
        self.containing("g", attributes, |svg| svg.text(at, style.colour(ground), text));
        self.text(at, style, text);
    }

    /// What `content` draws, with a common look.
    pub fn group(&mut self, look: Look, content: impl FnOnce(&mut Svg)) {
        self.containing("g", format_args!("{}", look.attributes(self.digits)), content);
    }

    /// What `content` draws, which a browser explains by this text when it is pointed at.
    pub fn explained(&mut self, text: &str, content: impl FnOnce(&mut Svg)) {
        self.containing("g", format_args!(""), |svg| {
            let _ = writeln!(svg.text, "<title>{}</title>", Escaped(text));
            content(svg);
        });
    }

    /// What `content` draws about an origin that is at `origin`.
    pub fn moved(&mut self, origin: Vector2<f64>, content: impl FnOnce(&mut Svg)) {
        let [x, y] = [origin.x, origin.y].map(|value| self.number(value));
        self.containing("g", format_args!(" transform=\"translate({x} {y})\""), content);
    }

    /// What `content` draws about the upper left corner of an area, and of it what lies inside of the area.
    pub fn window(&mut self, area: Area, content: impl FnOnce(&mut Svg)) {
        let [x, y, width, height] = [area.x, area.y, area.width, area.height].map(|value| self.number(value));
        let attributes = format_args!(
            " x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\""
        );
        self.containing("svg", attributes, content);
    }

    /// An element without content; each attribute stands after a space.
    pub(crate) fn element(&mut self, tag: &str, attributes: Arguments<'_>) {
        let _ = writeln!(self.text, "<{tag}{attributes}/>");
    }

    /// An element with content; each attribute stands after a space.
    pub(crate) fn containing(
        &mut self,
        tag: &str,
        attributes: Arguments<'_>,
        content: impl FnOnce(&mut Svg),
    ) {
        let _ = writeln!(self.text, "<{tag}{attributes}>");
        content(self);
        let _ = writeln!(self.text, "</{tag}>");
    }

    /// A look as attributes of [`element`](Self::element), each after a space.
    pub(crate) fn attributes(&self, look: Look) -> String {
        look.attributes(self.digits).to_string()
    }

    /// A length in the page's unit.
    pub(crate) fn number(&self, value: f64) -> Number {
        Number { value, digits: self.digits }
    }

    /// Points as a `points` attribute has them.
    pub(crate) fn points<'a>(&self, points: &'a [Vector2<f64>]) -> impl Display + use<'a> {
        Points { points, digits: self.digits }
    }

    /// The text so far.
    pub(crate) fn finish(self) -> String {
        self.text
    }
}

/// What a function writes.
struct Written<F>(F);

impl<F: Fn(&mut fmt::Formatter<'_>) -> fmt::Result> Display for Written<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (self.0)(f)
    }
}

#[cfg(test)]
mod tests {
    use roxmltree::Document;

    use super::*;
    use crate::svg::palette::{INK, WHITE};

    fn drawn(content: impl FnOnce(&mut Svg)) -> String {
        let mut svg = Svg::new(1);
        svg.containing("svg", format_args!(""), content);
        svg.finish()
    }

    #[test]
    fn text_comes_back_from_a_parser_as_it_was() {
        let text = "a <b> & \"c\" 'd' ]]> é";
        let style = TextStyle::new(10.0, INK).end().bold();
        let document = drawn(|svg| svg.text(Vector2::new(1.0, 2.0), style, text));
        let parsed = Document::parse(&document).unwrap();
        assert_eq!(parsed.root_element().first_element_child().unwrap().text(), Some(text));
        assert_eq!(Escaped("a\u{1}b\nc").to_string(), "a b c");
    }

    #[test]
    fn shapes_are_where_they_were_put() {
        let points = [Vector2::new(1.0, 2.0), Vector2::new(3.04, -4.25)];
        let text = drawn(|svg| {
            svg.line(points[0], points[1], Look::new());
            svg.polygon(&points, Look::filled(WHITE));
            svg.path(&[points, points], Look::line(INK, 1.0));
            svg.path(&[points; 0], Look::new());
            svg.rectangle(Area { x: 1.0, y: 2.0, width: 3.0, height: 4.0 }, 0.5, Look::new());
            svg.circle(points[0], 5.0, Look::new());
            svg.moved(points[0], |svg| svg.circle(points[0], 5.0, Look::new()));
        });
        let document = Document::parse(&text).unwrap();
        let attribute = |tag, name| {
            let node = document.descendants().find(|node| node.has_tag_name(tag)).unwrap();
            node.attribute(name).unwrap()
        };
        assert_eq!(["x1", "y1", "x2", "y2"].map(|name| attribute("line", name)), ["1", "2", "3", "-4.3"]);
        assert_eq!(attribute("polygon", "points"), "1,2 3,-4.3");
        assert_eq!(attribute("path", "d"), "M1,2 3,-4.3M1,2 3,-4.3");
        assert_eq!(document.descendants().filter(|node| node.has_tag_name("path")).count(), 1);
        assert_eq!(attribute("rect", "rx"), "0.5");
        assert_eq!(["cx", "cy", "r"].map(|name| attribute("circle", name)), ["1", "2", "5"]);
        assert_eq!(attribute("g", "transform"), "translate(1 2)");
    }

    #[test]
    fn text_beside_an_axis_is_turned_about_its_own_place() {
        let style = TextStyle::new(11.0, INK).middle().upwards().class("name");
        let text = drawn(|svg| svg.text(Vector2::new(20.0, 90.0), style, "force [N]"));
        let document = Document::parse(&text).unwrap();
        let node = document.root_element().first_element_child().unwrap();
        assert_eq!(node.attribute("transform"), Some("rotate(-90 20 90)"));
        assert_eq!(node.attribute("class"), Some("name"));
    }
}
