//! `<text>` in Hershey's single-stroke fonts: the font's kind and size, the anchor and the places are honoured, its
//! weight and style are not.

use std::rc::Rc;

use roxmltree::Node;

use super::tree::{Inherited, Walk};
use super::visibility::{Visibility, is_switched_off, property};
use crate::drawing::hershey::{Font, PIECES_OF_A_LETTER};
use crate::drawing::{Affine, Stroke, Vec2};
use crate::error::DrawingError;

/// How letters look, inherited on the way down.
#[derive(Clone, Copy, Debug)]
pub struct Lettering {
    /// Font size [px].
    size: f64,
    font: &'static str,
    anchor: Anchor,
}

/// What of a text lies at its place.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Anchor {
    Start,
    Middle,
    End,
}

/// Height of capitals over the size of a font: that of common sans-serif fonts is 0.70 to 0.73.
const CAPITALS: f64 = 0.7;

impl Default for Lettering {
    /// 16 px, as browsers have it.
    fn default() -> Self {
        Self { size: 16.0, font: "futural", anchor: Anchor::Start }
    }
}

impl Lettering {
    /// That of an element, from its parent's.
    pub fn inherited(self, node: Node<'_, '_>) -> Self {
        let size = property(node, "font-size").and_then(|text| self.size_of(text));
        let font = property(node, "font-family").map(|family| {
            let family = family.to_ascii_lowercase();
            let has = |words: &[&str]| words.iter().any(|word| family.contains(word));
            if has(&["script", "cursive", "hand"]) {
                "scripts"
            } else if !has(&["sans"]) && has(&["serif", "times", "roman", "georgia"]) {
                "timesr"
            } else {
                "futural"
            }
        });
        let anchor = match property(node, "text-anchor") {
            Some("start") => Some(Anchor::Start),
            Some("middle") => Some(Anchor::Middle),
            Some("end") => Some(Anchor::End),
            _ => None,
        };
        Self {
            size: size.unwrap_or(self.size),
            font: font.unwrap_or(self.font),
            anchor: anchor.unwrap_or(self.anchor),
        }
    }

    fn size_of(&self, text: &str) -> Option<f64> {
        use svgtypes::LengthUnit;
        let length: svgtypes::Length = text.parse().ok()?;
        let size = match length.unit {
            LengthUnit::Em => length.number * self.size,
            LengthUnit::Ex => length.number * self.size / 2.0,
            _ => super::units::to_px(length, self.size),
        };
        (size.is_finite() && size > 0.0).then_some(size)
    }
}

/// Letters of one kind that follow one another.
struct Run {
    text: String,
    lettering: Lettering,
    /// Where it begins, from the start of its chunk [px].
    at: Vec2,
}

/// Runs that begin at a place of their own and are anchored together.
struct Chunk {
    place: Vec2,
    runs: Vec<Run>,
    /// Where the pen is, from the place [px].
    pen: Vec2,
}

impl<'a> Walk<'a> {
    /// A `<text>` with its `<tspan>`s.
    ///
    /// What the fonts do not have is left out and told.
    pub(super) fn text(&mut self, node: Node<'a, 'a>, from: &Inherited) -> Result<(), DrawingError> {
        match self.written(node, from) {
            Err(DrawingError::Unsupported { what, help, .. }) => {
                self.tell_text(node, &format!("{what}, left out: {help}"));
                Ok(())
            }
            other => other,
        }
    }

