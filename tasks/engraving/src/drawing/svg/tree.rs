//! The walk through the element tree, with transform and visibility inherited.

use super::dashes::{self, Dashing, Pattern};
use super::text::Lettering;
use super::visibility::{Visibility, inherited, is_switched_off, property};
use super::{outline, path_data, units};
use crate::drawing::hershey::Font;
use crate::drawing::{Affine, Budget, Piece, Vec2};
use crate::error::{DrawingError, Place};
use mrroc::console::quoted;
use roxmltree::{Document, Node};
use std::collections::HashMap;
use std::rc::Rc;
use std::str::FromStr;

/// Elements that draw nothing by themselves.
const NEVER_DRAWN: &[&str] = &[
    "defs",
    "symbol",
    "clipPath",
    "mask",
    "pattern",
    "marker",
    "linearGradient",
    "radialGradient",
    "filter",
    "font",
    "glyph",
    "style",
    "script",
    "metadata",
    "title",
    "desc",
    "namedview",
    "animate",
    "set",
];

/// What is inherited on the way down.
#[derive(Clone, Copy)]
pub struct Inherited {
    pub(super) map: Affine,
    pub(super) visibility: Visibility,
    /// Width and height of the viewport [px], for percentages.
    pub(super) viewport: Vec2,
    pub(super) lettering: Lettering,
    pub(super) dashing: Dashing,
    pub(super) depth: usize,
}

/// The walk and what it has found.
pub struct Walk<'a> {
    file: &'a str,
    text: &'a str,
    document: &'a Document<'a>,
    budget: &'a mut Budget,
    ids: HashMap<&'a str, Node<'a, 'a>>,
    /// Chains of pieces \[mm\].
    pub outlines: Vec<Vec<Piece>>,
    /// What was left out.
    pub warnings: Vec<String>,
    /// How many texts there are.
    pub texts: usize,
    /// Fonts that were read.
    pub(super) fonts: Vec<(&'static str, Rc<Font>)>,
    used: usize,
    /// The lists of lengths of dashes that were read.
    dashes: Vec<Vec<svgtypes::Length>>,
}

impl<'a> Walk<'a> {
    /// A walk that has not begun.
    pub fn new(file: &'a str, text: &'a str, document: &'a Document<'a>, budget: &'a mut Budget) -> Self {
        let ids = document.descendants().filter_map(|n| Some((n.attribute("id")?, n))).collect();
        Self {
            file,
            text,
            document,
            budget,
            ids,
            outlines: Vec::new(),
            warnings: Vec::new(),
            texts: 0,
            fonts: Vec::new(),
            used: 0,
            dashes: Vec::new(),
        }
    }

    /// The whole document: its size in mm, y turned up.
    pub fn root(&mut self, svg: Node<'a, 'a>) -> Result<(), DrawingError> {
        let view = self.view_box(svg)?;
        // Without width and height the view box is in px (CSS: 100 % of an unknown page).
        let (fallback_w, fallback_h) = view.map_or((300.0, 150.0), |v| (v.w, v.h));
        let viewport = Vec2::new(fallback_w, fallback_h);
        let width = self.length(svg, "width", viewport.x)?;
        let height = self.length(svg, "height", viewport.y)?;
        let (width, height) = match (width, height) {
            (Some(w), Some(h)) => (w, h),
            (Some(w), None) => (w, w * fallback_h / fallback_w),
            (None, Some(h)) => (h * fallback_w / fallback_h, h),
            (None, None) => (fallback_w, fallback_h),
        };
        let to_mm =
            Affine::new(units::MM_PER_PX, 0.0, 0.0, -units::MM_PER_PX, 0.0, height * units::MM_PER_PX);
        let (map, viewport) = match view {
            Some(view) => {
                let inner = units::view_box_map(view, width, height, svg.attribute("preserveAspectRatio"));
                (to_mm.after(&inner), Vec2::new(view.w, view.h))
            }
            None => (to_mm, Vec2::new(width, height)),
        };
        if is_switched_off(svg) {
            return Ok(());
        }
        let visibility = inherited(svg, Visibility::Visible);
        let lettering = Lettering::default().inherited(svg);
        let dashing = self.dashing(svg, Dashing::default())?;
        self.children(svg, Inherited { map, visibility, viewport, lettering, dashing, depth: 0 })
    }

    fn children(&mut self, parent: Node<'a, 'a>, from: Inherited) -> Result<(), DrawingError> {
        for child in parent.children().filter(Node::is_element) {
            self.element(child, from)?;
        }
        Ok(())
    }

