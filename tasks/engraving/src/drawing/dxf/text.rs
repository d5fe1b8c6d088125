//! TEXT and MTEXT in Hershey's single-stroke fonts: height, width factor, rotation, slant and alignment are honoured, the
//! style's own font is not.

use super::entity::Entity;
use crate::drawing::hershey::{Font, PIECES_OF_A_LETTER};
use crate::drawing::{Affine, Piece, Stroke, Vec2};
use crate::error::DrawingError;
use mrroc::console::quoted;

/// From line to line of an MTEXT, in capital heights.
const LINE_STEP: f64 = 5.0 / 3.0;
/// How far letters reach below the baseline, in capital heights.
const DESCENT: f64 = 7.0 / 21.0;

/// Whether the entity is a text.
pub fn is_text(entity: &Entity<'_>) -> bool {
    matches!(entity.kind, "TEXT" | "MTEXT")
}

/// What a text costs of a budget of curve pieces before it is written.
pub fn cost(entity: &Entity<'_>) -> usize {
    let letters = entity.tags.iter().filter(|tag| matches!(tag.code, 1 | 3)).map(|tag| tag.value.len());
    letters.sum::<usize>() * PIECES_OF_A_LETTER
}

/// The strokes of a TEXT or an MTEXT as chains of pieces.
pub fn chains(entity: &Entity<'_>, font: &Font, file: &str) -> Result<Vec<Vec<Piece>>, DrawingError> {
    let height = entity.needed(40, file)?;
    if height <= 0.0 {
        return Err(DrawingError::Malformed {
            at: entity.place(file),
            what: format!("{} of height {height}", entity.kind),
            help: "give the text a height in the drawing program".to_owned(),
        });
    }
    if entity.kind == "TEXT" {
        single(entity, font, height, file)
    } else {
        several(entity, font, height, file)
    }
}

