//! The document as its author wrote it: places for messages, and numbers in `f64`.
//!
//! usvg computes in `f32`, which is not enough for 2 um: it says what is seen, where and with which stroke, and the
//! outlines themselves are read here.

use super::cascade::{Cascade, attribute};
use super::{outline, path_data, units};
use crate::drawing::{Piece, Vec2};
use crate::error::{DrawingError, Place};
use mrroc::console::quoted;
use roxmltree::{Document, Node};
use std::str::FromStr;

/// The namespace of SVG's elements.
const SVG: &str = "http://www.w3.org/2000/svg";

/// Lengths of these shapes, and whether each is one of the width (`x`), the height (`y`) or the diagonal (`d`).
const SHAPES: &[(&str, &[(&str, char)])] = &[
    ("path", &[]),
    ("polyline", &[]),
    ("polygon", &[]),
    ("line", &[("x1", 'x'), ("y1", 'y'), ("x2", 'x'), ("y2", 'y')]),
    ("circle", &[("cx", 'x'), ("cy", 'y'), ("r", 'd')]),
    ("ellipse", &[("cx", 'x'), ("cy", 'y'), ("rx", 'x'), ("ry", 'y')]),
    ("rect", &[("x", 'x'), ("y", 'y'), ("width", 'x'), ("height", 'y'), ("rx", 'x'), ("ry", 'y')]),
];

/// The document and what is looked up in it.
pub struct Source<'a> {
    pub file: &'a str,
    pub text: &'a str,
    pub document: &'a Document<'a>,
    pub cascade: Cascade<'a>,
    /// Most pieces of a path.
    pub most: usize,
    pub mentions: Mentions,
}

/// Whether a document says anything of what few documents have: each outline need not be asked then.
#[derive(Clone, Copy)]
pub struct Mentions {
    pub markers: bool,
    pub dashes: bool,
}

impl Mentions {
    /// Of this document.
    pub fn of(text: &str) -> Self {
        Self {
            markers: text.contains("arker") || text.contains("ARKER"),
            dashes: text.contains("ash") || text.contains("ASH"),
        }
    }
}

/// The name of an element of SVG; empty for one of another namespace.
pub fn name_of<'a>(node: Node<'a, '_>) -> &'a str {
    let is_svg = matches!(node.tag_name().namespace(), None | Some(SVG));
    if node.is_element() && is_svg { node.tag_name().name() } else { "" }
}

/// The names of a shape's lengths; `None` for what is no shape.
pub fn lengths_of(name: &str) -> Option<&'static [(&'static str, char)]> {
    SHAPES.iter().find(|(shape, _)| *shape == name).map(|(_, lengths)| *lengths)
}

impl<'a> Source<'a> {
    /// The outline of a shape in its own units; nothing for what is no shape.
    ///
    /// # Errors
    /// [`DrawingError::Malformed`] at the attribute that cannot be read.
    pub fn shape(&self, node: Node<'a, 'a>) -> Result<Vec<Vec<Piece>>, DrawingError> {
        let name = name_of(node);
        let at = |n: &str, axis| self.length(node, n, axis).map(|l| l.unwrap_or(0.0));
        let chain = match name {
            "path" => {
                let data = attribute(node, "d").unwrap_or("");
                return path_data::chains(data, self.most)
                    .map_err(|(at, why)| self.bad_data(node, "d", at, &why));
            }
            "rect" => {
                let (rx, ry) = self.radii(node)?;
                let width = self.size(node, "width", 'x')?.unwrap_or(0.0);
                let height = self.size(node, "height", 'y')?.unwrap_or(0.0);
                if width <= 0.0 || height <= 0.0 {
                    return Ok(Vec::new());
                }
                outline::rectangle(at("x", 'x')?, at("y", 'y')?, width, height, rx, ry)
            }
            "circle" => {
                let r = self.size(node, "r", 'd')?.unwrap_or(0.0);
                outline::ellipse(Vec2::new(at("cx", 'x')?, at("cy", 'y')?), r, r)
            }
            "ellipse" => {
                let (rx, ry) = self.radii(node)?;
                outline::ellipse(Vec2::new(at("cx", 'x')?, at("cy", 'y')?), rx, ry)
            }
            "line" => outline::polyline(&[
                Vec2::new(at("x1", 'x')?, at("y1", 'y')?),
                Vec2::new(at("x2", 'x')?, at("y2", 'y')?),
            ]),
            "polyline" | "polygon" => {
                let list = attribute(node, "points").unwrap_or("");
                let points = svgtypes::PointsParser::from(list).map(|(x, y)| Vec2::new(x, y));
                let mut points: Vec<Vec2> = points.take(self.most + 2).collect();
                if name == "polygon" && points.len() > 1 {
                    points.push(points[0]);
                }
                outline::polyline(&points)
            }
            _ => return Ok(Vec::new()),
        };
        Ok(vec![chain])
    }