    fn element(&mut self, node: Node<'a, 'a>, mut from: Inherited) -> Result<(), DrawingError> {
        let name = node.tag_name().name();
        if NEVER_DRAWN.contains(&name) || is_switched_off(node) {
            return Ok(());
        }
        from.depth += 1;
        self.check_depth(from.depth, node)?;
        from.visibility = inherited(node, from.visibility);
        from.lettering = from.lettering.inherited(node);
        from.dashing = self.dashing(node, from.dashing)?;
        if let Some(transform) = node.attribute("transform") {
            let t = svgtypes::Transform::from_str(transform)
                .map_err(|e| self.bad_attribute(node, "transform", &e.to_string()))?;
            from.map = from.map.after(&Affine::new(t.a, t.b, t.c, t.d, t.e, t.f));
        }
        let visible = from.visibility == Visibility::Visible;
        match name {
            "g" | "a" => self.children(node, from),
            "switch" => match node.children().find(Node::is_element) {
                Some(first) => self.element(first, from),
                None => Ok(()),
            },
            "svg" => self.nested(node, from),
            "use" => self.reuse(node, from),
            "text" => {
                self.texts += 1;
                self.text(node, &from)
            }
            "flowRoot" if visible => {
                let place = self.place(node);
                if self.warnings.len() < 20 {
                    self.warnings.push(format!(
                        "{place}: flowed text left out: convert it to text (Inkscape: Text > Unflow) or to paths"
                    ));
                }
                Ok(())
            }
            "image" if visible => {
                const TOLD: &str = "images are not engraved: trace them to paths first";
                if !self.warnings.iter().any(|warning| warning.ends_with(TOLD)) {
                    self.warnings.push(format!("{}: {TOLD}", self.place(node)));
                }
                Ok(())
            }
            _ if visible => {
                let chains = self.shape(node, name, from.viewport)?;
                let chains = self.dashed(node, chains, &from)?;
                self.keep(node, chains, &from.map)
            }
            _ => Ok(()),
        }
    }

    /// What an element says of its dashes, or inherits.
    fn dashing(&mut self, node: Node<'a, 'a>, from: Dashing) -> Result<Dashing, DrawingError> {
        let mut dashing = from.inherited(node);
        let said = |name| property(node, name).filter(|&value| value != "inherit");
        if let Some(text) = said("stroke-dasharray") {
            let lengths = dashes::lengths(text);
            let lengths = lengths.map_err(|why| self.bad_attribute(node, "stroke-dasharray", &why))?;
            dashing.array = (!lengths.is_empty()).then_some(self.dashes.len());
            self.dashes.push(lengths);
        }
        if let Some(text) = said("stroke-dashoffset") {
            let offset = dashes::offset(text);
            dashing.offset = offset.map_err(|why| self.bad_attribute(node, "stroke-dashoffset", &why))?;
        }
        Ok(dashing)
    }

    /// The dashes of an outline, or the outline where it has none.
    fn dashed(
        &mut self,
        node: Node<'a, 'a>,
        chains: Vec<Vec<Piece>>,
        from: &Inherited,
    ) -> Result<Vec<Vec<Piece>>, DrawingError> {
        let Some(list) = from.dashing.list() else { return Ok(chains) };
        let length: f64 = chains.iter().flatten().map(Piece::length).sum();
        // Percentages are of the viewport's diagonal. `pathLength` is what its author takes the outline's length for.
        let whole = diagonal(from.viewport);
        let said = self.length(node, "pathLength", 1.0)?;
        let scale = said.filter(|&said| said >= 0.0).map_or(1.0, |said| length / said);
        let px = |length: &svgtypes::Length| scale * units::to_px(*length, whole);
        let pattern = Pattern::new(self.dashes[list].iter().map(px).collect(), px(&from.dashing.offset));
        let Some(pattern) = pattern else { return Ok(chains) };
        let pieces = chains.iter().map(Vec::len).sum();
        if pattern.count(pieces, length) > self.budget.limits().pieces as f64 {
            self.take_budget(usize::MAX, node)?;
        }
        if pattern.has_dots() && from.dashing.has_caps() {
            const TOLD: &str = "the dots of a dashed line are not engraved: draw them as small circles";
            if !self.warnings.iter().any(|warning| warning.ends_with(TOLD)) {
                self.warnings.push(format!("{}: {TOLD}", self.place(node)));
            }
        }
        Ok(chains.iter().flat_map(|chain| pattern.cut(chain)).collect())
    }

