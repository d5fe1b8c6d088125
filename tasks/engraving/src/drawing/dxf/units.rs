//! `$INSUNITS`: what one unit of the drawing is.

use super::tags::Tags;
use crate::error::{DrawingError, Place};

/// The value of `$INSUNITS`, if the header has it; goes on after the header.
pub fn insertion_units(tags: &mut Tags<'_>) -> Result<Option<i64>, DrawingError> {
    let mut units = None;
    while let Some(tag) = tags.next()? {
        match (tag.code, tag.value) {
            (0, "ENDSEC") => return Ok(units),
            (9, "$INSUNITS") => {
                if let Some(value) = tags.next()? {
                    let number = value.value.parse().map_err(|_| DrawingError::Malformed {
                        at: Place::column(tags.file(), value.line, 1, value.value),
                        what: "$INSUNITS is no whole number".to_owned(),
                        help: "set the drawing's units and export it again".to_owned(),
                    })?;
                    units = Some(number);
                }
            }
            _ => {}
        }
    }
    Err(tags.truncated("inside the header"))
}

/// Millimetres of one unit, and a warning where they are assumed.
pub fn scale(units: Option<i64>) -> (f64, Option<String>) {
    let assumed =
        |why: &str| (1.0, Some(format!("{why}: millimetres are assumed (--scale 25.4 for inches)")));
    match units {
        None => assumed("the drawing does not say its units"),
        Some(0) => assumed("the drawing is without units ($INSUNITS 0)"),
        Some(1) => (25.4, None),
        Some(2) => (304.8, None),
        Some(4) => (1.0, None),
        Some(5) => (10.0, None),
        Some(6) => (1000.0, None),
        Some(8) => (25.4e-6, None),
        Some(9) => (0.0254, None),
        Some(10) => (914.4, None),
        Some(11) => (1e-7, None),
        Some(12) => (1e-6, None),
        Some(13) => (1e-3, None),
        Some(14) => (100.0, None),
        Some(other) => assumed(&format!("the drawing's units ($INSUNITS {other}) are none of a plate's")),
    }
}