    /// Radii of a rectangle's corners or of an ellipse: one that is not given is as the other.
    fn radii(&self, node: Node<'a, 'a>) -> Result<(f64, f64), DrawingError> {
        let (rx, ry) = (self.size(node, "rx", 'x')?, self.size(node, "ry", 'y')?);
        Ok((rx.or(ry).unwrap_or(0.0), ry.or(rx).unwrap_or(0.0)))
    }

    /// Whether a shape has lengths of its viewport, and whether of its font: these depend on where it is used.
    pub fn relative(&self, node: Node<'a, 'a>) -> (bool, bool) {
        let lengths = lengths_of(name_of(node)).unwrap_or(&[]);
        let said = lengths.iter().filter_map(|(name, _)| attribute(node, name));
        let said = said.filter_map(|text| svgtypes::Length::from_str(text).ok());
        said.filter(|length| units::is_relative(*length)).fold((false, false), |(viewport, font), length| {
            let is_percent = length.unit == svgtypes::LengthUnit::Percent;
            (viewport || is_percent, font || !is_percent)
        })
    }

    /// An attribute's length in px; `None` where it is not given.
    ///
    /// # Errors
    /// [`DrawingError::Malformed`] for what is no length.
    pub fn length(&self, node: Node<'a, 'a>, name: &str, axis: char) -> Result<Option<f64>, DrawingError> {
        match attribute(node, name) {
            None | Some("auto") => Ok(None),
            Some(text) => match svgtypes::Length::from_str(text) {
                Ok(length) => Ok(Some(self.px(node, length, axis))),
                Err(e) => Err(self.bad_data(node, name, 0, &e.to_string())),
            },
        }
    }

    /// A length in px at an element.
    pub fn px(&self, node: Node<'a, 'a>, length: svgtypes::Length, axis: char) -> f64 {
        if let Some(px) = units::absolute(length) {
            return px;
        }
        let whole = if length.unit == svgtypes::LengthUnit::Percent { self.whole(node, axis) } else { 0.0 };
        units::to_px(length, whole, self.font_size(node))
    }

    /// What percentages of an element's lengths are of [px].
    pub fn whole(&self, node: Node<'a, 'a>, axis: char) -> f64 {
        let viewport = self.viewport(node);
        match axis {
            'x' => viewport.x,
            'y' => viewport.y,
            // Of the viewport's diagonal, normalised.
            _ => (viewport.norm_squared() / 2.0).sqrt(),
        }
    }

    /// A length that is no size if it is negative: other programs draw nothing there, or something else.
    fn size(&self, node: Node<'a, 'a>, name: &str, axis: char) -> Result<Option<f64>, DrawingError> {
        match self.length(node, name, axis)? {
            Some(length) if length < 0.0 => Err(self.bad_data(node, name, 0, "it is negative")),
            length => Ok(length),
        }
    }

    /// Width and height [px] of the viewport round an element, in that viewport's own units.
    pub fn viewport(&self, node: Node<'a, 'a>) -> Vec2 {
        let outer = node.ancestors().skip(1).find(|n| matches!(name_of(*n), "svg" | "symbol"));
        let Some(outer) = outer else { return Vec2::new(300.0, 150.0) };
        if let Ok(Some(view)) = self.view_box(outer) {
            return Vec2::new(view.w, view.h);
        }
        self.extent(outer)
    }

