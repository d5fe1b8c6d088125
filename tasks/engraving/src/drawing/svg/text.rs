//! `<text>` in Hershey's single-stroke fonts: the font's kind and size, the anchor and the places are honoured, its
//! weight and style are not.

use super::cascade::{Cascade, attribute};
use super::source::{Source, font_size, name_of};
use super::units;
use crate::drawing::hershey::{Font, PIECES_OF_A_LETTER};
use crate::drawing::{Affine, Budget, Piece, Stroke, Vec2};
use crate::error::DrawingError;
use roxmltree::Node;
use std::rc::Rc;

/// How letters look, inherited from outer elements.
#[derive(Clone, Copy, Debug)]
struct Lettering {
    /// Font size [px].
    size: f64,
    font: &'static str,
    anchor: Anchor,
    is_visible: bool,
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

impl Lettering {
    /// With what an element says of itself.
    fn with(self, said: impl Fn(&str) -> Option<String>) -> Self {
        let font = said("font-family").map(|family| {
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
        let anchor = match said("text-anchor").as_deref() {
            Some("start") => Anchor::Start,
            Some("middle") => Anchor::Middle,
            Some("end") => Anchor::End,
            _ => self.anchor,
        };
        let is_visible = match said("visibility").as_deref() {
            Some("hidden" | "collapse") => false,
            Some("visible") => true,
            _ => self.is_visible,
        };
        Self { font: font.unwrap_or(self.font), anchor, is_visible, ..self }
    }

    /// That of a part of a text.
    fn of_part(self, cascade: &Cascade<'_>, node: Node<'_, '_>) -> Self {
        let size = cascade.own(node, "font-size").and_then(|text| font_size(&text, self.size));
        Self { size: size.unwrap_or(self.size), ..self.with(|name| cascade.own(node, name)) }
    }
}

/// Whether parts of a text say of themselves whether they are seen.
pub fn has_visible_parts(cascade: &Cascade<'_>, node: Node<'_, '_>) -> bool {
    node.descendants().skip(1).any(|part| part.is_element() && cascade.own(part, "visibility").is_some())
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

/// A text in the units round it.
pub struct Written {
    /// Strokes of letters, and the map of each line from a font's units.
    pub lines: Vec<(Affine, Vec<Vec<Piece>>)>,
    /// What was left out.
    pub told: Vec<String>,
}

/// The fonts that were read.
#[derive(Default)]
pub struct Letters {
    fonts: Vec<(&'static str, Rc<Font>)>,
}

/// A text while it is written.
struct Writing<'b, 'a> {
    letters: &'b mut Letters,
    source: &'b Source<'a>,
    budget: &'b mut Budget,
    chunks: Vec<Chunk>,
    told: Vec<String>,
}

impl Letters {
    /// A `<text>` with its `<tspan>`s, in a font of this size [px].
    ///
    /// # Errors
    /// [`DrawingError::Unsupported`] for what the fonts do not have.
    pub fn write<'a>(
        &mut self,
        source: &Source<'a>,
        node: Node<'a, 'a>,
        size: f64,
        budget: &mut Budget,
    ) -> Result<Written, DrawingError> {
        let first = Chunk { place: Vec2::zeros(), runs: Vec::new(), pen: Vec2::zeros() };
        let mut writing = Writing { letters: self, source, budget, chunks: vec![first], told: Vec::new() };
        let lettering = Lettering { size, font: "futural", anchor: Anchor::Start, is_visible: true };
        let cascade = &source.cascade;
        let lettering = lettering.with(|name| cascade.inherited(node, name));
        // usvg has said that the text is seen, unless its parts are to be asked.
        let is_visible = lettering.is_visible || !has_visible_parts(cascade, node);
        writing.collect(node, Lettering { is_visible, ..lettering })?;
        writing.lines(node)
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
}

impl<'a> Writing<'_, 'a> {
    fn lines(self, node: Node<'a, 'a>) -> Result<Written, DrawingError> {
        let mut lines = Vec::new();
        for chunk in &self.chunks {
            let Some(first) = chunk.runs.first() else { continue };
            let back = match first.lettering.anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => 0.5,
                Anchor::End => 1.0,
            };
            let start = chunk.place - Vec2::new(chunk.pen.x * back, 0.0);
            for run in &chunk.runs {
                let scale = run.lettering.size * CAPITALS;
                let strokes = self.letters.font(run.lettering.font)?.line(&run.text);
                let strokes = strokes.map_err(|error| unwritable(self.source, node, &error))?;
                let map = Affine::translation(start + run.at).after(&Affine::scaling(scale, -scale));
                lines.push((map, strokes.into_iter().map(Stroke::into_pieces).collect()));
            }
        }
        Ok(Written { lines, told: self.told })
    }

    fn collect(&mut self, node: Node<'a, 'a>, lettering: Lettering) -> Result<(), DrawingError> {
        let cascade = &self.source.cascade;
        for name in ["rotate", "textLength", "letter-spacing", "word-spacing", "baseline-shift"] {
            let own = cascade.own(node, name);
            if own.is_some_and(|value| !matches!(value.as_str(), "0" | "normal" | "baseline" | "0px")) {
                self.tell(node, &format!("{name} left out"));
            }
        }
        let [x, y, dx, dy] = ["x", "y", "dx", "dy"].map(|name| self.first_length(node, name, lettering.size));
        let (x, y, dx, dy) = (x?, y?, dx?, dy?);
        if let Some(last) = self.chunks.last_mut() {
            let here = last.place + last.pen;
            if x.is_some() || y.is_some() {
                let place = Vec2::new(x.unwrap_or(here.x), y.unwrap_or(here.y));
                self.chunks.push(Chunk { place, runs: Vec::new(), pen: Vec2::zeros() });
            }
        }
        if let Some(last) = self.chunks.last_mut() {
            last.pen += Vec2::new(dx.unwrap_or(0.0), dy.unwrap_or(0.0));
        }
        for child in node.children() {
            if let Some(text) = child.text().filter(|_| child.is_text()) {
                self.write(node, text, lettering)?;
            }
            let is_none =
                |name, none: &dyn Fn(&str) -> bool| cascade.own(child, name).is_some_and(|v| none(&v));
            if !child.is_element()
                || is_none("display", &|value| value == "none")
                || is_none("opacity", &|value| value.parse::<f64>().is_ok_and(|opacity| opacity <= 0.0))
            {
                continue;
            }
            match name_of(child) {
                "tspan" | "a" => self.collect(child, lettering.of_part(cascade, child))?,
                "textPath" => self.tell(child, "text along a path left out: convert it to paths"),
                _ => {}
            }
        }
        Ok(())
    }

    /// Adds letters at the pen: blanks and line breaks in a row are one blank, as XML's default has it.
    fn write(&mut self, node: Node<'a, 'a>, text: &str, lettering: Lettering) -> Result<(), DrawingError> {
        let Some(chunk) = self.chunks.last_mut() else { return Ok(()) };
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
        let source = self.source;
        if lettering.is_visible {
            // Every letter has its cost before its curves are computed.
            self.budget.take(letters.len() * PIECES_OF_A_LETTER, || source.place(node))?;
        }
        let width = self.letters.font(lettering.font)?.width(&letters);
        let width = width.map_err(|error| unwritable(source, node, &error))?;
        let at = chunk.pen;
        chunk.pen.x += width * lettering.size * CAPITALS;
        if lettering.is_visible {
            chunk.runs.push(Run { text: letters, lettering, at });
        }
        Ok(())
    }

    fn first_length(
        &mut self,
        node: Node<'a, 'a>,
        name: &str,
        size: f64,
    ) -> Result<Option<f64>, DrawingError> {
        let Some(list) = attribute(node, name) else { return Ok(None) };
        let mut lengths = svgtypes::LengthListParser::from(list);
        let first = match lengths.next() {
            None => return Ok(None),
            Some(Ok(length)) if length.unit == svgtypes::LengthUnit::Percent => {
                self.source.px(node, length, if name.ends_with('x') { 'x' } else { 'y' })
            }
            Some(Ok(length)) => units::to_px(length, 0.0, size),
            Some(Err(error)) => return Err(self.source.bad_data(node, name, 0, &error.to_string())),
        };
        if lengths.next().is_some() {
            self.tell(node, &format!("places of single letters in {name} left out"));
        }
        Ok(Some(first))
    }

    fn tell(&mut self, node: Node<'a, 'a>, what: &str) {
        self.told.push(format!("{}: {what}", self.source.place(node)));
    }
}

fn unwritable<'a>(source: &Source<'a>, node: Node<'a, 'a>, error: &DrawingError) -> DrawingError {
    match error {
        DrawingError::MissingGlyph { character, .. } => DrawingError::Unsupported {
            at: source.place(node),
            what: format!("text with {character:?}, which no font here has"),
            help: "use the characters of ASCII, or convert it to paths (Inkscape: Path > Object to Path)"
                .to_owned(),
        },
        other => DrawingError::Unsupported {
            at: source.place(node),
            what: other.to_string(),
            help: "convert it to paths (Inkscape: Path > Object to Path)".to_owned(),
        },
    }
}
