//! Text in Hershey's single-stroke fonts (Hershey 1967), from JHF files.
//!
//! A JHF line is a glyph: five characters of number, three of how many coordinate pairs follow, then pairs of
//! characters that count from `R`: first the left and right edges, then vertices, ` R` lifting the pen. Glyphs stand
//! in ASCII order from the blank; other letters are composed of these. The coarse polylines are drawn as smooth curves through their vertices; turns of
//! 50 degrees or more stay corners.

use super::composed::{Glyph, composed};
use super::{Affine, Drawing, Import, Stroke, Vec2, smooth_pieces};
use crate::error::{DrawingError, Place};
use mrroc::launch::files;
use std::borrow::Cow;
use std::io::Read;

/// The fonts that are shipped: name, JHF text.
const SHIPPED: &[(&str, &str)] = &[
    ("futural", include_str!("../../assets/fonts/futural.jhf")),
    ("rowmans", include_str!("../../assets/fonts/rowmans.jhf")),
    ("scripts", include_str!("../../assets/fonts/scripts.jhf")),
    ("timesr", include_str!("../../assets/fonts/timesr.jhf")),
];

/// Height of a capital letter in the fonts' own units.
const CAPITAL: f64 = 21.0;

/// From the baseline up to the origin of the coordinates.
const BASELINE: f64 = 9.0;

/// From line to line, in capital heights.
const LINE_STEP: f64 = 1.7;

/// Turns of less than this are part of a curve \[rad\].
const CORNER: f64 = 50.0 * std::f64::consts::PI / 180.0;

/// The most vertices of a glyph: Hershey's own have fewer than 200.
const LONGEST_GLYPH: usize = 2000;

/// The longest file \[bytes\]: the largest of Hershey's has 70 thousand.
const LONGEST_FILE: u64 = 4 << 20;

/// What a letter costs of a budget of curve pieces before it is written.
pub const PIECES_OF_A_LETTER: usize = 8;

/// A single-stroke font.
#[derive(Clone, Debug, PartialEq)]
pub struct Font {
    name: String,
    glyphs: Vec<Glyph>,
}