    /// Width and height [px] of an `svg` or `symbol` in the units round it.
    pub fn extent(&self, svg: Node<'a, 'a>) -> Vec2 {
        if svg.parent_element().is_none() {
            return self.page();
        }
        let side = |name, axis| match self.length(svg, name, axis) {
            Ok(Some(length)) => length,
            _ => self.whole(svg, axis),
        };
        Vec2::new(side("width", 'x'), side("height", 'y'))
    }

    /// Width and height [px] of the document. Without them the view box is in px (CSS: 100 % of an unknown page).
    pub fn page(&self) -> Vec2 {
        let svg = self.document.root_element();
        let view = self.view_box(svg).ok().flatten();
        let whole = view.map_or(Vec2::new(300.0, 150.0), |v| Vec2::new(v.w, v.h));
        let side = |name, whole| {
            let length = svgtypes::Length::from_str(attribute(svg, name)?).ok()?;
            Some(units::to_px(length, whole, self.font_size(svg)))
        };
        match (side("width", whole.x), side("height", whole.y)) {
            (Some(w), Some(h)) => Vec2::new(w, h),
            (Some(w), None) => Vec2::new(w, w * whole.y / whole.x),
            (None, Some(h)) => Vec2::new(h * whole.x / whole.y, h),
            (None, None) => whole,
        }
    }

    /// The view box of an element.
    ///
    /// # Errors
    /// [`DrawingError::Malformed`] for what is no view box.
    pub fn view_box(&self, node: Node<'a, 'a>) -> Result<Option<svgtypes::ViewBox>, DrawingError> {
        let parsed = attribute(node, "viewBox").map(svgtypes::ViewBox::from_str).transpose();
        parsed.map_err(|e| self.bad_data(node, "viewBox", 0, &e.to_string()))
    }

    /// The size of the font [px] at an element.
    pub fn font_size(&self, node: Node<'a, 'a>) -> f64 {
        let elements: Vec<_> = node.ancestors().filter(Node::is_element).collect();
        elements.into_iter().rev().fold(16.0, |size, node| {
            let own = self.cascade.own(node, "font-size");
            own.and_then(|text| font_size(&text, size)).unwrap_or(size)
        })
    }

    /// The place of an element.
    pub fn place(&self, node: Node<'a, 'a>) -> Place {
        self.place_at(node.range().start)
    }

    fn place_at(&self, byte: usize) -> Place {
        let pos = self.document.text_pos_at(byte);
        let line = self.text.lines().nth((pos.row as usize).saturating_sub(1)).unwrap_or("");
        Place::column(self.file, pos.row as usize, pos.col as usize, line)
    }

    /// What is wrong with an attribute, `offset` bytes into its value.
    pub fn bad_data(&self, node: Node<'a, 'a>, name: &str, offset: usize, why: &str) -> DrawingError {
        let start = node.attribute_node(name).map_or(node.range().start, |a| a.range_value().start);
        let mut byte = (start + offset).min(self.text.len());
        while !self.text.is_char_boundary(byte) {
            byte -= 1;
        }
        DrawingError::Malformed {
            at: self.place_at(byte),
            what: format!("<{}> has a bad {name}: {why}", quoted(node.tag_name().name(), 60)),
            help: "open it in the drawing program and save it again".to_owned(),
        }
    }
}

/// A font's size [px] where that of the element round it is `parent`.
pub fn font_size(text: &str, parent: f64) -> Option<f64> {
    let steps = match text {
        "xx-small" => -3,
        "x-small" => -2,
        "small" | "smaller" => -1,
        "medium" => 0,
        "large" | "larger" => 1,
        "x-large" => 2,
        "xx-large" => 3,
        _ => {
            let length: svgtypes::Length = text.parse().ok()?;
            let size = units::to_px(length, parent, parent);
            return (size.is_finite() && size > 0.0).then_some(size);
        }
    };
    let base = if matches!(text, "smaller" | "larger") { parent } else { 16.0 };
    Some(base * 1.2_f64.powi(steps))
}
