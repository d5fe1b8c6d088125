//! Reads a file of any known format: size, text and format first, then the format's reader, then what all share.

use super::gcode::Switches;
use super::{Budget, Import, Limits, dxf, gcode, svg};
use crate::error::{DrawingError, Place};
use mrroc::launch::files;
use std::borrow::Cow;
use std::io::Read;
use std::path::Path;

/// How a file is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// How much it may ask for.
    pub limits: Limits,
    /// What is chosen for a G-code program.
    pub gcode: Switches,
}

impl From<Limits> for Reading {
    fn from(limits: Limits) -> Self {
        Self { limits, ..Self::default() }
    }
}

/// The formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Svg,
    Dxf,
    Gcode,
}

impl Format {
    fn of(name: &str, text: &str) -> Option<Self> {
        let extension =
            Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        match extension.as_str() {
            "svg" => return Some(Self::Svg),
            "dxf" => return Some(Self::Dxf),
            "ngc" | "nc" | "gcode" | "gco" | "g" | "tap" | "cnc" | "din" => return Some(Self::Gcode),
            _ => {}
        }
        let head: String = text.chars().take(4000).collect();
        let lines: Vec<&str> = head.lines().take(2).map(str::trim).collect();
        if head.contains("<svg") {
            Some(Self::Svg)
        } else if matches!(lines[..], ["0", "SECTION"] | ["999", _]) {
            Some(Self::Dxf)
        } else if head.lines().any(|l| {
            let l = l.trim_start();
            l.starts_with(['G', 'g', '%', 'O', 'o']) && l.chars().nth(1).is_none_or(|c| c.is_ascii_digit())
        }) {
            Some(Self::Gcode)
        } else {
            None
        }
    }
}

/// Reads a drawing file.
///
/// # Errors
/// [`DrawingError`] with file, line and remedy for anything that cannot be engraved as it stands.
pub fn read_file(path: &Path, reading: impl Into<Reading>) -> Result<Import, DrawingError> {
    let reading = reading.into();
    let limits = reading.limits;
    let file = path.display().to_string();
    let unreadable = |source| DrawingError::Unreadable { file: file.clone(), source };
    let mut handle = files::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    // A pipe or device has no length: read one byte past the limit and no more.
    (&mut handle).take(limits.file_bytes + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > limits.file_bytes {
        let length = handle.metadata().map(|m| m.len()).unwrap_or(0).max(bytes.len() as u64);
        return Err(DrawingError::FileTooLong { file, bytes: length, limit: limits.file_bytes });
    }
    read_bytes(&file, bytes, reading)
}

/// Reads a drawing from the bytes of a file; its name decides the format, else its content.
///
/// # Errors
/// As [`read_file`].
pub fn read_bytes(name: &str, bytes: Vec<u8>, reading: impl Into<Reading>) -> Result<Import, DrawingError> {
    if bytes.starts_with(b"AutoCAD Binary DXF") {
        let help = "this is a binary DXF; save it as ASCII DXF";
        return Err(DrawingError::NotText { file: name.to_owned(), at: 1, help });
    }
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        // DXF before 2007 has an 8-bit code page; so have comments of old G-code, which are not engraved.
        Err(error) if Format::of(name, "") == Some(Format::Dxf) && !error.as_bytes().contains(&0) => {
            dxf::decoded(error.as_bytes())
        }
        Err(error) if Format::of(name, "") == Some(Format::Gcode) && !error.as_bytes().contains(&0) => {
            error.as_bytes().iter().map(|b| char::from(*b)).collect()
        }
        Err(error) => {
            return Err(DrawingError::NotText {
                file: name.to_owned(),
                at: error.utf8_error().valid_up_to() + 1,
                help: "drawings are text; for a compressed .svgz, save a plain .svg",
            });
        }
    };
    read_str(name, &text, reading)
}

/// Reads a drawing from text; the name decides the format, else the content.
///
/// # Errors
/// As [`read_file`].
pub fn read_str(name: &str, text: &str, reading: impl Into<Reading>) -> Result<Import, DrawingError> {
    let Reading { limits, gcode: switches } = reading.into();
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let text = &*with_line_feeds(text);
    let mut budget = Budget::new(limits);
    let format =
        Format::of(name, text).ok_or_else(|| DrawingError::UnknownFormat { file: name.to_owned() })?;
    if format != Format::Svg {
        check_lines(name, text, &limits)?;
    }
    let import = match format {
        Format::Svg => svg::read(name, text, &mut budget),
        Format::Dxf => dxf::read(name, text, &mut budget),
        Format::Gcode => gcode::read(name, text, switches, &mut budget),
    }?;
    check_sane(name, &import)?;
    if import.drawing.strokes.is_empty() {
        return Err(DrawingError::Empty {
            file: name.to_owned(),
            found: match import.warnings.first() {
                Some(first) => first.clone(),
                None => "no visible shape, path or cutting move in it".to_owned(),
            },
            help: match format {
                Format::Svg => "check for hidden layers; convert texts and objects to paths",
                Format::Dxf => {
                    "check that LINE, ARC, CIRCLE, POLYLINE, SPLINE or ELLIPSE entities are in model space"
                }
                Format::Gcode => {
                    "a cut is a feed move below Z0; if none is, one at Z0 with M3/M4 on, or any at Z0 if neither is used"
                }
            }
            .to_owned(),
        });
    }
    Ok(import)
}

/// A text whose lines end with carriage returns alone, as on old machines, with line feeds.
fn with_line_feeds(text: &str) -> Cow<'_, str> {
    let pairs = text.matches("\r\n").count();
    let alone = text.matches('\r').count() - pairs;
    // A few beside line feeds are noise of a conversion, as in `\r\r\n`.
    if alone > text.matches('\n').count() {
        Cow::Owned(text.replace("\r\n", "\n").replace('\r', "\n"))
    } else {
        Cow::Borrowed(text)
    }
}

fn check_lines(name: &str, text: &str, limits: &Limits) -> Result<(), DrawingError> {
    match text.lines().enumerate().find(|(_, line)| line.len() > limits.line_bytes) {
        Some((i, line)) => Err(DrawingError::LineTooLong {
            at: Place::bare_line(name, i + 1),
            bytes: line.len(),
            limit: limits.line_bytes,
        }),
        None => Ok(()),
    }
}

fn check_sane(name: &str, import: &Import) -> Result<(), DrawingError> {
    let bad = import.drawing.strokes.iter().flat_map(|s| s.pieces()).find(|piece| !piece.is_sane());
    match bad {
        Some(piece) => {
            let at = [piece.start(), piece.end()].into_iter().flat_map(|p| [p.x, p.y]);
            let value =
                at.fold(0.0, |worst: f64, x| if x.is_nan() || x.abs() > worst.abs() { x } else { worst });
            Err(DrawingError::OutOfRange { at: Place::file(name), what: "a coordinate".to_owned(), value })
        }
        None => Ok(()),
    }
}
