//! The SVG text: elements, escaped words, short numbers.
//!
//! In: attributes and words. Out: well-formed XML; nothing but [`Svg::words`] and [`Svg::title`] takes text of a user's.

use std::fmt::{self, Arguments, Display, Write as _};

use nalgebra::Vector2;

/// An SVG document that grows.
#[derive(Debug, Default)]
pub(crate) struct Svg {
    text: String,
}

/// How words look.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Words<'a> {
    /// Height \[px\], > 0.
    pub size: f64,
    /// Fill.
    pub colour: &'a str,
    /// Where they are fixed.
    pub anchor: Anchor,
    /// Weight.
    pub weight: Weight,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Weight {
    Normal,
    Bold,
}

impl Svg {
    /// An element without content.
    pub fn element(&mut self, tag: &str, attributes: Arguments<'_>) {
        // Writing to a String cannot fail.
        let _ = writeln!(self.text, "<{tag} {attributes}/>");
    }

    /// An element with content.
    pub fn group(&mut self, tag: &str, attributes: Arguments<'_>, content: impl FnOnce(&mut Svg)) {
        let _ = writeln!(self.text, "<{tag} {attributes}>");
        content(self);
        let _ = writeln!(self.text, "</{tag}>");
    }

    /// What a browser shows as the name of the enclosing element.
    pub fn title(&mut self, text: &str) {
        let _ = writeln!(self.text, "<title>{}</title>", Escaped(text));
    }

    /// Rules for classes, of this crate's making.
    pub fn style(&mut self, rules: &'static str) {
        let _ = writeln!(self.text, "<style>{rules}</style>");
    }

    /// A line of text with its baseline at `at`.
    pub fn words(&mut self, at: Vector2<f64>, words: Words<'_>, text: &str) {
        let anchor = match words.anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let weight = match words.weight {
            Weight::Normal => "",
            Weight::Bold => " font-weight=\"600\"",
        };
        let _ = writeln!(
            self.text,
            "<text x=\"{}\" y=\"{}\" font-size=\"{}\" fill=\"{}\"{anchor}{weight}>{}</text>",
            Px(at.x),
            Px(at.y),
            Px(words.size),
            words.colour,
            Escaped(text)
        );
    }

    /// Words on a halo of the ground's colour, for places with lines.
    pub fn words_on_lines(&mut self, at: Vector2<f64>, words: Words<'_>, ground: &str, text: &str) {
        self.group(
            "g",
            format_args!("stroke=\"{ground}\" stroke-width=\"4\" stroke-linejoin=\"round\""),
            |svg| svg.words(at, Words { colour: ground, ..words }, text),
        );
        self.words(at, words, text);
    }

    /// A straight line.
    pub fn line(&mut self, a: Vector2<f64>, b: Vector2<f64>, attributes: Arguments<'_>) {
        let (x1, y1, x2, y2) = (Px(a.x), Px(a.y), Px(b.x), Px(b.y));
        self.element("line", format_args!("x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" {attributes}"));
    }

    /// The text so far.
    pub fn finish(self) -> String {
        self.text
    }
}

/// A length on the page, to a tenth of a pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Px(pub f64);

impl Display for Px {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tenths = if self.0.is_finite() { (self.0 * 10.0).round() as i64 } else { 0 };
        let (sign, tenths) = if tenths < 0 { ("-", -tenths) } else { ("", tenths) };
        match tenths % 10 {
            0 => write!(f, "{sign}{}", tenths / 10),
            rest => write!(f, "{sign}{}.{rest}", tenths / 10),
        }
    }
}

/// Points of a `points` attribute.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Points<'a>(pub &'a [Vector2<f64>]);

impl Display for Points<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, point) in self.0.iter().enumerate() {
            let gap = if i == 0 { "" } else { " " };
            write!(f, "{gap}{},{}", Px(point.x), Px(point.y))?;
        }
        Ok(())
    }
}

/// Lines of a `d` attribute.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strokes<'a>(pub &'a [&'a [Vector2<f64>]]);

impl Display for Strokes<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // What follows the first point of an M is drawn to.
        self.0.iter().try_for_each(|line| write!(f, "M{}", Points(line)))
    }
}

/// Text without what XML would read as markup, or does not allow at all.
struct Escaped<'a>(&'a str);

impl Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.chars().try_for_each(|c| match c {
            '&' => f.write_str("&amp;"),
            '<' => f.write_str("&lt;"),
            '>' => f.write_str("&gt;"),
            '"' => f.write_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => f.write_char('\u{fffd}'),
            c if c.is_control() => f.write_char(' '),
            c => f.write_char(c),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_come_back_from_a_parser_as_they_were() {
        let text = "a <b> & \"c\" 'd' ]]> é";
        let mut svg = Svg::default();
        let words = Words { size: 10.0, colour: "#000", anchor: Anchor::End, weight: Weight::Bold };
        svg.words(Vector2::new(1.0, 2.0), words, text);
        let document = svg.finish();
        let parsed = roxmltree::Document::parse(&document).unwrap();
        assert_eq!(parsed.root_element().text(), Some(text));
        assert_eq!(Escaped("a\u{1}b\nc").to_string(), "a b c");
    }

    #[test]
    fn lengths_are_short_and_always_numbers() {
        let texts = [0.04, -0.04, 1.25, -3.0, 1e3, f64::NAN].map(|v| Px(v).to_string());
        assert_eq!(texts, ["0", "0", "1.3", "-3", "1000", "0"]);
    }
}
