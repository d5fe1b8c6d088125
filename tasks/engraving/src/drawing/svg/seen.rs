//! What usvg sees of the document, drawn: the outlines behind the marks, cut to their dashes, in millimetres.

use super::cascade::attribute;
use super::clip::{Clip, Within};
use super::dashes::{self, Pattern};
use super::exact::Transforms;
use super::expansion::href;
use super::rewrite::{Mark, number};
use super::source::{Source, name_of};
use super::text::Letters;
use super::units;
use crate::drawing::{Affine, Bounds, Budget, EllipticalArc, Piece, Stroke, Vec2};
use crate::error::{DrawingError, Place};
use mrroc::console::quoted;
use roxmltree::Node;
use std::f64::consts::TAU;
use usvg::tiny_skia_path::{Path as Outline, PathSegment};

/// Most warnings of one file.
const MOST_WARNINGS: usize = 20;

/// The walk through what usvg has made, and what it has found.
pub struct Seen<'b, 'a> {
    pub source: &'b Source<'a>,
    pub marks: &'b [Mark<'a>],
    pub transforms: &'b Transforms,
    pub budget: &'b mut Budget,
    /// Chains of pieces \[mm\].
    pub outlines: Vec<Vec<Piece>>,
    /// What was left out.
    pub warnings: Vec<String>,
    /// How many texts there are.
    pub texts: usize,
    pub letters: Letters,
    /// How many outlines lie outside of what they are clipped to, and how many partly.
    pub outside: (usize, usize),
}

/// What lies round an outline.
#[derive(Clone, Copy)]
struct Round<'c> {
    map: Affine,
    clips: Option<&'c Clip<'c>>,
}

