//! Text: how it looks, and how it is escaped.

use std::fmt::{self, Write as _};

use super::colour::Colour;

/// How a line of text looks. At first it begins at its place, in normal weight, from left to right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextStyle {
    pub(super) size: f64,
    pub(super) colour: Colour,
    pub(super) anchor: Anchor,
    pub(super) weight: Weight,
    pub(super) direction: Direction,
    pub(super) class: Option<&'static str>,
}

/// What of the text is at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Weight {
    Normal,
    Bold,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    Rightwards,
    Upwards,
}

impl TextStyle {
    /// Text of this height in the page's unit, > 0, and this colour.
    #[must_use]
    pub fn new(size: f64, colour: Colour) -> TextStyle {
        TextStyle {
            size,
            colour,
            anchor: Anchor::Start,
            weight: Weight::Normal,
            direction: Direction::Rightwards,
            class: None,
        }
    }

    /// The same, with its middle at its place.
    #[must_use]
    pub fn middle(self) -> TextStyle {
        TextStyle { anchor: Anchor::Middle, ..self }
    }

    /// The same, with its end at its place.
    #[must_use]
    pub fn end(self) -> TextStyle {
        TextStyle { anchor: Anchor::End, ..self }
    }

    /// The same in bold.
    #[must_use]
    pub fn bold(self) -> TextStyle {
        TextStyle { weight: Weight::Bold, ..self }
    }

    /// The same from below to above, as beside an axis.
    #[must_use]
    pub fn upwards(self) -> TextStyle {
        TextStyle { direction: Direction::Upwards, ..self }
    }

    /// The same in another colour.
    #[must_use]
    pub fn colour(self, colour: Colour) -> TextStyle {
        TextStyle { colour, ..self }
    }

    /// The same of another height in the page's unit, > 0.
    #[must_use]
    pub fn size(self, size: f64) -> TextStyle {
        TextStyle { size, ..self }
    }

    /// The same with a name by which programs that read the document find it: letters, digits, `-` and `_`.
    #[must_use]
    pub fn class(self, class: &'static str) -> TextStyle {
        TextStyle { class: Some(class), ..self }
    }
}

/// Text without what XML would read as markup, or does not allow at all.
pub(super) struct Escaped<'a>(pub &'a str);

impl fmt::Display for Escaped<'_> {
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

/// A text of at most `room` characters; what does not fit becomes an ellipsis.
#[must_use]
pub fn shortened(text: &str, room: usize) -> String {
    if text.chars().count() <= room {
        return text.to_owned();
    }
    text.chars().take(room.saturating_sub(1)).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_end_in_an_ellipsis() {
        assert_eq!(shortened("abcdef", 6), "abcdef");
        assert_eq!(shortened("abcdefg", 6), "abcde…");
    }
}
