//! One entity: its kind and its tags, with the vertices of a polyline and the attributes of an insert behind it.

use super::tags::{Tag, Tags};
use crate::drawing::{Vec2, Vec3};
use crate::error::{DrawingError, Place};
use mrroc::console::quoted;

/// An entity as it stands in the file.
#[derive(Clone, Debug)]
pub struct Entity<'a> {
    pub kind: &'a str,
    pub line: usize,
    pub tags: Vec<Tag<'a>>,
    /// The tags behind group 101: an object of its own within the entity, whose groups mean other things. AutoCAD 2018
    /// keeps the columns of an MTEXT there, and the lines of an attribute.
    pub embedded: Vec<Tag<'a>>,
    /// The VERTEX entities of a POLYLINE, the ATTRIB entities of an INSERT.
    pub parts: Vec<Entity<'a>>,
}

/// Calls `take` with each entity up to the tag `0 end`.
pub fn each<'a>(
    tags: &mut Tags<'a>,
    end: &str,
    mut take: impl FnMut(Entity<'a>) -> Result<(), DrawingError>,
) -> Result<(), DrawingError> {
    // A POLYLINE or an INSERT whose parts may follow.
    let mut open: Option<Entity<'a>> = None;
    while let Some(start) = tags.next()? {
        if start.code != 0 {
            continue;
        }
        if start.value == end {
            return match open {
                Some(entity) => take(entity),
                None => Ok(()),
            };
        }
        if start.value == "EOF" {
            break;
        }
        let entity = one(start, tags)?;
        match (entity.kind, open.as_mut()) {
            ("VERTEX", Some(whole)) if whole.kind == "POLYLINE" => whole.parts.push(entity),
            ("ATTRIB", Some(whole)) if whole.kind == "INSERT" => whole.parts.push(entity),
            (kind, _) => {
                if let Some(whole) = open.take() {
                    take(whole)?;
                }
                match kind {
                    "SEQEND" => {}
                    "POLYLINE" | "INSERT" => open = Some(entity),
                    _ => take(entity)?,
                }
            }
        }
    }
    Err(tags.truncated("inside a section"))
}

/// The entity that begins with this tag.
fn one<'a>(start: Tag<'a>, tags: &mut Tags<'a>) -> Result<Entity<'a>, DrawingError> {
    let mut entity = Entity {
        kind: start.value,
        line: start.line,
        tags: Vec::new(),
        embedded: Vec::new(),
        parts: Vec::new(),
    };
    let mut within = false;
    while let Some(tag) = tags.next()? {
        match tag.code {
            0 => {
                tags.give_back(tag);
                break;
            }
            101 => within = true,
            // Only codes that geometry uses: a table or a picture may carry megabytes of others.
            code if code >= 300 => {}
            _ if within => entity.embedded.push(tag),
            _ => entity.tags.push(tag),
        }
    }
    Ok(entity)
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

    /// The point of the group codes `code`, `code + 10` and `code + 20`.
    pub fn point_in_space(&self, code: i32, file: &str) -> Result<Vec3, DrawingError> {
        let p = self.point(code, file)?;
        Ok(Vec3::new(p.x, p.y, self.number(code + 20, file)?.unwrap_or(0.0)))
    }

    /// The name of its layer.
    pub fn layer(&self) -> &'a str {
        self.text(8).filter(|name| !name.is_empty()).unwrap_or("0")
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
