//! SVG: what is seen becomes strokes.
//!
//! usvg says what is seen, where and with which stroke: it resolves `use`, `switch`, style sheets, units, viewports and
//! markers. It computes in `f32` and makes cubics of arcs, which is not enough for 2 um: so it is given marks in the place
//! of outlines (`rewrite`), and the outlines behind them are read in `f64` (`source`) and drawn where usvg has put them
//! (`seen`, `exact`). Every outline that is filled or stroked is engraved; a dashed one as its dashes. Entities of a DTD
//! are refused. Text is written in Hershey's single-stroke fonts.

mod cascade;
mod clip;
mod css;
mod dashes;
mod exact;
mod expansion;
mod outline;
mod path_data;
mod prolog;
mod rewrite;
mod seen;
mod source;
mod text;
mod units;

use super::{Budget, Drawing, Import, Stroke};
use crate::error::{DrawingError, Place};
use cascade::Cascade;
use exact::Transforms;
use mrroc::console::quoted;
use mrroc_robots::models::xml::{
    MOST_ATTRIBUTES, MOST_ATTRIBUTES_IN_ALL, MOST_NAMESPACES, TooMuchXml, check_xml,
};
use rewrite::Rewritten;
use roxmltree::Document;
use seen::Seen;
use source::{Mentions, Source};
use text::Letters;

/// Most rules of style sheets.
const MOST_RULES: usize = 5_000;

/// Most comparisons of a rule of a style sheet with an element, of some 100 ns.
const MOST_COMPARED_RULES: usize = 5_000_000;

/// Reads an SVG document.
///
/// # Errors
/// [`DrawingError`] at the element or attribute that cannot be engraved.
pub fn read(file: &str, text: &str, budget: &mut Budget) -> Result<Import, DrawingError> {
    let text = prolog::without_document_type(file, text)?;
    let text = text.as_ref();
    modest(file, text, budget)?;
    let document = parsed(file, text)?;
    let root = document.root_element();
    if root.tag_name().name() != "svg" {
        return Err(DrawingError::Malformed {
            at: Place::line(file, 1, text.lines().next().unwrap_or("")),
            what: format!("the root element is <{}>, not <svg>", quoted(root.tag_name().name(), 60)),
            help: "give an SVG drawing".to_owned(),
        });
    }
    let sheet = cascade::sheets(&document);
    let cascade = cascade(file, &sheet, &document)?;
    let source = Source {
        file,
        text,
        document: &document,
        cascade,
        most: budget.limits().pieces,
        mentions: Mentions::of(text),
    };
    source.view_box(root)?;
    for (name, axis) in [("width", 'x'), ("height", 'y')] {
        source.length(root, name, axis)?;
    }
    let ids = expansion::ids(&source);
    let uses = expansion::check(&source, &ids, budget)?;
    let transforms = Transforms::of(&source, &ids)?;
    let Rewritten { text: rewritten, marks } = rewrite::rewrite(&source, &ids, uses, &sheet)?;
    let tree = resolved(file, &rewritten)?;
    let mut seen = Seen {
        source: &source,
        marks: &marks,
        transforms: &transforms,
        budget,
        outlines: Vec::new(),
        warnings: Vec::new(),
        texts: 0,
        letters: Letters::default(),
        outside: (0, 0),
    };
    seen.draw(&tree, seen::to_mm(source.page().y))?;
    let Seen { outlines, mut warnings, texts, .. } = seen;
    drop(tree);
    let strokes: Vec<Stroke> = outlines.into_iter().filter_map(Stroke::new).collect();
    if texts > 0 {
        let what = if texts == 1 { "a text is".to_owned() } else { format!("{texts} texts are") };
        warnings.push(format!(
            "{what} written in single-stroke fonts; convert to paths what must keep its own (Inkscape: Path > Object to Path)"
        ));
    }
    Ok(Import { drawing: Drawing { strokes }, warnings, ..Import::default() })
}

fn parsed<'a>(file: &str, text: &'a str) -> Result<Document<'a>, DrawingError> {
    let options = roxmltree::ParsingOptions { nodes_limit: 1_000_000, ..Default::default() };
    Document::parse_with_options(text, options).map_err(|e| xml_error(file, text, &e))
}

