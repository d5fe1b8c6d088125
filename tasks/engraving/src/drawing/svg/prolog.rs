//! What stands before the root element. A document type without entities is passed over, as drawing programs of the
//! SVG 1.1 days wrote one; one that declares entities is refused, as they can make a gigabyte of a kilobyte.

use crate::error::{DrawingError, Place};
use std::borrow::Cow;

/// The text with blanks for its document type, so that every other byte and line keeps its place.
///
/// # Errors
/// [`DrawingError::Unsupported`] for a document type that declares entities.
pub fn without_document_type<'a>(file: &str, text: &'a str) -> Result<Cow<'a, str>, DrawingError> {
    let Some(start) = document_type(text) else { return Ok(Cow::Borrowed(text)) };
    let Some(length) = length(&text[start..]) else { return Ok(Cow::Borrowed(text)) };
    let declared = &text[start..start + length];
    if let Some(at) = declared.find("<!ENTITY") {
        let before = &text[..start + at];
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        let source = text.lines().nth(line - 1).unwrap_or("");
        return Err(DrawingError::Unsupported {
            at: Place::column(file, line, column, source),
            what: "a document type that declares entities: entities are not read".to_owned(),
            help: "save it as plain SVG".to_owned(),
        });
    }
    let blank: String = declared
        .bytes()
        .map(|byte| if matches!(byte, b'\n' | b'\r') { char::from(byte) } else { ' ' })
        .collect();
    Ok(Cow::Owned([&text[..start], &blank, &text[start + length..]].concat()))
}

/// Where the document type begins: behind blanks, comments and processing instructions only.
fn document_type(text: &str) -> Option<usize> {
    let mut rest = text.trim_start();
    loop {
        let end = if rest.starts_with("<?") {
            "?>"
        } else if rest.starts_with("<!--") {
            "-->"
        } else {
            break;
        };
        rest = rest[rest.find(end)? + end.len()..].trim_start();
    }
    rest.starts_with("<!DOCTYPE").then(|| text.len() - rest.len())
}

/// The bytes of a document type, to the `>` outside of its brackets and quotes; `None` where the text ends before.
fn length(text: &str) -> Option<usize> {
    let (mut quote, mut brackets) = (None, 0_usize);
    for (at, byte) in text.bytes().enumerate() {
        match (quote, byte) {
            (Some(open), _) if open == byte => quote = None,
            (Some(_), _) => {}
            (None, b'"' | b'\'') => quote = Some(byte),
            (None, b'[') => brackets += 1,
            (None, b']') => brackets = brackets.saturating_sub(1),
            (None, b'>') if brackets == 0 => return Some(at + 1),
            (None, _) => {}
        }
    }
    None
}
