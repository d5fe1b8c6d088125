//! SVG: visible shapes and paths become strokes; transforms, units and view boxes are honoured.
//!
//! roxmltree reads the XML, svgtypes the path data, lengths and transforms; arcs stay exact elliptical arcs.
//! Every visible outline is engraved, whether it is stroked or filled; a dashed one as its dashes. Entities of a DTD are refused. Text has no
//! outlines of its own: it is written in Hershey's single-stroke fonts.

mod dashes;
mod outline;
mod path_data;
mod text;
mod tree;
mod units;
mod visibility;

use super::{Budget, Drawing, Import, Stroke};
use crate::error::{DrawingError, Place};
use mrroc::console::quoted;
use mrroc_robots::models::xml::{
    MOST_ATTRIBUTES, MOST_ATTRIBUTES_IN_ALL, MOST_NAMESPACES, TooMuchXml, check_xml,
};
use tree::Walk;

/// Reads an SVG document.
///
/// # Errors
/// [`DrawingError`] at the element or attribute that cannot be engraved.
pub fn read(file: &str, text: &str, budget: &mut Budget) -> Result<Import, DrawingError> {
    modest(file, text, budget)?;
    let options = roxmltree::ParsingOptions { nodes_limit: 1_000_000, ..Default::default() };
    let document =
        roxmltree::Document::parse_with_options(text, options).map_err(|e| xml_error(file, text, &e))?;
    let root = document.root_element();
    if root.tag_name().name() != "svg" {
        return Err(DrawingError::Malformed {
            at: Place::line(file, 1, text.lines().next().unwrap_or("")),
            what: format!("the root element is <{}>, not <svg>", quoted(root.tag_name().name(), 60)),
            help: "give an SVG drawing".to_owned(),
        });
    }
    let mut walk = Walk::new(file, text, &document, budget);
    walk.root(root)?;
    let Walk { outlines, mut warnings, texts, .. } = walk;
    if texts > 0 {
        let what = if texts == 1 { "a text is".to_owned() } else { format!("{texts} texts are") };
        warnings.push(format!(
            "{what} written in single-stroke fonts; convert to paths what must keep its own (Inkscape: Path > Object to Path)"
        ));
    }
    let strokes: Vec<Stroke> = outlines.into_iter().filter_map(Stroke::new).collect();
    Ok(Import { drawing: Drawing { strokes }, warnings, ..Import::default() })
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
