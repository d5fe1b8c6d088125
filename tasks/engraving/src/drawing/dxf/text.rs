//! TEXT, ATTRIB and MTEXT in Hershey's single-stroke fonts: height, width factor, rotation, slant and alignment are
//! honoured, the style's own font is not.

use super::codes;
use super::entity::Entity;
use super::space::{self, Space};
use crate::drawing::hershey::{Font, PIECES_OF_A_LETTER};
use crate::drawing::{Affine, Piece, Stroke, Vec2, Vec3};
use crate::error::DrawingError;

/// From line to line of an MTEXT, in capital heights.
const LINE_STEP: f64 = 5.0 / 3.0;
/// How far letters reach below the baseline, in capital heights.
const DESCENT: f64 = 7.0 / 21.0;

/// A text as it is written.
pub struct Written {
    /// Chains of pieces in the text's own plane.
    pub chains: Vec<Vec<Piece>>,
    /// From that plane to the coordinates of the entity.
    pub plane: Space,
    /// Letters that no font here has, which are left out.
    pub missing: Vec<char>,
}

/// Whether the entity is a text. An attribute's definition is one where it is constant: then no attribute stands for it.
pub fn is_text(entity: &Entity<'_>) -> bool {
    matches!(entity.kind, "TEXT" | "MTEXT" | "ATTRIB") || entity.kind == "ATTDEF" && is_constant(entity)
}

/// Whether a definition of an attribute is its value for all inserts.
pub fn is_constant(entity: &Entity<'_>) -> bool {
    entity.flags(70) & 2 == 2
}

/// What a text costs of a budget of curve pieces before it is written.
pub fn cost(entity: &Entity<'_>) -> usize {
    let tags = entity.tags.iter().chain(&entity.embedded);
    let letters = tags.filter(|tag| matches!(tag.code, 1 | 3)).map(|tag| tag.value.len());
    letters.sum::<usize>() * PIECES_OF_A_LETTER
}

/// The strokes of a text.
pub fn written(entity: &Entity<'_>, font: &Font, file: &str) -> Result<Written, DrawingError> {
    if entity.kind == "MTEXT" {
        return several(entity, font, file);
    }
    // An attribute of several lines has them as an MTEXT within.
    if entity.embedded.iter().any(|tag| tag.code == 1) {
        let lines = Entity {
            kind: "MTEXT",
            line: entity.line,
            tags: entity.embedded.clone(),
            embedded: Vec::new(),
            parts: Vec::new(),
        };
        return several(&lines, font, file);
    }
    single(entity, font, file)
}

fn height(entity: &Entity<'_>, file: &str) -> Result<f64, DrawingError> {
    let height = entity.needed(40, file)?;
    if height <= 0.0 {
        return Err(DrawingError::Malformed {
            at: entity.place(file),
            what: format!("{} of height {height}", entity.kind),
            help: "give the text a height in the drawing program".to_owned(),
        });
    }
    Ok(height)
}

fn single(entity: &Entity<'_>, font: &Font, file: &str) -> Result<Written, DrawingError> {
    let mut height = height(entity, file)?;
    let (text, missing) = font.engravable(&codes::of_line(entity.text(1).unwrap_or("")));
    let natural = font.width(&text)?;
    // In an attribute group 73 is the length of its field.
    let up = if entity.kind == "TEXT" { 73 } else { 74 };
    let (across, up) = (entity.flags(72), entity.flags(up));
    let first = entity.point(10, file)?;
    let second = if entity.text(11).is_some() { entity.point(11, file)? } else { first };
    let mut wide = entity.number(41, file)?.filter(|factor| *factor > 0.0).unwrap_or(1.0);
    let mut turn = entity.number(50, file)?.unwrap_or(0.0).to_radians();
    let slant = entity.number(51, file)?.unwrap_or(0.0).to_radians();
    let offset = second - first;
    // Aligned and fitted texts reach from the first point to the second.
    if matches!(across, 3 | 5) && offset.norm() > 1e-9 && natural > 0.0 {
        turn = offset.y.atan2(offset.x);
        if across == 3 {
            height = offset.norm() / (natural * wide);
        } else {
            wide = offset.norm() / (natural * height);
        }
    }
    let back = match across {
        1 | 4 => natural / 2.0,
        2 => natural,
        _ => 0.0,
    };
    let down = match (across, up) {
        (4, _) | (_, 2) => 0.5,
        (_, 3) => 1.0,
        (_, 1) => -DESCENT,
        _ => 0.0,
    };
    let place = if across == 0 && up == 0 || matches!(across, 3 | 5) { first } else { second };
    // Flag 2: mirrored from right to left, 4: upside down.
    let mirrored = if entity.flags(71) & 2 == 2 { -1.0 } else { 1.0 };
    let upside_down = if entity.flags(71) & 4 == 4 { -1.0 } else { 1.0 };
    let map = Affine::translation(place)
        .after(&Affine::rotation(turn))
        .after(&Affine::scaling(height * wide * mirrored, height * upside_down))
        .after(&Affine::new(1.0, 0.0, slant.tan(), 1.0, 0.0, 0.0))
        .after(&Affine::translation(Vec2::new(-back, -down)));
    let at = Vec3::new(0.0, 0.0, entity.number(30, file)?.unwrap_or(0.0));
    let plane = Space::of_object(entity, file)?.after(&Space::translation(at));
    Ok(Written { chains: line(font, &text, &map)?, plane, missing })
}