    fn written(&mut self, node: Node<'a, 'a>, from: &Inherited) -> Result<(), DrawingError> {
        let mut chunks = vec![Chunk { place: Vec2::zeros(), runs: Vec::new(), pen: Vec2::zeros() }];
        self.collect(node, from, &mut chunks)?;
        for chunk in &chunks {
            let Some(first) = chunk.runs.first() else { continue };
            let back = match first.lettering.anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => 0.5,
                Anchor::End => 1.0,
            };
            let start = chunk.place - Vec2::new(chunk.pen.x * back, 0.0);
            for run in &chunk.runs {
                let scale = run.lettering.size * CAPITALS;
                let strokes = self.font(run.lettering.font)?.line(&run.text);
                let strokes = strokes.map_err(|error| self.unwritable(node, &error))?;
                let map = from
                    .map
                    .after(&Affine::translation(start + run.at))
                    .after(&Affine::scaling(scale, -scale));
                let chains = strokes.into_iter().map(Stroke::into_pieces).collect();
                self.keep(node, chains, &map)?;
            }
        }
        Ok(())
    }

    fn collect(
        &mut self,
        node: Node<'a, 'a>,
        from: &Inherited,
        chunks: &mut Vec<Chunk>,
    ) -> Result<(), DrawingError> {
        for name in ["rotate", "textLength", "letter-spacing", "word-spacing", "baseline-shift"] {
            if property(node, name).is_some_and(|value| !matches!(value, "0" | "normal" | "baseline" | "0px"))
            {
                self.tell_text(node, &format!("{name} left out"));
            }
        }
        let [x, y, dx, dy] = ["x", "y", "dx", "dy"].map(|name| self.first_length(node, name, from));
        let (x, y, dx, dy) = (x?, y?, dx?, dy?);
        if let Some(last) = chunks.last_mut() {
            let here = last.place + last.pen;
            if x.is_some() || y.is_some() {
                let place = Vec2::new(x.unwrap_or(here.x), y.unwrap_or(here.y));
                chunks.push(Chunk { place, runs: Vec::new(), pen: Vec2::zeros() });
            }
        }
        if let Some(last) = chunks.last_mut() {
            last.pen += Vec2::new(dx.unwrap_or(0.0), dy.unwrap_or(0.0));
        }
        for child in node.children() {
            if let Some(text) = child.text().filter(|_| child.is_text()) {
                self.write(node, text, from, chunks)?;
            }
            if !child.is_element() || is_switched_off(child) {
                continue;
            }
            match child.tag_name().name() {
                "tspan" | "a" => {
                    let mut inner = *from;
                    inner.depth += 1;
                    self.check_depth(inner.depth, child)?;
                    inner.visibility = super::visibility::inherited(child, from.visibility);
                    inner.lettering = from.lettering.inherited(child);
                    self.collect(child, &inner, chunks)?;
                }
                "textPath" => self.tell_text(child, "text along a path left out: convert it to paths"),
                _ => {}
            }
        }
        Ok(())
    }

    /// Adds letters at the pen: blanks and line breaks in a row are one blank, as XML's default has it.
    fn write(
        &mut self,
        node: Node<'a, 'a>,
        text: &str,
        from: &Inherited,
        chunks: &mut [Chunk],
    ) -> Result<(), DrawingError> {
        let Some(chunk) = chunks.last_mut() else { return Ok(()) };
        let mut letters = String::new();
        let mut blank = chunk.runs.last().is_none_or(|run| run.text.ends_with(' '));
        for c in text.chars() {
            let c = if c.is_whitespace() { ' ' } else { c };
            if c != ' ' || !blank {
                letters.push(c);
            }
            blank = c == ' ';
        }
        if letters.is_empty() {
            return Ok(());
        }
        let width = self.font(from.lettering.font)?.width(&letters);
        let width = width.map_err(|error| self.unwritable(node, &error))?;
        let at = chunk.pen;
        chunk.pen.x += width * from.lettering.size * CAPITALS;
        if from.visibility == Visibility::Visible {
            // Every letter has its cost before its curves are computed.
            self.take_budget(letters.len() * PIECES_OF_A_LETTER, node)?;
            chunk.runs.push(Run { text: letters, lettering: from.lettering, at });
        }
        Ok(())
    }

    fn first_length(
        &mut self,
        node: Node<'a, 'a>,
        name: &str,
        from: &Inherited,
    ) -> Result<Option<f64>, DrawingError> {
        let Some(list) = node.attribute(name) else { return Ok(None) };
        let mut lengths = svgtypes::LengthListParser::from(list);
        let whole = if name.ends_with('x') { from.viewport.x } else { from.viewport.y };
        let first = match lengths.next() {
            None => return Ok(None),
            Some(Ok(length)) => match length.unit {
                svgtypes::LengthUnit::Em => length.number * from.lettering.size,
                _ => super::units::to_px(length, whole),
            },
            Some(Err(error)) => return Err(self.bad_attribute(node, name, &error.to_string())),
        };
        if lengths.next().is_some() {
            self.tell_text(node, &format!("places of single letters in {name} left out"));
        }
        Ok(Some(first))
    }

    /// A font, read once.
    fn font(&mut self, name: &'static str) -> Result<Rc<Font>, DrawingError> {
        if let Some((_, font)) = self.fonts.iter().find(|(known, _)| *known == name) {
            return Ok(Rc::clone(font));
        }
        let font = Rc::new(Font::open(name)?);
        self.fonts.push((name, Rc::clone(&font)));
        Ok(font)
    }

    fn unwritable(&self, node: Node<'a, 'a>, error: &DrawingError) -> DrawingError {
        match error {
            DrawingError::MissingGlyph { character, .. } => DrawingError::Unsupported {
                at: self.place(node),
                what: format!("text with {character:?}, which no font here has"),
                help: "use the characters of ASCII, or convert it to paths (Inkscape: Path > Object to Path)"
                    .to_owned(),
            },
            other => DrawingError::Unsupported {
                at: self.place(node),
                what: other.to_string(),
                help: "convert it to paths (Inkscape: Path > Object to Path)".to_owned(),
            },
        }
    }

    fn tell_text(&mut self, node: Node<'a, 'a>, what: &str) {
        if self.warnings.len() < 20 {
            let warning = format!("{}: {what}", self.place(node));
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
    }
}
