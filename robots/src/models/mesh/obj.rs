//! Wavefront OBJ files: their vertices (`v`) and faces (`f`), of three corners or more. All else is not looked at.

use nalgebra::Vector3;

use super::error::MeshError;
use super::text::{Lines, shown, three};
use super::triangles::Read;

/// Vertices, and triangles by their indices. A face of more corners is cut into triangles from its first one.
pub(super) fn read(bytes: &[u8]) -> Result<Read, MeshError> {
    let mut lines = Lines::of(bytes)?;
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    while let Some((line, text)) = lines.next() {
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let expected = "v and three numbers";
                let wrong = MeshError::Text { line, found: shown(text), expected };
                vertices.push(Vector3::from(three(&mut words).ok_or(wrong)?));
            }
            Some("f") => {
                let expected = "f and three or more indices of vertices above it";
                let wrong = || MeshError::Text { line, found: shown(text), expected };
                let corners: Option<Vec<u32>> = words.map(|word| index(word, vertices.len())).collect();
                let corners = corners.filter(|corners| corners.len() >= 3).ok_or_else(wrong)?;
                triangles.extend(corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]));
            }
            _ => {}
        }
    }
    Ok((vertices, triangles))
}

/// The index that a word such as `7/2/5` names, from 0: counted from 1, or, below 0, from the last vertex.
fn index(word: &str, count: usize) -> Option<u32> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let index = if number < 0 { count as i64 + number } else { number - 1 };
    u32::try_from(index).ok().filter(|index| (*index as usize) < count)
}
