//! The BLOCKS section: what INSERT places.

use super::entity::{self, Entity};
use super::tags::Tags;
use crate::drawing::{Budget, Vec3};
use crate::error::DrawingError;
use std::collections::HashMap;

/// A block: its base point and its entities.
#[derive(Clone, Debug)]
pub struct Block<'a> {
    pub base: Vec3,
    pub entities: Vec<Entity<'a>>,
}

/// Blocks by name, without regard to case.
#[derive(Clone, Debug, Default)]
pub struct Blocks<'a> {
    named: HashMap<String, Block<'a>>,
}

impl<'a> Blocks<'a> {
    /// The block of a name.
    pub fn get(&self, name: &str) -> Option<&Block<'a>> {
        self.named.get(&name.to_ascii_uppercase())
    }
}

/// Reads the section up to its ENDSEC.
pub fn read<'a>(tags: &mut Tags<'a>, budget: &Budget) -> Result<Blocks<'a>, DrawingError> {
    let mut blocks = Blocks::default();
    let mut open: Option<(String, Block<'a>)> = None;
    let file = tags.file();
    let mut count = 0;
    entity::each(tags, "ENDSEC", |entity| {
        count += 1;
        if count > budget.limits().pieces {
            let limit = budget.limits().pieces;
            return Err(DrawingError::TooManyPieces { at: entity.place(file), limit });
        }
        match entity.kind {
            "BLOCK" => {
                let name = entity.text(2).unwrap_or("").to_ascii_uppercase();
                let mut base = Vec3::zeros();
                for (axis, code) in [10, 20, 30].into_iter().enumerate() {
                    base[axis] = entity.number(code, file)?.unwrap_or(0.0);
                }
                open = Some((name, Block { base, entities: Vec::new() }));
            }
            "ENDBLK" => {
                if let Some((name, block)) = open.take() {
                    blocks.named.insert(name, block);
                }
            }
            _ => {
                if let Some((_, block)) = open.as_mut() {
                    block.entities.push(entity);
                }
            }
        }
        Ok(())
    })?;
    Ok(blocks)
}
