//! The document as usvg gets it: with a mark in the place of each outline, text and image.
//!
//! A mark is a path (or a shape of the same name, so that selectors still match) with two points that say which element
//! it stands for. usvg brings it through `use`, `switch`, styles and markers; whoever meets it afterwards knows the element
//! and draws that in `f64`. Marks are also small: usvg never holds a path of a million pieces.

use super::cascade::attribute;
use super::css;
use super::expansion::{Ids, used};
use super::source::{Source, lengths_of, name_of};
use super::text::has_visible_parts;
use crate::error::DrawingError;
use roxmltree::Node;
use std::ops::Range;

/// The ordinate of marks [px]: exact in `f32`, and of no drawing.
const MARKS_AT: f32 = -7_654_321.0;

/// Definitions that are given to usvg without what is in them: nothing of them is engraved, and it would be work for usvg.
const EMPTIED: &[(&str, &str)] = &[
    ("pattern", "<rect width='1' height='1'/>"),
    ("mask", "<rect width='1' height='1' fill='#fff'/>"),
    ("filter", "<feFlood/>"),
    ("linearGradient", "<stop/>"),
    ("radialGradient", "<stop/>"),
];

/// Most definitions of these, which usvg compares with one another.
const MOST_DEFINITIONS: usize = 20_000;

/// Most elements of markers, if all were drawn at each place of each `use`.
const MOST_MARKED: usize = 100_000;

/// What a mark stands for.
#[derive(Clone, Copy)]
pub enum Mark<'a> {
    /// A shape or path.
    Shape(Node<'a, 'a>),
    /// A `<text>`; its mark is one em wide.
    Text(Node<'a, 'a>),
    /// An element that is not engraved, only told of.
    Other(Node<'a, 'a>),
}

/// The marks and the document with them.
pub struct Rewritten<'a> {
    /// For usvg.
    pub text: String,
    /// By their numbers.
    pub marks: Vec<Mark<'a>>,
}

/// The number of the mark that begins at this point, if one does.
pub fn number(x: f32, y: f32) -> Option<usize> {
    (y == MARKS_AT && x >= 0.0 && x.fract() == 0.0).then_some(x as usize)
}

/// Puts marks into a document.
///
/// # Errors
/// [`DrawingError::TooManyPieces`] for more definitions than usvg can compare.
pub fn rewrite<'a>(
    source: &Source<'a>,
    ids: &Ids<'a>,
    uses: usize,
    sheet: &str,
) -> Result<Rewritten<'a>, DrawingError> {
    let mut rewriting = Rewriting {
        source,
        ids,
        sheet: Some(sheet),
        edits: Vec::new(),
        marks: Vec::new(),
        definitions: 0,
        marked: 0,
        largest: 0,
    };
    rewriting.root();
    let marked = rewriting.marked.saturating_mul(rewriting.largest).saturating_mul(1 + uses);
    for (count, limit) in [(rewriting.definitions, MOST_DEFINITIONS), (marked, MOST_MARKED)] {
        if count > limit {
            let at = source.place(source.document.root_element());
            return Err(DrawingError::TooManyPieces { at, limit });
        }
    }
    let Rewriting { mut edits, marks, .. } = rewriting;
    edits.sort_by_key(|(range, _)| range.start);
    let mut text = String::with_capacity(source.text.len());
    let mut done = 0;
    for (range, new) in edits {
        text.push_str(&source.text[done..range.start]);
        text.push_str(&new);
        done = range.end;
    }
    text.push_str(&source.text[done..]);
    Ok(Rewritten { text, marks })
}

struct Rewriting<'b, 'a> {
    source: &'b Source<'a>,
    ids: &'b Ids<'a>,
    /// The style sheet, until it has been put in the place of the first of the document's.
    sheet: Option<&'b str>,
    edits: Vec<(Range<usize>, String)>,
    marks: Vec<Mark<'a>>,
    definitions: usize,
    /// Places for markers.
    marked: usize,
    /// Elements of the largest marker.
    largest: usize,
}