fn single(
    entity: &Entity<'_>,
    font: &Font,
    height: f64,
    file: &str,
) -> Result<Vec<Vec<Piece>>, DrawingError> {
    let text = percent_codes(entity.text(1).unwrap_or(""));
    let natural = width(entity, font, &text, file)?;
    let (across, up) = (entity.flags(72), entity.flags(73));
    let first = entity.point(10, file)?;
    let second = if entity.text(11).is_some() { entity.point(11, file)? } else { first };
    let mut wide = entity.number(41, file)?.filter(|factor| *factor > 0.0).unwrap_or(1.0);
    let mut turn = entity.number(50, file)?.unwrap_or(0.0).to_radians();
    let slant = entity.number(51, file)?.unwrap_or(0.0).to_radians();
    let mut height = height;
    let way = second - first;
    // Aligned and fitted texts reach from the first point to the second.
    if matches!(across, 3 | 5) && way.norm() > 1e-9 && natural > 0.0 {
        turn = way.y.atan2(way.x);
        if across == 3 {
            height = way.norm() / (natural * wide);
        } else {
            wide = way.norm() / (natural * height);
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
    written(entity, font, &text, &map, file)
}

fn several(
    entity: &Entity<'_>,
    font: &Font,
    height: f64,
    file: &str,
) -> Result<Vec<Vec<Piece>>, DrawingError> {
    let parts = entity.tags.iter().filter(|tag| matches!(tag.code, 1 | 3)).map(|tag| tag.value);
    let text = formatted(&parts.collect::<String>());
    let lines: Vec<&str> = text.split('\n').collect();
    let attachment = entity.flags(71).clamp(1, 9) - 1;
    let step = LINE_STEP * entity.number(44, file)?.filter(|factor| *factor > 0.0).unwrap_or(1.0);
    let turn = match entity.text(11) {
        Some(_) => {
            let along = entity.point(11, file)?;
            along.y.atan2(along.x)
        }
        None => entity.number(50, file)?.unwrap_or(0.0).to_radians(),
    };
    let tall = 1.0 + step * (lines.len() - 1) as f64;
    let top = match attachment / 3 {
        0 => 0.0,
        1 => tall / 2.0,
        _ => tall,
    };
    let map = Affine::translation(entity.point(10, file)?)
        .after(&Affine::rotation(turn))
        .after(&Affine::scaling(height, height));
    let mut chains = Vec::new();
    for (row, line) in lines.iter().enumerate() {
        let back = width(entity, font, line, file)? * (attachment % 3) as f64 / 2.0;
        let baseline = top - 1.0 - step * row as f64;
        let map = map.after(&Affine::translation(Vec2::new(-back, baseline)));
        chains.extend(written(entity, font, line, &map, file)?);
    }
    Ok(chains)
}

fn width(entity: &Entity<'_>, font: &Font, text: &str, file: &str) -> Result<f64, DrawingError> {
    font.width(text).map_err(|error| unwritable(entity, &error, file))
}

fn written(
    entity: &Entity<'_>,
    font: &Font,
    text: &str,
    map: &Affine,
    file: &str,
) -> Result<Vec<Vec<Piece>>, DrawingError> {
    let strokes = font.line(text).map_err(|error| unwritable(entity, &error, file))?;
    Ok(strokes.iter().map(|stroke| stroke.transformed(map)).map(Stroke::into_pieces).collect())
}

fn unwritable(entity: &Entity<'_>, error: &DrawingError, file: &str) -> DrawingError {
    let what = match error {
        DrawingError::MissingGlyph { character, .. } => {
            format!("{} with {character:?}, which no font here has", entity.kind)
        }
        other => quoted(&other.to_string(), 200),
    };
    let help = "use the characters of ASCII, or explode the text to curves (TXTEXP)".to_owned();
    DrawingError::Unsupported { at: entity.place(file), what, help }
}

/// `%%d`, `%%p`, `%%c` and `%%nnn` of a TEXT as ASCII can have them; lines under and over are left out.
fn percent_codes(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("%%") {
        plain.push_str(&rest[..at]);
        rest = &rest[at + 2..];
        let Some(code) = rest.chars().next() else { break };
        rest = &rest[code.len_utf8()..];
        match code.to_ascii_lowercase() {
            'd' => plain.push_str(" deg"),
            'p' => plain.push_str("+-"),
            'c' => plain.push_str("dia "),
            '%' => plain.push('%'),
            'u' | 'o' | 'k' => {}
            other => plain.push(other),
        }
    }
    plain + rest
}

/// An MTEXT without its codes for looks; `\P` is a line break.
fn formatted(text: &str) -> String {
    let mut plain = String::new();
    let mut characters = text.chars();
    while let Some(c) = characters.next() {
        match c {
            '{' | '}' => {}
            '^' => match characters.next() {
                Some('J') => plain.push('\n'),
                Some('I') => plain.push(' '),
                Some(' ') | None => plain.push('^'),
                Some(_) => {}
            },
            '\\' => match characters.next() {
                Some('P' | 'X' | 'N') => plain.push('\n'),
                Some('~') => plain.push(' '),
                Some(c @ ('\\' | '{' | '}')) => plain.push(c),
                // A fraction: its parts, up to the semicolon.
                Some('S') => {
                    let stacked: String = characters.by_ref().take_while(|c| *c != ';').collect();
                    plain.push_str(&stacked.replace(['^', '#'], "/"));
                }
                Some('L' | 'l' | 'O' | 'o' | 'K' | 'k') | None => {}
                // Fonts, heights, colours: a letter, its value, a semicolon.
                Some(_) => {
                    for c in characters.by_ref() {
                        if c == ';' {
                            break;
                        }
                    }
                }
            },
            c => plain.push(c),
        }
    }
    percent_codes(&plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_of_looks_are_taken_away() {
        assert_eq!(formatted(r"{\fArial|b0;Plate}\P\H2.5x;No. 7\~a\S1/2;"), "Plate\nNo. 7 a1/2");
        assert_eq!(formatted(r"C:\\x\{1\}"), r"C:\x{1}");
        assert_eq!(percent_codes("%%c8 %%p0.1 45%%d 5%%%"), "dia 8 +-0.1 45 deg 5%");
    }
}