fn several(entity: &Entity<'_>, font: &Font, file: &str) -> Result<Written, DrawingError> {
    let height = height(entity, file)?;
    let mut missing = Vec::new();
    let lines: Vec<String> = codes::of_paragraphs(&content(entity))
        .iter()
        .map(|line| {
            let (line, lost) = font.engravable(line);
            missing.extend(lost);
            line
        })
        .collect();
    let attachment = entity.flags(71).clamp(1, 9) - 1;
    let step = LINE_STEP * entity.number(44, file)?.filter(|factor| *factor > 0.0).unwrap_or(1.0);
    let tall = 1.0 + step * (lines.len().max(1) - 1) as f64;
    let top = match attachment / 3 {
        0 => 0.0,
        1 => tall / 2.0,
        _ => tall,
    };
    let mut chains = Vec::new();
    for (row, text) in lines.iter().enumerate() {
        let back = font.width(text)? * (attachment % 3) as f64 / 2.0;
        let baseline = top - 1.0 - step * row as f64;
        let map = Affine::scaling(height, height).after(&Affine::translation(Vec2::new(-back, baseline)));
        chains.extend(line(font, text, &map)?);
    }
    Ok(Written { chains, plane: plane_of_paragraphs(entity, file)?, missing })
}

/// The text of an MTEXT: chunks of 250 letters in groups 3, and the last one in group 1, wherever that stands.
fn content(entity: &Entity<'_>) -> String {
    let chunks = entity.tags.iter().filter(|tag| tag.code == 3).map(|tag| tag.value);
    let last = entity.tags.iter().rev().find(|tag| tag.code == 1).map(|tag| tag.value);
    chunks.chain(last).collect()
}

/// Where an MTEXT lies. Its place and its direction, group 11, are not in object coordinates; an angle, group 50, is in
/// its plane. Where both stand, the later one holds (DXF reference).
fn plane_of_paragraphs(entity: &Entity<'_>, file: &str) -> Result<Space, DrawingError> {
    let normal = space::normal(entity, file)?;
    let object = Space::of_object(entity, file)?;
    let direction = match entity.tags.iter().rev().find(|tag| matches!(tag.code, 11 | 50)).map(|tag| tag.code)
    {
        Some(11) => entity.point_in_space(11, file)?,
        _ => {
            let turn = entity.number(50, file)?.unwrap_or(0.0).to_radians();
            object.direction(Vec3::new(turn.cos(), turn.sin(), 0.0))
        }
    };
    let up = normal.cross(&direction).try_normalize(1e-12).unwrap_or(object.direction(Vec3::y()));
    Ok(Space::new([up.cross(&normal), up, normal], entity.point_in_space(10, file)?))
}

fn line(font: &Font, text: &str, map: &Affine) -> Result<Vec<Vec<Piece>>, DrawingError> {
    let strokes = font.line(text)?;
    Ok(strokes.iter().map(|stroke| stroke.transformed(map)).map(Stroke::into_pieces).collect())
}
