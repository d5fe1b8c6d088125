//! Entities as chains of exact pieces, in the drawing's units.

use super::entity::Entity;
use super::spline;
use crate::drawing::{EllipticalArc, Piece, Vec2};
use crate::error::DrawingError;
use std::f64::consts::TAU;

/// The pieces of an entity; `None` for a kind that is not engraved.
pub fn chain(entity: &Entity<'_>, file: &str) -> Result<Option<Vec<Piece>>, DrawingError> {
    Ok(Some(match entity.kind {
        "LINE" => vec![Piece::Line { from: entity.point(10, file)?, to: entity.point(11, file)? }],
        "CIRCLE" => vec![circle(entity, file, 0.0, TAU)?],
        "ARC" => {
            let start = entity.needed(50, file)?.to_radians();
            let end = entity.needed(51, file)?.to_radians();
            vec![circle(entity, file, start, turn(start, end))?]
        }
        "ELLIPSE" => ellipse(entity, file)?,
        "LWPOLYLINE" => lightweight(entity, file)?,
        "POLYLINE" if entity.flags(70) & (16 | 64) == 0 => polyline(entity, file)?,
        "SPLINE" => spline::pieces(entity, file)?,
        _ => return Ok(None),
    }))
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

fn ellipse(entity: &Entity<'_>, file: &str) -> Result<Vec<Piece>, DrawingError> {
    let u = entity.point(11, file)?;
    let down = entity.number(230, file)?.is_some_and(|z| z < 0.0);
    let ratio = entity.needed(40, file)? * if down { -1.0 } else { 1.0 };
    let start = entity.number(41, file)?.unwrap_or(0.0);
    let end = entity.number(42, file)?.unwrap_or(TAU);
    let centre = entity.point(10, file)?;
    let v = Vec2::new(-u.y, u.x) * ratio;
    Ok(vec![Piece::Arc(EllipticalArc { centre, u, v, start_angle: start, sweep: turn(start, end) })])
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
    for vertex in &entity.vertices {
        // 16: a control point of a fitted spline, whose curve the other vertices are.
        if vertex.flags(70) & 16 == 0 {
            vertices.push((vertex.point(10, file)?, vertex.number(42, file)?.unwrap_or(0.0)));
        }
    }
    Ok(bulged(&vertices, entity.flags(70) & 1 == 1))
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