    pub(super) fn check_depth(&self, depth: usize, node: Node<'a, 'a>) -> Result<(), DrawingError> {
        self.budget.depth(depth, "elements", || Self::place_of(self.file, self.text, self.document, node))
    }

    pub(super) fn take_budget(&mut self, count: usize, node: Node<'a, 'a>) -> Result<(), DrawingError> {
        let (file, text, document) = (self.file, self.text, self.document);
        self.budget.take(count, || Self::place_of(file, text, document, node))
    }

    pub(super) fn keep(
        &mut self,
        node: Node<'a, 'a>,
        chains: Vec<Vec<Piece>>,
        map: &Affine,
    ) -> Result<(), DrawingError> {
        for chain in chains {
            self.take_budget(chain.len(), node)?;
            let chain: Vec<Piece> = chain.iter().map(|piece| piece.transformed(map)).collect();
            if let Some(bad) = chain.iter().find(|piece| !piece.is_sane()) {
                let p = bad.start();
                let value = if p.x.abs() < 1e7 { p.y } else { p.x };
                let what = format!("a coordinate of <{}>", quoted(node.tag_name().name(), 60));
                return Err(DrawingError::OutOfRange { at: self.place(node), what, value });
            }
            self.outlines.push(chain);
        }
        Ok(())
    }

    /// A nested `<svg>`, or a `<symbol>` that is used: a viewport of its own.
    fn nested(&mut self, node: Node<'a, 'a>, mut from: Inherited) -> Result<(), DrawingError> {
        let x = self.length(node, "x", from.viewport.x)?.unwrap_or(0.0);
        let y = self.length(node, "y", from.viewport.y)?.unwrap_or(0.0);
        let width = self.length(node, "width", from.viewport.x)?.unwrap_or(from.viewport.x);
        let height = self.length(node, "height", from.viewport.y)?.unwrap_or(from.viewport.y);
        from.map = from.map.after(&Affine::translation(Vec2::new(x, y)));
        from.viewport = Vec2::new(width, height);
        if let Some(view) = self.view_box(node)? {
            let aspect = node.attribute("preserveAspectRatio");
            from.map = from.map.after(&units::view_box_map(view, width, height, aspect));
            from.viewport = Vec2::new(view.w, view.h);
        }
        self.children(node, from)
    }

    fn reuse(&mut self, node: Node<'a, 'a>, mut from: Inherited) -> Result<(), DrawingError> {
        // Uses of uses grow like a power: their number is bounded as their depth is.
        self.used += 1;
        if self.used > 100_000 {
            return Err(DrawingError::TooManyPieces { at: self.place(node), limit: 100_000 });
        }
        let xlink = ("http://www.w3.org/1999/xlink", "href");
        let href = node.attribute("href").or_else(|| node.attribute(xlink)).unwrap_or("");
        let target = href.strip_prefix('#').and_then(|id| self.ids.get(id)).copied();
        let Some(target) = target else {
            return Err(DrawingError::Malformed {
                at: self.place(node),
                what: format!("<use> of \"{}\", which is not in the file", quoted(href, 60)),
                help: "open it in the drawing program, unlink the clones and save it again".to_owned(),
            });
        };
        let x = self.length(node, "x", from.viewport.x)?.unwrap_or(0.0);
        let y = self.length(node, "y", from.viewport.y)?.unwrap_or(0.0);
        from.map = from.map.after(&Affine::translation(Vec2::new(x, y)));
        if target.tag_name().name() == "symbol" {
            from.depth += 1;
            self.budget.depth(from.depth, "elements", || {
                Self::place_of(self.file, self.text, self.document, node)
            })?;
            return self.nested(target, from);
        }
        self.element(target, from)
    }

