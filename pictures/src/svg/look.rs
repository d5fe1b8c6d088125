//! How shapes are drawn: their fill and their stroke.

use std::fmt;

use super::colour::Colour;
use super::number::Number;

/// How a shape or a group of shapes is drawn. What is not said is taken from the enclosing group, and there is said by
/// SVG itself: filled black, without a stroke.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    class: Option<&'static str>,
    fill: Option<Fill>,
    fill_opacity: Option<f64>,
    stroke: Option<Colour>,
    stroke_opacity: Option<f64>,
    width: Option<f64>,
    dashes: Option<Dashes>,
    opacity: Option<f64>,
    round: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fill {
    None,
    Colour(Colour),
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Dashes {
    dash: f64,
    gap: f64,
}

/// Digits of an opacity.
const OPACITY_DIGITS: u32 = 3;

impl Look {
    /// Says nothing.
    #[must_use]
    pub fn new() -> Look {
        Look::default()
    }

    /// A line of this colour and `width` in the page's unit, without a fill.
    #[must_use]
    pub fn line(colour: Colour, width: f64) -> Look {
        Look::new().no_fill().stroke(colour).width(width)
    }

    /// A shape that is filled with this colour, without a stroke of its own.
    #[must_use]
    pub fn filled(colour: Colour) -> Look {
        Look::new().fill(colour)
    }

    /// A name by which programs that read the document find the shape: letters, digits, `-` and `_`.
    #[must_use]
    pub fn class(self, class: &'static str) -> Look {
        Look { class: Some(class), ..self }
    }

    /// What is enclosed is filled with this colour.
    #[must_use]
    pub fn fill(self, colour: Colour) -> Look {
        Look { fill: Some(Fill::Colour(colour)), ..self }
    }

    /// What is enclosed is not filled.
    #[must_use]
    pub fn no_fill(self) -> Look {
        Look { fill: Some(Fill::None), ..self }
    }

    /// Opacity of the fill, 0 to 1.
    #[must_use]
    pub fn fill_opacity(self, opacity: f64) -> Look {
        Look { fill_opacity: Some(opacity), ..self }
    }

    /// Colour of lines and outlines.
    #[must_use]
    pub fn stroke(self, colour: Colour) -> Look {
        Look { stroke: Some(colour), ..self }
    }

    /// Opacity of lines and outlines, 0 to 1.
    #[must_use]
    pub fn stroke_opacity(self, opacity: f64) -> Look {
        Look { stroke_opacity: Some(opacity), ..self }
    }

    /// Width of lines and outlines in the page's unit, at least 0.
    #[must_use]
    pub fn width(self, width: f64) -> Look {
        Look { width: Some(width), ..self }
    }

    /// Lines and outlines are dashed: the length of a dash and of the gap after it in the page's unit, > 0.
    #[must_use]
    pub fn dashed(self, dash: f64, gap: f64) -> Look {
        Look { dashes: Some(Dashes { dash, gap }), ..self }
    }

    /// Opacity of all of it together, 0 to 1.
    #[must_use]
    pub fn opacity(self, opacity: f64) -> Look {
        Look { opacity: Some(opacity), ..self }
    }

    /// Lines have round ends and round corners.
    #[must_use]
    pub fn round(self) -> Look {
        Look { round: true, ..self }
    }

    /// The attributes, each after a space; lengths have so many digits.
    pub(super) fn attributes(&self, digits: u32) -> Attributes<'_> {
        Attributes { look: self, digits }
    }
}

/// A look as attributes.
pub(super) struct Attributes<'a> {
    look: &'a Look,
    digits: u32,
}

impl fmt::Display for Attributes<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Look { class, fill, fill_opacity, stroke, stroke_opacity, width, dashes, opacity, round } =
            self.look;
        let length = |value: f64| Number { value, digits: self.digits };
        let share = |value: f64| Number { value, digits: OPACITY_DIGITS };
        if let Some(class) = class {
            write!(f, " class=\"{class}\"")?;
        }
        match fill {
            Some(Fill::None) => f.write_str(" fill=\"none\"")?,
            Some(Fill::Colour(colour)) => write!(f, " fill=\"{colour}\"")?,
            None => {}
        }
        if let Some(opacity) = fill_opacity {
            write!(f, " fill-opacity=\"{}\"", share(*opacity))?;
        }
        if let Some(colour) = stroke {
            write!(f, " stroke=\"{colour}\"")?;
        }
        if let Some(opacity) = stroke_opacity {
            write!(f, " stroke-opacity=\"{}\"", share(*opacity))?;
        }
        if let Some(width) = width {
            write!(f, " stroke-width=\"{}\"", length(*width))?;
        }
        if let Some(Dashes { dash, gap }) = dashes {
            write!(f, " stroke-dasharray=\"{} {}\"", length(*dash), length(*gap))?;
        }
        if *round {
            f.write_str(" stroke-linecap=\"round\" stroke-linejoin=\"round\"")?;
        }
        if let Some(opacity) = opacity {
            write!(f, " opacity=\"{}\"", share(*opacity))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::svg::palette::{INK, WHITE};

    #[test]
    fn a_look_writes_what_it_says_and_nothing_else() {
        assert_eq!(Look::new().attributes(1).to_string(), "");
        let look = Look::line(INK, 1.25).class("grid").dashed(4.0, 2.55).opacity(0.42);
        let expected = " class=\"grid\" fill=\"none\" stroke=\"#1c2733\" stroke-width=\"1.3\" stroke-dasharray=\"4 2.6\" opacity=\"0.42\"";
        assert_eq!(look.attributes(1).to_string(), expected);
        let look = Look::filled(WHITE).fill_opacity(0.5).stroke_opacity(0.25).round();
        let expected = " fill=\"#fff\" fill-opacity=\"0.5\" stroke-opacity=\"0.25\" stroke-linecap=\"round\" stroke-linejoin=\"round\"";
        assert_eq!(look.attributes(1).to_string(), expected);
    }
}