impl<'a> Seen<'_, 'a> {
    /// Draws all that is seen; `to_mm` maps the px of the document.
    ///
    /// # Errors
    /// [`DrawingError`] at the element that cannot be engraved.
    pub fn draw(&mut self, tree: &usvg::Tree, to_mm: Affine) -> Result<(), DrawingError> {
        let page = self.source.page();
        let root = self.source.document.root_element();
        let has_page = ["width", "height", "viewBox"].into_iter().any(|name| attribute(root, name).is_some());
        let corners = [Vec2::zeros(), Vec2::new(page.x, 0.0), page, Vec2::new(0.0, page.y)];
        let clip = Clip::page(corners.map(|corner| to_mm.point(corner)));
        let round = Round { map: to_mm, clips: has_page.then_some(&clip) };
        self.children(tree.root(), round)?;
        let (outside, partly) = self.outside;
        if outside > 0 {
            self.tell(format!("{} outside of a viewport or clip path and left out", outlines(outside)));
        }
        if partly > 0 {
            self.tell(format!(
                "{} at least partly outside of the page, of a viewport or of a clip path and engraved whole: cut in the drawing program what is not to be seen",
                outlines(partly)
            ));
        }
        Ok(())
    }

    fn children(&mut self, group: &usvg::Group, round: Round<'_>) -> Result<(), DrawingError> {
        for child in group.children() {
            match child {
                usvg::Node::Group(inner) => self.group(inner, round)?,
                usvg::Node::Path(path) => self.path(path, round)?,
                usvg::Node::Image(_) | usvg::Node::Text(_) => {}
            }
        }
        Ok(())
    }

    fn group(&mut self, group: &usvg::Group, round: Round<'_>) -> Result<(), DrawingError> {
        if group.opacity().get() <= 0.0 {
            return Ok(());
        }
        let map = round.map.after(&self.transforms.exact(group.transform()));
        if group.mask().is_some() {
            self.tell("masks are not applied: what they hide is engraved".to_owned());
        }
        if !group.filters().is_empty() {
            self.tell("filters are not applied".to_owned());
        }
        let Some(path) = group.clip_path() else {
            return self.children(group, Round { map, ..round });
        };
        let clip = Clip::of(path, &map, round.clips);
        self.children(group, Round { map, clips: Some(&clip) })
    }

    fn path(&mut self, path: &usvg::Path, round: Round<'_>) -> Result<(), DrawingError> {
        let is_filled = path.fill().is_some_and(|fill| fill.opacity().get() > 0.0);
        let is_stroked = path.stroke().is_some_and(|stroke| stroke.opacity().get() > 0.0);
        if !path.is_visible() || !(is_filled || is_stroked) {
            return Ok(());
        }
        let paints = [path.fill().map(usvg::Fill::paint), path.stroke().map(usvg::Stroke::paint)];
        if paints.into_iter().flatten().any(|paint| matches!(paint, usvg::Paint::Pattern(_))) {
            self.tell("patterns are not engraved, only the outlines that they fill".to_owned());
        }
        let outline = path.data();
        let start = outline.points().first().copied().unwrap_or_default();
        let mark = number(start.x, start.y).and_then(|k| self.marks.get(k)).copied();
        match mark {
            Some(Mark::Shape(node)) => {
                let chains = self.source.shape(node)?;
                let chains = self.dashed(Some(node), chains, path.stroke())?;
                self.keep(Some(node), chains, round)
            }
            Some(Mark::Text(node)) => {
                self.texts += 1;
                self.text(node, f64::from(outline.bounds().width()), round)
            }
            Some(Mark::Other(node)) => self.other(node),
            None => {
                let chains = self.dashed(None, chains_of(outline), path.stroke())?;
                self.keep(None, chains, round)
            }
        }
    }

    fn other(&mut self, node: Node<'a, 'a>) -> Result<(), DrawingError> {
        let place = self.source.place(node);
        match name_of(node) {
            "use" => {
                return Err(DrawingError::Malformed {
                    at: place,
                    what: format!("<use> of \"{}\", which is not in the file", quoted(href(node), 60)),
                    help: "open it in the drawing program, unlink the clones and save it again".to_owned(),
                });
            }
            "image" => {
                const TOLD: &str = "images are not engraved: trace them to paths first";
                if !self.warnings.iter().any(|warning| warning.ends_with(TOLD)) {
                    self.warnings.push(format!("{place}: {TOLD}"));
                }
            }
            _ => self.tell(format!(
                "{place}: flowed text left out: convert it to text (Inkscape: Text > Unflow) or to paths"
            )),
        }
        Ok(())
    }

    fn text(&mut self, node: Node<'a, 'a>, size: f64, round: Round<'_>) -> Result<(), DrawingError> {
        let stated = self.source.font_size(node);
        // usvg's size is that where the text is used, good to `f32`.
        let size = if (stated - size).abs() <= 1e-6 * size { stated } else { size };
        let written = self.letters.write(self.source, node, size, self.budget);
        let written = match written {
            Err(DrawingError::Unsupported { what, help, .. }) => {
                let place = self.source.place(node);
                self.tell(format!("{place}: {what}, left out: {help}"));
                return Ok(());
            }
            other => other?,
        };
        for told in written.told {
            self.tell(told);
        }
        for (map, chains) in written.lines {
            self.keep(Some(node), chains, Round { map: round.map.after(&map), ..round })?;
        }
        Ok(())
    }

    /// The dashes of an outline, or the outline where it has none.
    fn dashed(
        &mut self,
        node: Option<Node<'a, 'a>>,
        chains: Vec<Vec<Piece>>,
        stroke: Option<&usvg::Stroke>,
    ) -> Result<Vec<Vec<Piece>>, DrawingError> {
        let stated = node.map(|node| self.stated_dashes(node)).transpose()?.flatten();
        let seen = stroke.and_then(|stroke| {
            let list: Vec<f64> = stroke.dasharray()?.iter().copied().map(f64::from).collect();
            Some((list, f64::from(stroke.dashoffset())))
        });
        let pattern = match (stroke, seen, stated) {
            (Some(_), None, _) | (None, _, None) => None,
            (Some(_), Some(seen), None) => Some(seen),
            // As stated, where that is what usvg has rounded: to `f32`, and an odd list twice.
            (Some(_), Some(seen), Some(stated)) => {
                let near = |a: f64, b: f64| (a - b).abs() <= 1e-5 * (a.abs() + b.abs());
                let twice = stated.0.iter().chain(&stated.0);
                let same =
                    seen.0.len() <= 2 * stated.0.len() && seen.0.iter().zip(twice).all(|(a, b)| near(*a, *b));
                Some(if same && near(seen.1, stated.1) { stated } else { seen })
            }
            // Only dashes are stated, and no colour: they are meant.
            (None, _, Some(stated)) => {
                let inherited = |node| self.source.cascade.inherited(node, "stroke");
                node.is_some_and(|node| inherited(node).is_none()).then_some(stated)
            }
        };
        let Some((list, offset)) = pattern else { return Ok(chains) };
        let length: f64 = chains.iter().flatten().map(Piece::length).sum();
        // `pathLength` is what its author takes the outline's length for.
        let said = match node {
            Some(node) => self.source.length(node, "pathLength", 'd')?,
            None => None,
        };
        let scale = said.filter(|&said| said >= 0.0).map_or(1.0, |said| length / said);
        let pattern = Pattern::new(list.iter().map(|length| scale * length).collect(), scale * offset);
        let Some(pattern) = pattern else { return Ok(chains) };
        let pieces = chains.iter().map(Vec::len).sum();
        if pattern.count(pieces, length) > self.budget.limits().pieces as f64 {
            self.take(usize::MAX, node)?;
        }
        let has_caps = match (stroke, node) {
            (Some(stroke), _) => stroke.linecap() != usvg::LineCap::Butt,
            (None, Some(node)) => {
                let cap = self.source.cascade.inherited(node, "stroke-linecap");
                matches!(cap.as_deref(), Some("round" | "square"))
            }
            (None, None) => false,
        };
        if pattern.has_dots() && has_caps {
            const TOLD: &str = "the dots of a dashed line are not engraved: draw them as small circles";
            if !self.warnings.iter().any(|warning| warning.ends_with(TOLD)) {
                self.warnings.push(format!("{}: {TOLD}", self.place(node)));
            }
        }
        Ok(chains.iter().flat_map(|chain| pattern.cut(chain)).collect())
    }

    /// Dashes and offset [px] as the document states them for an element; `None` for none.
    fn stated_dashes(&self, node: Node<'a, 'a>) -> Result<Option<(Vec<f64>, f64)>, DrawingError> {
        if !self.source.mentions.dashes {
            return Ok(None);
        }
        let cascade = &self.source.cascade;
        let bad = |name: &str, why: &str| {
            let at = node.ancestors().find(|n| cascade.own(*n, name).is_some()).unwrap_or(node);
            self.source.bad_data(at, name, 0, why)
        };
        let Some(list) = cascade.inherited(node, "stroke-dasharray") else {
            return match cascade.inherited(node, "stroke-dashoffset").map(|text| dashes::offset(&text)) {
                Some(Err(why)) => Err(bad("stroke-dashoffset", &why)),
                _ => Ok(None),
            };
        };
        let lengths = dashes::lengths(&list).map_err(|why| bad("stroke-dasharray", &why))?;
        let offset = match cascade.inherited(node, "stroke-dashoffset") {
            Some(text) => dashes::offset(&text).map_err(|why| bad("stroke-dashoffset", &why))?,
            None => svgtypes::Length::zero(),
        };
        let px = |length| self.source.px(node, length, 'd');
        let list: Vec<f64> = lengths.into_iter().map(px).collect();
        Ok((!list.is_empty()).then(|| (list, px(offset))))
    }

    fn keep(
        &mut self,
        node: Option<Node<'a, 'a>>,
        chains: Vec<Vec<Piece>>,
        round: Round<'_>,
    ) -> Result<(), DrawingError> {
        let mut partly = false;
        for chain in chains {
            self.take(chain.len(), node)?;
            let chain: Vec<Piece> = chain.iter().map(|piece| piece.transformed(&round.map)).collect();
            if let Some(bad) = chain.iter().find(|piece| !piece.is_sane()) {
                let p = bad.start();
                let value = if p.x.abs() < 1e7 { p.y } else { p.x };
                let name = node.map_or("path", |node| node.tag_name().name());
                let what = format!("a coordinate of <{}>", quoted(name, 60));
                return Err(DrawingError::OutOfRange { at: self.place(node), what, value });
            }
            match shown(&chain, round.clips) {
                Within::Whole => {}
                Within::Part => partly = true,
                Within::Nothing => {
                    self.outside.0 += 1;
                    continue;
                }
            }
            self.outlines.push(chain);
        }
        self.outside.1 += usize::from(partly);
        Ok(())
    }

    fn take(&mut self, count: usize, node: Option<Node<'a, 'a>>) -> Result<(), DrawingError> {
        let source = self.source;
        self.budget.take(count, || node.map_or_else(|| Place::file(source.file), |node| source.place(node)))
    }

    fn place(&self, node: Option<Node<'a, 'a>>) -> Place {
        node.map_or_else(|| Place::file(self.source.file), |node| self.source.place(node))
    }

    fn tell(&mut self, what: String) {
        if self.warnings.len() < MOST_WARNINGS && !self.warnings.contains(&what) {
            self.warnings.push(what);
        }
    }
}