impl Font {
    /// The names of the shipped fonts.
    pub fn shipped() -> impl Iterator<Item = &'static str> {
        SHIPPED.iter().map(|(name, _)| *name)
    }

    /// A shipped font by name, or the file at a path that ends in `.jhf`.
    ///
    /// # Errors
    /// [`DrawingError::UnknownFont`], or what is wrong with the file.
    pub fn open(name: &str) -> Result<Self, DrawingError> {
        if let Some((name, text)) = SHIPPED.iter().find(|(shipped, _)| *shipped == name) {
            return Self::parse(name, text);
        }
        if !name.to_ascii_lowercase().ends_with(".jhf") {
            let shipped = Self::shipped().collect::<Vec<_>>().join(", ");
            return Err(DrawingError::UnknownFont { name: name.to_owned(), shipped });
        }
        let mut text = String::new();
        let read = files::open(name).and_then(|file| file.take(LONGEST_FILE + 1).read_to_string(&mut text));
        match read {
            Ok(bytes) if bytes as u64 > LONGEST_FILE => Err(DrawingError::FileTooLong {
                file: name.to_owned(),
                bytes: bytes as u64,
                limit: LONGEST_FILE,
            }),
            Ok(_) => Self::parse(name, &text),
            Err(source) => Err(DrawingError::Unreadable { file: name.to_owned(), source }),
        }
    }

    /// Reads a JHF file: glyphs may go on in the next line.
    ///
    /// # Errors
    /// [`DrawingError::Malformed`] or [`DrawingError::Truncated`] at the glyph's line.
    pub fn parse(name: &str, text: &str) -> Result<Self, DrawingError> {
        let mut glyphs = Vec::new();
        let mut lines = text.lines().enumerate();
        while let Some((i, first)) = lines.next() {
            if first.trim().is_empty() {
                continue;
            }
            let malformed = |what: &str| DrawingError::Malformed {
                at: Place::line(name, i + 1, first),
                what: what.to_owned(),
                help: "a JHF line is 5 characters of number, 3 of count, then pairs of characters".to_owned(),
            };
            if !first.is_ascii() {
                return Err(malformed("a glyph with characters outside ASCII"));
            }
            let count = first.get(5..8).and_then(|n| n.trim().parse::<usize>().ok());
            let count = count
                .filter(|n| (1..=LONGEST_GLYPH).contains(n))
                .ok_or_else(|| malformed("a glyph without its count of pairs"))?;
            let mut data = first.as_bytes()[8..].to_vec();
            while data.len() < 2 * count {
                match lines.next() {
                    Some((_, more)) => data.extend_from_slice(more.as_bytes()),
                    None => {
                        let at = Place::line(name, i + 1, first);
                        return Err(DrawingError::Truncated { at, inside: "inside a glyph".to_owned() });
                    }
                }
            }
            glyphs.push(glyph(&data[..2 * count]));
        }
        if glyphs.is_empty() {
            return Err(DrawingError::Empty {
                file: name.to_owned(),
                found: "no glyph".to_owned(),
                help: "give a JHF font".to_owned(),
            });
        }
        Ok(Self { name: name.to_owned(), glyphs })
    }

    /// The text, several lines centred below one another, in capitals of `capital_mm` \[mm\], > 0.
    ///
    /// # Errors
    /// [`DrawingError::MissingGlyph`] names the first character that the font lacks; [`DrawingError::Empty`] for
    /// blanks alone.
    pub fn write(&self, text: &str, capital_mm: f64) -> Result<Import, DrawingError> {
        let scale = capital_mm / CAPITAL;
        let mut strokes = Vec::new();
        let mut place = 0;
        for (row, line) in text.lines().enumerate() {
            let (placed, x) = self.row(line, &mut place)?;
            let map = Affine::scaling(scale, scale)
                .after(&Affine::translation(Vec2::new(-x / 2.0, -(row as f64) * LINE_STEP * CAPITAL)));
            strokes.extend(placed.iter().map(|stroke: &Stroke| stroke.transformed(&map)));
        }
        if strokes.is_empty() {
            return Err(DrawingError::Empty {
                file: "--text".to_owned(),
                found: "a text without visible characters".to_owned(),
                help: "give letters or digits".to_owned(),
            });
        }
        Ok(Import { drawing: Drawing { strokes }, ..Import::default() })
    }

    /// A line of text from the origin along x with its baseline at 0, in capitals that are 1 high.
    ///
    /// # Errors
    /// [`DrawingError::MissingGlyph`] names the first character that the font lacks.
    pub fn line(&self, text: &str) -> Result<Vec<Stroke>, DrawingError> {
        let (strokes, _) = self.row(&plain(text), &mut 0)?;
        let map = Affine::scaling(1.0 / CAPITAL, 1.0 / CAPITAL);
        Ok(strokes.iter().map(|stroke| stroke.transformed(&map)).collect())
    }

    /// How far a line of text reaches, in capital heights.
    ///
    /// # Errors
    /// As [`line`](Self::line).
    pub fn width(&self, text: &str) -> Result<f64, DrawingError> {
        let mut width = 0.0;
        for (place, character) in plain(text).chars().enumerate() {
            let glyph = self.glyph(character, place + 1)?;
            width += glyph.right - glyph.left;
        }
        Ok(width / CAPITAL)
    }

    /// A line of text in the font's units, and how far it reaches.
    fn row(&self, line: &str, place: &mut usize) -> Result<(Vec<Stroke>, f64), DrawingError> {
        let mut x = 0.0;
        let mut placed = Vec::new();
        for character in line.chars() {
            *place += 1;
            let glyph = self.glyph(character, *place)?;
            for polyline in &glyph.lines {
                let map = Affine::translation(Vec2::new(x - glyph.left, 0.0));
                let stroke = Stroke::new(smooth_pieces(polyline, CORNER));
                placed.extend(stroke.map(|stroke| stroke.transformed(&map)));
            }
            x += glyph.right - glyph.left;
        }
        Ok((placed, x))
    }

    /// The text with a blank for each letter that the font does not have, and those letters.
    #[must_use]
    pub fn engravable(&self, text: &str) -> (String, Vec<char>) {
        let mut missing = Vec::new();
        let mut kept = |c: char| {
            let has = self.glyph(c, 0).is_ok();
            if !has {
                missing.push(c);
            }
            if has { c } else { ' ' }
        };
        (plain(text).chars().map(&mut kept).collect(), missing)
    }

    fn glyph(&self, character: char, place: usize) -> Result<Cow<'_, Glyph>, DrawingError> {
        if let Some(glyph) = self.ascii(character) {
            return Ok(Cow::Borrowed(glyph));
        }
        composed(character, &|c| self.ascii(c)).map(Cow::Owned).ok_or_else(|| DrawingError::MissingGlyph {
            character,
            place,
            font: self.name.clone(),
            coverage: "the letters of Latin alphabets".to_owned(),
        })
    }

    fn ascii(&self, character: char) -> Option<&Glyph> {
        let index = (u32::from(character) as usize).checked_sub(32)?;
        self.glyphs.get(index).filter(|_| character.is_ascii() && !character.is_control())
    }
}

