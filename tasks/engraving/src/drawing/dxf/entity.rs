//! One entity: its kind and its tags, with polyline vertices gathered behind it.

use super::tags::{Tag, Tags};
use crate::drawing::{Affine, Vec2};
use crate::error::{DrawingError, Place};
use mrroc::console::quoted;

/// An entity as it stands in the file.
#[derive(Clone, Debug)]
pub struct Entity<'a> {
    pub kind: &'a str,
    pub line: usize,
    pub tags: Vec<Tag<'a>>,
    /// The VERTEX entities of a POLYLINE.
    pub vertices: Vec<Entity<'a>>,
}

/// Calls `take` with each entity up to the tag `0 end`.
pub fn each<'a>(
    tags: &mut Tags<'a>,
    end: &str,
    mut take: impl FnMut(Entity<'a>) -> Result<(), DrawingError>,
) -> Result<(), DrawingError> {
    let mut polyline: Option<Entity<'a>> = None;
    while let Some(start) = tags.next()? {
        if start.code != 0 {
            continue;
        }
        if start.value == end {
            return match polyline {
                Some(entity) => take(entity),
                None => Ok(()),
            };
        }
        if start.value == "EOF" {
            break;
        }
        let mut entity =
            Entity { kind: start.value, line: start.line, tags: Vec::new(), vertices: Vec::new() };
        while let Some(tag) = tags.next()? {
            if tag.code == 0 {
                tags.give_back(tag);
                break;
            }
            // Only codes that geometry uses: a table or a picture may carry megabytes of others.
            if tag.code < 300 {
                entity.tags.push(tag);
            }
        }
        match (entity.kind, polyline.as_mut()) {
            ("VERTEX", Some(open)) => open.vertices.push(entity),
            ("SEQEND" | "ATTRIB", _) => {
                if let Some(open) = polyline.take() {
                    take(open)?;
                }
            }
            (kind, _) => {
                if let Some(open) = polyline.take() {
                    take(open)?;
                }
                if kind == "POLYLINE" {
                    polyline = Some(entity);
                } else {
                    take(entity)?;
                }
            }
        }
    }
    Err(tags.truncated("inside a section"))
}

impl<'a> Entity<'a> {
    /// Where it stands.
    pub fn place(&self, file: &str) -> Place {
        Place::line(file, self.line, self.kind)
    }

    /// The text of a group code.
    pub fn text(&self, code: i32) -> Option<&'a str> {
        self.tags.iter().find(|tag| tag.code == code).map(|tag| tag.value)
    }

    /// The number of a group code, if it stands.
    pub fn number(&self, code: i32, file: &str) -> Result<Option<f64>, DrawingError> {
        match self.tags.iter().find(|tag| tag.code == code) {
            None => Ok(None),
            Some(tag) => number(tag, file).map(Some),
        }
    }

    /// The number of a group code that must stand.
    pub fn needed(&self, code: i32, file: &str) -> Result<f64, DrawingError> {
        self.number(code, file)?.ok_or_else(|| DrawingError::Malformed {
            at: self.place(file),
            what: format!("{} without its group {code}", self.kind),
            help: "the entity is incomplete; export the drawing again".to_owned(),
        })
    }

    /// The point of the group codes `code` and `code + 10`.
    pub fn point(&self, code: i32, file: &str) -> Result<Vec2, DrawingError> {
        Ok(Vec2::new(self.needed(code, file)?, self.number(code + 10, file)?.unwrap_or(0.0)))
    }

    /// A whole number, 0 if it does not stand.
    pub fn flags(&self, code: i32) -> i64 {
        self.text(code).and_then(|text| text.parse().ok()).unwrap_or(0)
    }

    /// Invisible, or in paper space: not part of the model.
    pub fn is_hidden(&self) -> bool {
        self.flags(60) == 1 || self.flags(67) == 1
    }

    /// From object coordinates: an extrusion along -z mirrors x (DXF's arbitrary axis algorithm for that case).
    pub fn extrusion_map(&self) -> Affine {
        let down = self.text(230).and_then(|z| z.parse::<f64>().ok()).is_some_and(|z| z < 0.0);
        let in_object_coordinates = !matches!(self.kind, "LINE" | "ELLIPSE" | "SPLINE" | "POINT");
        if down && in_object_coordinates { Affine::scaling(-1.0, 1.0) } else { Affine::IDENTITY }
    }

    /// The maps of an INSERT: one, or one for each column and row of an array.
    pub fn insertions(&self, file: &str) -> Result<Vec<Affine>, DrawingError> {
        let at = self.point(10, file)?;
        let sx = self.number(41, file)?.unwrap_or(1.0);
        let sy = self.number(42, file)?.unwrap_or(1.0);
        let turn = Affine::rotation(self.number(50, file)?.unwrap_or(0.0).to_radians());
        let columns = self.flags(70).clamp(1, 1000);
        let rows = self.flags(71).clamp(1, 1000);
        let step = Vec2::new(self.number(44, file)?.unwrap_or(0.0), self.number(45, file)?.unwrap_or(0.0));
        let mut maps = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                let shift = Vec2::new(step.x * column as f64, step.y * row as f64);
                let place = Affine::translation(at).after(&turn).after(&Affine::translation(shift));
                maps.push(place.after(&Affine::scaling(sx, sy)));
            }
        }
        Ok(maps)
    }
}

/// A tag's number.
pub fn number(tag: &Tag<'_>, file: &str) -> Result<f64, DrawingError> {
    let at = || Place::column(file, tag.line, 1, tag.value);
    match tag.value.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(value) => Err(DrawingError::OutOfRange { at: at(), what: format!("group {}", tag.code), value }),
        Err(_) => Err(DrawingError::Malformed {
            at: at(),
            what: format!("group {} is \"{}\", no number", tag.code, quoted(tag.value, 60)),
            help: "the file is damaged; export it again".to_owned(),
        }),
    }
}