fn outlines(count: usize) -> String {
    if count == 1 { "an outline is".to_owned() } else { format!("{count} outlines are") }
}

/// How much of an outline is seen within what clips it.
fn shown(chain: &[Piece], clips: Option<&Clip<'_>>) -> Within {
    let Some(clip) = clips else { return Within::Whole };
    let hull = Bounds::around(chain.iter().flat_map(hull));
    match hull.map_or(Within::Whole, |hull| clip.shows(&hull)) {
        Within::Whole => Within::Whole,
        // What lies within the hull may be less: now it is worth the time.
        _ => Stroke::new(chain.to_vec()).map_or(Within::Whole, |stroke| clip.shows(&stroke.bounds())),
    }
}

/// Points round a piece.
fn hull(piece: &Piece) -> [Vec2; 4] {
    match piece {
        Piece::Line { from, to } => [*from, *to, *from, *to],
        Piece::Cubic(points) => *points,
        Piece::Arc(arc) => {
            let reach = arc.u.abs() + arc.v.abs();
            [arc.centre - reach, arc.centre + reach, arc.centre, arc.centre]
        }
        other => [other.start(), other.end(), other.start(), other.end()],
    }
}

/// An outline as usvg has it.
fn chains_of(outline: &Outline) -> Vec<Vec<Piece>> {
    if let Some(ellipse) = ellipse_of(outline) {
        return vec![vec![ellipse]];
    }
    let at = |p: usvg::tiny_skia_path::Point| Vec2::new(f64::from(p.x), f64::from(p.y));
    let (mut chains, mut chain) = (Vec::new(), Vec::new());
    let (mut here, mut start) = (Vec2::zeros(), Vec2::zeros());
    for segment in outline.segments() {
        let piece = match segment {
            PathSegment::MoveTo(p) => {
                chains.push(std::mem::take(&mut chain));
                here = at(p);
                start = here;
                continue;
            }
            PathSegment::LineTo(p) => Piece::Line { from: here, to: at(p) },
            PathSegment::QuadTo(b, c) => Piece::quadratic(here, at(b), at(c)),
            PathSegment::CubicTo(b, c, d) => Piece::Cubic([here, at(b), at(c), at(d)]),
            PathSegment::Close => Piece::Line { from: here, to: start },
        };
        here = piece.end();
        chain.push(piece);
    }
    chains.push(chain);
    chains.retain(|chain| !chain.is_empty());
    chains
}

