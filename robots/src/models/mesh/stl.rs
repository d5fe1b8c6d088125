//! STL files, binary and ASCII: bytes in, corners of triangles out. What they say of normals is not looked at.

use nalgebra::Vector3;

use super::error::MeshError;
use super::text::{Lines, shown, three};
use super::triangles::Read;

/// Length of the part before the triangles of a binary file, and of one triangle \[bytes\].
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// Corners, three for each triangle.
pub(super) fn read(bytes: &[u8]) -> Result<Read, MeshError> {
    // Binary files may begin with "solid" too: their length tells them apart.
    let stated =
        bytes.get(HEADER - 4..HEADER).map(|word| word.iter().rev().fold(0, |n, b| n << 8 | u32::from(*b)));
    let needed = |count: u32| HEADER as u64 + TRIANGLE as u64 * u64::from(count);
    let is_binary = stated.is_some_and(|count| needed(count) == bytes.len() as u64);
    let corners = if is_binary {
        binary(bytes)
    } else if bytes.trim_ascii_start().starts_with(b"solid") {
        ascii(bytes)?
    } else {
        let count = stated.unwrap_or(0);
        return Err(MeshError::Length { count, needed: needed(count), bytes: bytes.len() as u64 });
    };
    let triangles = (0..corners.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Ok((corners, triangles))
}

fn binary(bytes: &[u8]) -> Vec<Vector3<f64>> {
    let triangles = bytes[HEADER..].chunks_exact(TRIANGLE);
    // The normal comes first, and two bytes for colours last.
    let numbers = |triangle: &[u8]| -> [f64; 9] {
        core::array::from_fn(|i| {
            let at = 12 + 4 * i;
            f64::from(f32::from_le_bytes([
                triangle[at],
                triangle[at + 1],
                triangle[at + 2],
                triangle[at + 3],
            ]))
        })
    };
    let corners =
        triangles.map(numbers).flat_map(|n| [0, 3, 6].map(|i| Vector3::new(n[i], n[i + 1], n[i + 2])));
    corners.collect()
}

fn ascii(bytes: &[u8]) -> Result<Vec<Vector3<f64>>, MeshError> {
    let mut lines = Lines::of(bytes)?;
    let mut corners = Vec::new();
    let mut is_open = false;
    while let Some((line, words)) = lines.next() {
        let mut words = words.split_ascii_whitespace();
        match words.next().unwrap_or_default() {
            "solid" => is_open = true,
            "endsolid" => is_open = false,
            "facet" => corners.extend(facet(&mut lines)?),
            other => {
                let expected = "facet, endsolid or solid";
                return Err(MeshError::Text { line, found: shown(other), expected });
            }
        }
    }
    if is_open { Err(lines.cut_off("endsolid")) } else { Ok(corners) }
}

/// The corners of a facet, behind its first line.
fn facet(lines: &mut Lines<'_>) -> Result<[Vector3<f64>; 3], MeshError> {
    lines.expect(&["outer", "loop"], "outer loop")?;
    let mut corners = [Vector3::zeros(); 3];
    for corner in &mut corners {
        let (line, text) = lines.next().ok_or_else(|| lines.cut_off("three vertices"))?;
        let mut words = text.split_ascii_whitespace();
        let is_vertex = words.next() == Some("vertex");
        let expected = "\"vertex\" and three numbers";
        let wrong = MeshError::Text { line, found: shown(text), expected };
        *corner = three(&mut words).filter(|_| is_vertex).map(Vector3::from).ok_or(wrong)?;
    }
    lines.expect(&["endloop"], "endloop, as facets are triangles")?;
    lines.expect(&["endfacet"], "endfacet")?;
    Ok(corners)
}