/// Typographic quotation marks, dashes and blanks as ASCII has them.
fn plain(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '‘' | '’' | '′' => plain.push('\''),
            '“' | '”' | '″' => plain.push('"'),
            '–' | '—' | '−' | '‐' => plain.push('-'),
            '…' => plain.push_str("..."),
            '\u{a0}' | '\u{2000}'..='\u{200a}' | '\u{202f}' | '\t' => plain.push(' '),
            '×' => plain.push('x'),
            c => plain.push(c),
        }
    }
    plain
}

/// A glyph from its pairs, the edges first.
fn glyph(data: &[u8]) -> Glyph {
    let number = |b: u8| f64::from(b) - f64::from(b'R');
    let (edges, vertices) = data.split_at(2);
    let mut lines = vec![Vec::new()];
    for pair in vertices.chunks_exact(2) {
        if pair == b" R" {
            lines.push(Vec::new());
        } else if let Some(line) = lines.last_mut() {
            line.push(Vec2::new(number(pair[0]), BASELINE - number(pair[1])));
        }
    }
    lines.retain(|line: &Vec<Vec2>| line.len() > 1);
    Glyph { left: number(edges[0]), right: number(edges[1]), lines }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_shipped_fonts_write_all_of_ascii() {
        let text: String = (33..127u8).map(char::from).collect();
        for name in Font::shipped() {
            let font = Font::open(name).unwrap();
            assert!(font.write(&text, 10.0).unwrap().drawing.strokes.len() > 94, "{name}");
        }
    }

    #[test]
    fn capitals_have_the_height_that_was_asked_for() {
        let bounds = Font::open("futural").unwrap().write("H", 10.0).unwrap().drawing.bounds().unwrap();
        assert!((bounds.size().y - 10.0).abs() < 1e-9);
        assert!(bounds.min.y.abs() < 1e-9);
    }

    #[test]
    fn a_line_has_capitals_of_1_and_its_width_is_that_of_its_glyphs() {
        let font = Font::open("futural").unwrap();
        let height = font.line("H").unwrap().iter().map(Stroke::bounds).reduce(|a, b| a.union(&b)).unwrap();
        assert!((height.size().y - 1.0).abs() < 1e-12);
        // H in Hershey's simplex: 22 units between its edges, capitals of 21.
        assert!((font.width("HH").unwrap() - 44.0 / 21.0).abs() < 1e-12);
        assert_eq!(font.line("“a–b”…").unwrap(), font.line("\"a-b\"...").unwrap());
    }

    #[test]
    fn a_character_that_is_missing_is_named() {
        let message = Font::open("futural").unwrap().write("Zażół漢", 10.0).unwrap_err().to_string();
        assert!(message.contains("'漢' (U+6F22) at place 6"), "{message}");
        let message = Font::open("comic").unwrap_err().to_string();
        assert!(message.contains("shipped are futural, rowmans, scripts, timesr"), "{message}");
        assert!(Font::open("futural").unwrap().write(" \n ", 10.0).is_err());
    }

    #[test]
    fn a_font_that_is_cut_short_says_so() {
        assert!(Font::parse("x.jhf", "12345  9MWRFRT").unwrap_err().to_string().contains("inside a glyph"));
        assert!(Font::parse("x.jhf", "hello").unwrap_err().to_string().contains("count of pairs"));
    }

    proptest::proptest! {
        #![proptest_config(proptest::prelude::ProptestConfig { failure_persistence: None, ..proptest::prelude::ProptestConfig::with_cases(1000) })]

        #[test]
        fn no_font_panics(text in "([ 0-9]{8}[ -~]{0,40}\n){0,4}|.{0,60}", say in ".{0,6}") {
            if let Ok(font) = Font::parse("x.jhf", &text) {
                let _ = font.write(&say, 10.0);
            }
        }
    }
}