impl<'a> Rewriting<'_, 'a> {
    fn root(&mut self) {
        let root = self.source.document.root_element();
        // usvg takes the size of the drawing for that of a document without one, which moves it.
        let page = self.source.page();
        self.set(root, "width", &page.x.to_string());
        self.set(root, "height", &page.y.to_string());
        self.element(root);
    }

    fn element(&mut self, node: Node<'a, 'a>) {
        let name = name_of(node);
        if let Some((_, content)) = EMPTIED.iter().find(|(emptied, _)| *emptied == name) {
            self.definitions += 1;
            self.empty(node, name, content);
            return;
        }
        match name {
            "marker" => self.largest = self.largest.max(node.descendants().count()),
            "style" => {
                let sheet = self.sheet.take().unwrap_or("");
                let style = self.prefixed(node, "style");
                // Nothing in it may end the element or begin an entity.
                let sheet = sheet.replace('&', "&amp;").replace('<', "&lt;");
                self.edits.push((node.range(), format!("<{style}>{sheet}</{style}>")));
                return;
            }
            "clipPath" => {
                self.definitions += 1;
                if !is_plain_clip(node) {
                    self.empty(node, name, "<path d='M0 0h1v1z'/>");
                }
                return;
            }
            "text" => {
                let k = self.mark(Mark::Text(node));
                let rect = self.prefixed(node, "rect");
                let style = self.source.cascade.style(node);
                let asked = has_visible_parts(&self.source.cascade, node);
                let seen = if asked { " style='visibility:visible'" } else { "" };
                let inner = format!("<{rect} x='{k}' y='{MARKS_AT}' width='1em' height='1'{seen}/>");
                self.replace(node, "g", &style, "", &inner);
                return;
            }
            "image" | "flowRoot" => {
                let k = self.mark(Mark::Other(node));
                let style = self.source.cascade.style(node) + "fill:#000!important;marker:none!important";
                self.replace(node, "path", &style, &path(k), "");
                return;
            }
            "use" if used(node, self.ids).is_none() => {
                let k = self.mark(Mark::Other(node));
                let style = self.source.cascade.style(node) + "fill:#000!important;marker:none!important";
                self.replace(node, "path", &style, &path(k), "");
                return;
            }
            _ => {}
        }
        if lengths_of(name).is_some() {
            self.shape(node, name);
        } else if let Some(style) = attribute(node, "style") {
            self.restyle(node, style, "");
        }
        for inner in node.children().filter(Node::is_element) {
            self.element(inner);
        }
    }

    fn shape(&mut self, node: Node<'a, 'a>, name: &str) {
        let style = attribute(node, "style").unwrap_or("");
        // Markers on what is itself in a marker grow like a power.
        let may_have = self.source.mentions.markers && !node.ancestors().any(|n| name_of(n) == "marker");
        let has_markers = may_have
            && matches!(name, "path" | "line" | "polyline" | "polygon")
            && ["marker", "marker-start", "marker-mid", "marker-end"]
                .into_iter()
                .any(|property| self.source.cascade.inherited(node, property).is_some_and(|v| v != "none"));
        if has_markers {
            // usvg puts markers on a copy, which is itself not seen.
            let style = self.source.cascade.style(node);
            let unseen = style + "fill-opacity:0!important;stroke-opacity:0!important";
            let pieces: usize = self.source.shape(node).map_or(0, |chains| chains.iter().map(Vec::len).sum());
            self.marked += pieces + 2;
            let copy = self.copy(node, name, &unseen, "", "");
            let end = node.range().end;
            self.edits.push((end..end, copy));
            self.restyle(node, attribute(node, "style").unwrap_or(""), "marker:none!important");
        } else if self.source.mentions.markers {
            self.restyle(node, style, "marker:none!important");
        } else if !style.is_empty() {
            self.restyle(node, style, "");
        }
        // Where its lengths depend on where it is used, usvg's outline is taken.
        let depends = |depth: usize| {
            node.ancestors().take(depth).any(|n| matches!(name_of(n), "defs" | "symbol" | "marker"))
        };
        // Percentages are of the nearest view box, wherever that is used.
        let has_view =
            |n: Node<'_, '_>| matches!(name_of(n), "svg" | "symbol") && attribute(n, "viewBox").is_some();
        let to_view = node.ancestors().position(has_view).unwrap_or(usize::MAX);
        let (of_viewport, of_font) = self.source.relative(node);
        if of_viewport && depends(to_view) || of_font && depends(usize::MAX) {
            return;
        }
        let k = self.mark(Mark::Shape(node));
        for (attribute, value) in shape_mark(name, k) {
            self.set(node, attribute, &value);
        }
    }

    fn mark(&mut self, mark: Mark<'a>) -> usize {
        self.marks.push(mark);
        self.marks.len() - 1
    }

    /// The name of an element with its prefix.
    fn qualified(&self, node: Node<'a, 'a>) -> &'a str {
        let tag = &self.source.text[node.range().start + 1..];
        tag.split(|c: char| c.is_ascii_whitespace() || matches!(c, '/' | '>')).next().unwrap_or(tag)
    }

    /// Another name with the prefix of an element.
    fn prefixed(&self, node: Node<'a, 'a>, name: &str) -> String {
        match self.qualified(node).split_once(':') {
            Some((prefix, _)) => format!("{prefix}:{name}"),
            None => name.to_owned(),
        }
    }

    /// Sets an attribute of the element where it stands.
    fn set(&mut self, node: Node<'a, 'a>, name: &str, value: &str) {
        let value = escaped(value);
        let own = node.attributes().find(|a| a.name() == name && a.namespace().is_none());
        self.edits.push(match own {
            Some(own) => (own.range_value(), value),
            None => {
                let behind = node.range().start + 1 + self.qualified(node).len();
                (behind..behind, format!(" {name}='{value}'"))
            }
        });
    }

    /// Puts the `style` so that usvg reads it as browsers do, and what is `more` behind it.
    fn restyle(&mut self, node: Node<'a, 'a>, style: &str, more: &str) {
        let tidy = css::style(style) + more;
        if tidy != style {
            self.set(node, "style", &tidy);
        }
    }

    /// An element of another name with the attributes of this one, except what only this one can have.
    fn copy(&self, node: Node<'a, 'a>, name: &str, style: &str, more: &str, content: &str) -> String {
        const LEFT_OUT: &[&str] = &["style", "d", "x", "y", "dx", "dy", "width", "height", "href"];
        let is_same = name == name_of(node);
        let name = self.prefixed(node, name);
        let mut tag = format!("<{name}");
        for own in node.attributes() {
            let left_out = if is_same {
                own.name() == "id" || own.name() == "style"
            } else {
                LEFT_OUT.contains(&own.name())
            };
            if !left_out {
                tag.push(' ');
                tag.push_str(&self.source.text[own.range()]);
            }
        }
        // Namespaces that the element declares, for its attributes.
        format!("{tag}{} style='{}' {more}>{content}</{name}>", self.declared(node), escaped(style))
    }

    /// The namespaces that an element declares and its parent does not.
    fn declared(&self, node: Node<'a, 'a>) -> String {
        let outer: Vec<_> = node.parent_element().map(|p| p.namespaces().collect()).unwrap_or_default();
        let own = node.namespaces().filter(|own| !outer.contains(own));
        own.map(|own| match own.name() {
            Some(name) => format!(" xmlns:{name}='{}'", escaped(own.uri())),
            None => format!(" xmlns='{}'", escaped(own.uri())),
        })
        .collect()
    }

    fn replace(&mut self, node: Node<'a, 'a>, name: &str, style: &str, more: &str, content: &str) {
        let element = self.copy(node, name, style, more, content);
        self.edits.push((node.range(), element));
    }

    /// Gives a definition another content: one that is shared by all that it is used for.
    fn empty(&mut self, node: Node<'a, 'a>, name: &str, content: &str) {
        let prefix = self.qualified(node).strip_suffix(name).unwrap_or("");
        let content = content.replacen('<', &format!("<{prefix}"), 1);
        let id = attribute(node, "id").unwrap_or("");
        // A gradient without colours paints nothing; its colours may be those of another, to which it refers.
        let has_colours = !name.ends_with("Gradient")
            || node.children().any(|inner| name_of(inner) == "stop")
            || node.attributes().any(|own| own.name() == "href");
        let content = if has_colours { content } else { String::new() };
        let units = match name {
            "pattern" => "patternUnits='userSpaceOnUse' width='1' height='1'",
            "mask" => "maskUnits='userSpaceOnUse' x='-1e6' y='-1e6' width='2e6' height='2e6'",
            "filter" => "filterUnits='userSpaceOnUse' x='-1e6' y='-1e6' width='2e6' height='2e6'",
            _ => "",
        };
        let declared = self.declared(node);
        let element =
            format!("<{prefix}{name}{declared} id='{}' {units}>{content}</{prefix}{name}>", escaped(id));
        self.edits.push((node.range(), element));
    }
}

