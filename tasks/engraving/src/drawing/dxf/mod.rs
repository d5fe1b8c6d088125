//! DXF (ASCII): LINE, ARC, CIRCLE, ELLIPSE, SPLINE, LWPOLYLINE, POLYLINE, TEXT, MTEXT, INSERT and its attributes of
//! model space become strokes as they are seen from above, texts in single-stroke fonts.
//!
//! The file is read once, tag by tag, so that a million entities cost no memory before they are refused and every
//! message has its line (the crate `dxf` takes 1.7 GB for a million lines and its entities have no lines). Other
//! entities are counted and reported; so is what the drawing hides, by its layer or by itself, which is not engraved.
//! Curves whose ends touch are joined into strokes.

mod blocks;
mod code_page;
mod codes;
mod curves;
mod entity;
mod hidden;
mod layers;
mod reader;
mod space;
mod spline;
mod tags;
mod text;
mod units;

use super::{Affine, Budget, Drawing, Import, Stroke, join_touching};
use crate::error::DrawingError;
pub use code_page::decoded;
use layers::Layers;
use reader::Reader;
use tags::Tags;

/// Reads an ASCII DXF file.
///
/// # Errors
/// [`DrawingError`] at the tag or entity that cannot be engraved.
pub fn read(file: &str, text: &str, budget: &mut Budget) -> Result<Import, DrawingError> {
    let mut tags = Tags::new(file, text);
    let mut units = None;
    let mut reader = Reader::new(file, budget);
    let mut ended = false;
    while let Some(tag) = tags.next()? {
        if tag.code != 0 {
            continue;
        }
        match tag.value {
            "SECTION" => match tags.next()?.map(|name| name.value) {
                Some("HEADER") => units = units::insertion_units(&mut tags)?,
                Some("TABLES") => reader.layers = Layers::read(&mut tags)?,
                Some("BLOCKS") => reader.blocks = blocks::read(&mut tags, reader.budget)?,
                Some("ENTITIES") => {
                    entity::each(&mut tags, "ENDSEC", |entity| reader.model_entity(&entity))?;
                }
                _ => tags.skip_section()?,
            },
            "EOF" => {
                ended = true;
                break;
            }
            _ => {}
        }
    }
    if !ended {
        return Err(tags.truncated("before its EOF"));
    }
    let (scale, unit_warning) = units::scale(units);
    let mut warnings = reader.told(scale);
    warnings.extend(unit_warning);
    let to_mm = Affine::scaling(scale, scale);
    let strokes = reader.chains.into_iter().filter_map(Stroke::new).map(|s| s.transformed(&to_mm)).collect();
    Ok(Import { drawing: Drawing { strokes: join_touching(strokes) }, warnings, ..Import::default() })
}

#[cfg(test)]
mod tests;