fn cascade<'a>(file: &str, sheet: &'a str, document: &Document<'_>) -> Result<Cascade<'a>, DrawingError> {
    let rules = sheet.matches(['{', ',']).count();
    let elements = document.descendants().filter(roxmltree::Node::is_element).count();
    for (what, count, limit) in [
        ("rules of style sheets", rules, MOST_RULES),
        (
            "comparisons of rules of style sheets with elements",
            rules.saturating_mul(elements),
            MOST_COMPARED_RULES,
        ),
    ] {
        if count > limit {
            return Err(DrawingError::TooMany { at: Place::file(file), what, limit });
        }
    }
    let sheet = simplecss::StyleSheet::parse(sheet);
    Ok(Cascade::new(sheet, document))
}

/// What usvg makes of the document with marks in it.
fn resolved(file: &str, text: &str) -> Result<usvg::Tree, DrawingError> {
    let failed = |why: String| DrawingError::Malformed {
        at: Place::file(file),
        what: format!("not an SVG drawing: {why}"),
        help: "open it in the drawing program and save it again".to_owned(),
    };
    let options = roxmltree::ParsingOptions { nodes_limit: 2_000_000, ..Default::default() };
    let document = Document::parse_with_options(text, options).map_err(|e| failed(e.to_string()))?;
    // 16 px is the size of a font in browsers. No file is opened for an image.
    let nothing = usvg::ImageHrefResolver {
        resolve_data: Box::new(|_, _, _| None),
        resolve_string: Box::new(|_, _| None),
    };
    let options = usvg::Options { font_size: 16.0, image_href_resolver: nothing, ..usvg::Options::default() };
    usvg::Tree::from_xmltree(&document, &options).map_err(|e| failed(e.to_string()))
}

/// Refuses what only a machine writes, before the XML reader, to which it would be work for minutes, sees it.
fn modest(file: &str, text: &str, budget: &Budget) -> Result<(), DrawingError> {
    let limit = budget.limits().depth * 4;
    check_xml(text, limit).map_err(|error| {
        let at = Place::bare_line(file, error.line());
        let (what, limit) = match error {
            TooMuchXml::Depth { .. } => return DrawingError::TooDeep { at, what: "elements", limit },
            TooMuchXml::Attributes { .. } => ("attributes of an element", MOST_ATTRIBUTES),
            TooMuchXml::AttributesInAll { .. } => {
                ("attributes and namespaces in all", MOST_ATTRIBUTES_IN_ALL)
            }
            TooMuchXml::Namespaces { .. } => {
                ("declarations of namespaces within one another", MOST_NAMESPACES)
            }
        };
        DrawingError::TooMany { at, what, limit }
    })
}

fn xml_error(file: &str, text: &str, error: &roxmltree::Error) -> DrawingError {
    let pos = error.pos();
    let line = pos.row as usize;
    let column = pos.col as usize;
    let source = text.lines().nth(line.saturating_sub(1)).unwrap_or("");
    let at = Place::column(file, line, column, source);
    let message = error.to_string();
    let what = message.split(" at ").next().unwrap_or(&message).to_owned();
    match error {
        roxmltree::Error::DtdDetected | roxmltree::Error::EntityReferenceLoop(_) => {
            DrawingError::Unsupported {
                at,
                what: "a document type declaration: entities are not read".to_owned(),
                help: "save it as plain SVG".to_owned(),
            }
        }
        roxmltree::Error::NodesLimitReached => {
            DrawingError::TooManyPieces { at: Place::file(file), limit: 1_000_000 }
        }
        roxmltree::Error::UnexpectedEndOfStream | roxmltree::Error::UnclosedRootNode => {
            let last = text.lines().count().max(1);
            let source = text.lines().last().unwrap_or("");
            DrawingError::Truncated {
                at: Place::line(file, last, source),
                inside: "inside an element".to_owned(),
            }
        }
        _ => DrawingError::Malformed {
            at,
            what: format!("not well-formed XML: {what}"),
            help: "open it in the drawing program and save it again".to_owned(),
        },
    }
}

#[cfg(test)]
mod tests;