/// Whether a clip path is one shape in the units of what it clips, of which usvg can say where it lies.
fn is_plain_clip(node: Node<'_, '_>) -> bool {
    let mut inner = node.children().filter(Node::is_element);
    let one = inner.next().filter(|shape| name_of(*shape) == "rect" || name_of(*shape) == "path");
    let is_simple = |node: Node<'_, '_>| {
        ["clip-path", "style", "class", "clipPathUnits"]
            .into_iter()
            .all(|name| attribute(node, name).is_none())
    };
    let is_short = one.and_then(|shape| attribute(shape, "d")).is_none_or(|data| data.len() < 200);
    one.is_some_and(is_simple) && is_short && inner.next().is_none() && is_simple(node)
}

fn path(k: usize) -> String {
    format!("d='{}'", path_mark(k))
}

/// It has an area, as paints need one.
fn path_mark(k: usize) -> String {
    format!("M{k} {MARKS_AT}h1v1z")
}

/// The attributes with which a shape is the mark `k`.
fn shape_mark(name: &str, k: usize) -> Vec<(&'static str, String)> {
    let (x, y, right, below) =
        (k.to_string(), MARKS_AT.to_string(), (k + 1).to_string(), (MARKS_AT + 1.0).to_string());
    let one = || "1".to_owned();
    match name {
        "path" => vec![("d", path_mark(k))],
        "polyline" | "polygon" => vec![("points", format!("{x} {y} {right} {y} {right} {below}"))],
        "line" => vec![("x1", x), ("y1", y), ("x2", right), ("y2", below)],
        "rect" => vec![
            ("x", x),
            ("y", y),
            ("width", one()),
            ("height", one()),
            ("rx", "0".to_owned()),
            ("ry", "0".to_owned()),
        ],
        // usvg begins at three o'clock.
        "circle" => vec![("cx", format!("{}", k as f64 - 1.0)), ("cy", y), ("r", one())],
        _ => vec![("cx", format!("{}", k as f64 - 1.0)), ("cy", y), ("rx", one()), ("ry", one())],
    }
}

fn escaped(text: &str) -> String {
    let mut escaped = text.replace('&', "&amp;");
    for (letter, entity) in [("<", "&lt;"), ("'", "&apos;"), ("\"", "&quot;")] {
        if escaped.contains(letter) {
            escaped = escaped.replace(letter, entity);
        }
    }
    escaped
}