/// The ellipse that usvg has made cubics of, 3e-4 of its radius off: of all shapes only an ellipse is cubics alone.
fn ellipse_of(outline: &Outline) -> Option<Piece> {
    let mut corners = Vec::new();
    for segment in outline.segments() {
        match segment {
            PathSegment::MoveTo(p) if corners.is_empty() => corners.push(p),
            PathSegment::CubicTo(_, _, p) => corners.push(p),
            PathSegment::Close => {}
            _ => return None,
        }
    }
    let bounds = Bounds::around(corners.iter().map(|p| Vec2::new(f64::from(p.x), f64::from(p.y))))?;
    let radii = bounds.size() * 0.5;
    let is_ellipse = corners.len() > 4 && radii.x > 0.0 && radii.y > 0.0;
    is_ellipse.then(|| {
        Piece::Arc(EllipticalArc {
            centre: bounds.centre(),
            u: Vec2::new(radii.x, 0.0),
            v: Vec2::new(0.0, radii.y),
            start_angle: 0.0,
            sweep: TAU,
        })
    })
}

/// The map of the px of a document of this height to mm, y turned up.
pub fn to_mm(height: f64) -> Affine {
    Affine::new(units::MM_PER_PX, 0.0, 0.0, -units::MM_PER_PX, 0.0, height * units::MM_PER_PX)
}