    fn shape(&self, node: Node<'a, 'a>, name: &str, view: Vec2) -> Result<Vec<Vec<Piece>>, DrawingError> {
        let diagonal = diagonal(view);
        let x = |n| self.length(node, n, view.x).map(|l| l.unwrap_or(0.0));
        let y = |n| self.length(node, n, view.y).map(|l| l.unwrap_or(0.0));
        let chain = match name {
            "path" => {
                let data = node.attribute("d").unwrap_or("");
                return path_data::chains(data, self.budget.limits().pieces)
                    .map_err(|(at, why)| self.bad_data(node, "d", at, &why));
            }
            "rect" => {
                let rx = self.size(node, "rx", view.x)?;
                let ry = self.size(node, "ry", view.y)?;
                let (rx, ry) = (rx.or(ry).unwrap_or(0.0), ry.or(rx).unwrap_or(0.0));
                let width = self.size(node, "width", view.x)?.unwrap_or(0.0);
                let height = self.size(node, "height", view.y)?.unwrap_or(0.0);
                if width <= 0.0 || height <= 0.0 {
                    return Ok(Vec::new());
                }
                outline::rectangle(x("x")?, y("y")?, width, height, rx, ry)
            }
            "circle" => {
                let r = self.size(node, "r", diagonal)?.unwrap_or(0.0);
                outline::ellipse(Vec2::new(x("cx")?, y("cy")?), r, r)
            }
            "ellipse" => {
                let rx = self.size(node, "rx", view.x)?;
                let ry = self.size(node, "ry", view.y)?;
                let (rx, ry) = (rx.or(ry).unwrap_or(0.0), ry.or(rx).unwrap_or(0.0));
                outline::ellipse(Vec2::new(x("cx")?, y("cy")?), rx, ry)
            }
            "line" => outline::polyline(&[Vec2::new(x("x1")?, y("y1")?), Vec2::new(x("x2")?, y("y2")?)]),
            "polyline" | "polygon" => {
                let list = node.attribute("points").unwrap_or("");
                let mut points: Vec<Vec2> =
                    svgtypes::PointsParser::from(list).map(|(x, y)| Vec2::new(x, y)).collect();
                if name == "polygon" && points.len() > 1 {
                    points.push(points[0]);
                }
                outline::polyline(&points)
            }
            _ => return Ok(Vec::new()),
        };
        Ok(vec![chain])
    }

    fn length(&self, node: Node<'a, 'a>, name: &str, whole: f64) -> Result<Option<f64>, DrawingError> {
        match node.attribute(name) {
            None | Some("auto") => Ok(None),
            Some(text) => match svgtypes::Length::from_str(text) {
                Ok(length) => Ok(Some(units::to_px(length, whole))),
                Err(e) => Err(self.bad_attribute(node, name, &e.to_string())),
            },
        }
    }

    /// A length that is no size if it is negative: other programs draw nothing there, or something else.
    fn size(&self, node: Node<'a, 'a>, name: &str, whole: f64) -> Result<Option<f64>, DrawingError> {
        match self.length(node, name, whole)? {
            Some(length) if length < 0.0 => Err(self.bad_attribute(node, name, "it is negative")),
            length => Ok(length),
        }
    }

    fn view_box(&self, node: Node<'a, 'a>) -> Result<Option<svgtypes::ViewBox>, DrawingError> {
        node.attribute("viewBox")
            .map(|text| {
                svgtypes::ViewBox::from_str(text)
                    .map_err(|e| self.bad_attribute(node, "viewBox", &e.to_string()))
            })
            .transpose()
    }

    pub(super) fn place(&self, node: Node<'a, 'a>) -> Place {
        Self::place_of(self.file, self.text, self.document, node)
    }

    fn place_of(file: &str, text: &str, document: &Document<'_>, node: Node<'_, '_>) -> Place {
        Self::place_at(file, text, document, node.range().start)
    }

    fn place_at(file: &str, text: &str, document: &Document<'_>, byte: usize) -> Place {
        let pos = document.text_pos_at(byte);
        let line = text.lines().nth(pos.row as usize - 1).unwrap_or("");
        Place::column(file, pos.row as usize, pos.col as usize, line)
    }

    pub(super) fn bad_attribute(&self, node: Node<'a, 'a>, name: &str, why: &str) -> DrawingError {
        self.bad_data(node, name, 0, why)
    }

    fn bad_data(&self, node: Node<'a, 'a>, name: &str, offset: usize, why: &str) -> DrawingError {
        let start = node.attribute_node(name).map_or(node.range().start, |a| a.range_value().start);
        let mut byte = (start + offset).min(self.text.len());
        while !self.text.is_char_boundary(byte) {
            byte -= 1;
        }
        DrawingError::Malformed {
            at: Self::place_at(self.file, self.text, self.document, byte),
            what: format!("<{}> has a bad {name}: {why}", quoted(node.tag_name().name(), 60)),
            help: "open it in the drawing program and save it again".to_owned(),
        }
    }
}

/// What percentages are of that are neither of the width nor of the height: the viewport's diagonal, normalised.
fn diagonal(viewport: Vec2) -> f64 {
    (viewport.norm_squared() / 2.0).sqrt()
}
