//! Entities as chains of exact pieces, as they are seen from above, in the drawing's units.

use super::entity::Entity;
use super::space::{self, Lie, Space, lie_of_points};
use super::spline;
use crate::drawing::{EllipticalArc, Piece, Vec2, Vec3};
use crate::error::DrawingError;
use std::f64::consts::TAU;

/// The pieces of an entity that `map` places over the plate, and how it lies there; `None` for a kind that is not
/// engraved.
pub fn chain(
    entity: &Entity<'_>,
    map: &Space,
    file: &str,
) -> Result<Option<(Vec<Piece>, Lie)>, DrawingError> {
    Ok(Some(match entity.kind {
        "LINE" => {
            let ends = [entity.point_in_space(10, file)?, entity.point_in_space(11, file)?];
            in_space(&ends.map(|end| map.point(end)))
        }
        "CIRCLE" => in_plane(vec![circle(entity, file, 0.0, TAU)?], entity, 30, map, file)?,
        "ARC" => {
            let start = entity.needed(50, file)?.to_radians();
            let end = entity.needed(51, file)?.to_radians();
            in_plane(vec![circle(entity, file, start, turn(start, end))?], entity, 30, map, file)?
        }
        "ELLIPSE" => ellipse(entity, map, file)?,
        "LWPOLYLINE" => in_plane(lightweight(entity, file)?, entity, 38, map, file)?,
        // 8: a polyline in space. 16, 64: meshes.
        "POLYLINE" if entity.flags(70) & 8 == 8 => {
            let mut vertices = Vec::new();
            for vertex in drawn_vertices(entity) {
                vertices.push(map.point(vertex.point_in_space(10, file)?));
            }
            if entity.flags(70) & 1 == 1 {
                vertices.extend(vertices.first().copied());
            }
            in_space(&vertices)
        }
        "POLYLINE" if entity.flags(70) & (16 | 64) == 0 => {
            in_plane(polyline(entity, file)?, entity, 30, map, file)?
        }
        "SPLINE" => spline::pieces(entity, map, file)?,
        _ => return Ok(None),
    }))
}

/// Pieces in object coordinates, at the height that a group says.
fn in_plane(
    pieces: Vec<Piece>,
    entity: &Entity<'_>,
    height: i32,
    map: &Space,
    file: &str,
) -> Result<(Vec<Piece>, Lie), DrawingError> {
    let height = entity.number(height, file)?.unwrap_or(0.0);
    let plane =
        map.after(&Space::of_object(entity, file)?).after(&Space::translation(Vec3::new(0.0, 0.0, height)));
    let seen = plane.seen();
    Ok((pieces.iter().map(|piece| piece.transformed(&seen)).collect(), plane.lie()))
}

/// Lines from point to point of the plate's coordinates.
fn in_space(points: &[Vec3]) -> (Vec<Piece>, Lie) {
    let lines = points.windows(2).map(|w| Piece::Line { from: w[0].xy(), to: w[1].xy() }).collect();
    (lines, lie_of_points(points.iter().copied()))
}

/// Counter-clockwise from start to end, a whole turn if they are one.
fn turn(start: f64, end: f64) -> f64 {
    let angle = (end - start).rem_euclid(TAU);
    if angle < 1e-12 { TAU } else { angle }
}

fn circle(entity: &Entity<'_>, file: &str, start: f64, sweep: f64) -> Result<Piece, DrawingError> {
    let radius = entity.needed(40, file)?;
    if radius <= 0.0 {
        return Err(DrawingError::Malformed {
            at: entity.place(file),
            what: format!("{} of radius {radius}", entity.kind),
            help: "remove it in the drawing program".to_owned(),
        });
    }
    Ok(Piece::Arc(EllipticalArc::circular(entity.point(10, file)?, radius, start, sweep)))
}

/// An ellipse is not in object coordinates: only its sense of turning comes from the extrusion.
fn ellipse(entity: &Entity<'_>, map: &Space, file: &str) -> Result<(Vec<Piece>, Lie), DrawingError> {
    let u = entity.point_in_space(11, file)?;
    let v = space::normal(entity, file)?.cross(&u) * entity.needed(40, file)?;
    let start = entity.number(41, file)?.unwrap_or(0.0);
    let end = entity.number(42, file)?.unwrap_or(TAU);
    let centre = map.point(entity.point_in_space(10, file)?);
    let (u, v) = (map.direction(u), map.direction(v));
    let arc = EllipticalArc {
        centre: centre.xy(),
        u: u.xy(),
        v: v.xy(),
        start_angle: start,
        sweep: turn(start, end),
    };
    Ok((vec![Piece::Arc(arc)], space::lie(u, v)))
}

fn lightweight(entity: &Entity<'_>, file: &str) -> Result<Vec<Piece>, DrawingError> {
    let mut vertices: Vec<(Vec2, f64)> = Vec::new();
    for tag in &entity.tags {
        match (tag.code, vertices.last_mut()) {
            (10, _) => vertices.push((Vec2::new(super::entity::number(tag, file)?, 0.0), 0.0)),
            (20, Some(vertex)) => vertex.0.y = super::entity::number(tag, file)?,
            (42, Some(vertex)) => vertex.1 = super::entity::number(tag, file)?,
            _ => {}
        }
    }
    Ok(bulged(&vertices, entity.flags(70) & 1 == 1))
}

fn polyline(entity: &Entity<'_>, file: &str) -> Result<Vec<Piece>, DrawingError> {
    let mut vertices = Vec::new();
    for vertex in drawn_vertices(entity) {
        vertices.push((vertex.point(10, file)?, vertex.number(42, file)?.unwrap_or(0.0)));
    }
    Ok(bulged(&vertices, entity.flags(70) & 1 == 1))
}

/// The vertices that are drawn. 16: a control point of a fitted spline, whose curve the other vertices are.
fn drawn_vertices<'a, 'b>(entity: &'b Entity<'a>) -> impl Iterator<Item = &'b Entity<'a>> {
    entity.parts.iter().filter(|vertex| vertex.flags(70) & 16 == 0)
}

/// Lines and arcs from vertex to vertex.
fn bulged(vertices: &[(Vec2, f64)], closed: bool) -> Vec<Piece> {
    let mut ring = vertices.to_vec();
    if closed && let Some(first) = vertices.first() {
        ring.push(*first);
    }
    ring.windows(2)
        .map(|w| {
            let (from, to) = (w[0].0, w[1].0);
            EllipticalArc::from_bulge(from, to, w[0].1).map_or(Piece::Line { from, to }, Piece::Arc)
        })
        .collect()
}
