//! DXF (ASCII): LINE, ARC, CIRCLE, ELLIPSE, SPLINE, LWPOLYLINE, POLYLINE, TEXT, MTEXT and INSERT of model space become
//! strokes, texts in single-stroke fonts.
//!
//! The file is read once, tag by tag, so that a million entities cost no memory before they are refused and every
//! message has its line (the crate `dxf` takes 1.7 GB for a million lines and its entities have no lines). Other
//! entities are counted and reported. Curves whose ends touch are joined into strokes.

mod blocks;
mod curves;
mod entity;
mod spline;
mod tags;
mod text;
mod units;

use super::hershey::Font;
use super::{Affine, Budget, Drawing, Import, Piece, Stroke, join_touching};
use crate::error::DrawingError;
use blocks::Blocks;
use entity::Entity;
use std::collections::BTreeMap;
use tags::Tags;

/// Reads an ASCII DXF file.
///
/// # Errors
/// [`DrawingError`] at the tag or entity that cannot be engraved.
pub fn read(file: &str, text: &str, budget: &mut Budget) -> Result<Import, DrawingError> {
    let mut tags = Tags::new(file, text);
    let mut units = None;
    let mut blocks = Blocks::default();
    let mut reader = Reader {
        file,
        budget,
        chains: Vec::new(),
        left_out: BTreeMap::new(),
        texts: 0,
        font: None,
        warnings: Vec::new(),
    };
    let mut ended = false;
    while let Some(tag) = tags.next()? {
        if tag.code != 0 {
            continue;
        }
        match tag.value {
            "SECTION" => match tags.next()?.map(|name| name.value) {
                Some("HEADER") => units = units::insertion_units(&mut tags)?,
                Some("BLOCKS") => blocks = blocks::read(&mut tags, reader.budget)?,
                Some("ENTITIES") => {
                    entity::each(&mut tags, "ENDSEC", |entity| {
                        reader.entity(&entity, &blocks, &Affine::IDENTITY, 0)
                    })?;
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
    let Reader { chains, left_out, texts, mut warnings, .. } = reader;
    if texts > 0 {
        let what = if texts == 1 { "a text is".to_owned() } else { format!("{texts} texts are") };
        warnings.push(format!(
            "{what} written in a single-stroke font; explode to curves what must keep its own (TXTEXP)"
        ));
    }
    for (kind, count) in left_out {
        warnings
            .push(format!("{count} {kind} left out: explode it to lines, arcs and splines to engrave it"));
    }
    let (scale, unit_warning) = units::scale(units);
    warnings.extend(unit_warning);
    let to_mm = Affine::scaling(scale, scale);
    let strokes = chains.into_iter().filter_map(Stroke::new).map(|s| s.transformed(&to_mm)).collect();
    Ok(Import { drawing: Drawing { strokes: join_touching(strokes) }, warnings, ..Import::default() })
}

/// Entities on their way to chains of pieces.
struct Reader<'a> {
    file: &'a str,
    budget: &'a mut Budget,
    chains: Vec<Vec<Piece>>,
    left_out: BTreeMap<String, usize>,
    /// How many texts there are, and the font for them, once it was read.
    texts: usize,
    font: Option<Font>,
    warnings: Vec<String>,
}

impl Reader<'_> {
    fn entity(
        &mut self,
        entity: &Entity<'_>,
        blocks: &Blocks<'_>,
        map: &Affine,
        depth: usize,
    ) -> Result<(), DrawingError> {
        if entity.is_hidden() {
            return Ok(());
        }
        if entity.kind == "INSERT" {
            return self.insert(entity, blocks, map, depth);
        }
        if text::is_text(entity) {
            self.texts += 1;
            // Every letter has its cost before its curves are computed.
            self.budget.take(text::cost(entity), || entity.place(self.file))?;
            let font = match self.font.take() {
                Some(font) => font,
                None => Font::open("futural")?,
            };
            let chains = text::chains(entity, &font, self.file);
            self.font = Some(font);
            match chains {
                Ok(chains) => {
                    for chain in chains {
                        self.keep(entity, &chain, map)?;
                    }
                }
                // What the font does not have is left out and told.
                Err(DrawingError::Unsupported { at, what, help }) => {
                    if self.warnings.len() < 20 {
                        self.warnings.push(format!("{at}: {what}, left out: {help}"));
                    }
                }
                Err(error) => return Err(error),
            }
            return Ok(());
        }
        match curves::chain(entity, self.file)? {
            Some(chain) => self.keep(entity, &chain, map)?,
            None => *self.left_out.entry(entity.kind.to_owned()).or_insert(0) += 1,
        }
        Ok(())
    }

    fn keep(&mut self, entity: &Entity<'_>, chain: &[Piece], map: &Affine) -> Result<(), DrawingError> {
        self.budget.take(chain.len().max(1), || entity.place(self.file))?;
        let flipped = entity.extrusion_map();
        let chain: Vec<Piece> = chain.iter().map(|p| p.transformed(&map.after(&flipped))).collect();
        if let Some(bad) = chain.iter().find(|piece| !piece.is_sane()) {
            let what = format!("a coordinate of {}", entity.kind);
            let value = bad.start().amax();
            return Err(DrawingError::OutOfRange { at: entity.place(self.file), what, value });
        }
        self.chains.push(chain);
        Ok(())
    }

    fn insert(
        &mut self,
        entity: &Entity<'_>,
        blocks: &Blocks<'_>,
        map: &Affine,
        depth: usize,
    ) -> Result<(), DrawingError> {
        let at = || entity.place(self.file);
        self.budget.depth(depth + 1, "blocks", at)?;
        // An insert costs a piece of the budget itself: empty blocks in blocks would be free otherwise.
        self.budget.take(1, at)?;
        let name = entity.text(2).unwrap_or("");
        let Some(block) = blocks.get(name) else {
            self.warnings
                .push(format!("{}: INSERT of the block {name:?}, which is not in the file, left out", at()));
            return Ok(());
        };
        let own = Affine::translation(-block.base);
        for placed in entity.insertions(self.file)? {
            let map = map.after(&entity.extrusion_map()).after(&placed).after(&own);
            self.budget.take(1, || entity.place(self.file))?;
            for inner in &block.entities {
                self.entity(inner, blocks, &map, depth + 1)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
