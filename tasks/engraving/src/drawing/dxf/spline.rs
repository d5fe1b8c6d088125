//! SPLINE: by control points and knots, or through fit points.

use super::entity::{Entity, number};
use crate::drawing::{NaturalSpline, Piece, PlanarNurbs, Vec2, smooth_pieces};
use crate::error::DrawingError;
use std::f64::consts::PI;

/// The exact pieces of a SPLINE; through fit points alone the natural cubic spline over chord length, which is
/// AutoCAD's own default.
pub fn pieces(entity: &Entity<'_>, file: &str) -> Result<Vec<Piece>, DrawingError> {
    let mut knots = Vec::new();
    let mut weights = Vec::new();
    let mut controls: Vec<Vec2> = Vec::new();
    let mut fits: Vec<Vec2> = Vec::new();
    for tag in &entity.tags {
        match tag.code {
            40 => knots.push(number(tag, file)?),
            41 => weights.push(number(tag, file)?),
            10 => controls.push(Vec2::new(number(tag, file)?, 0.0)),
            11 => fits.push(Vec2::new(number(tag, file)?, 0.0)),
            20 => set_y(&mut controls, number(tag, file)?),
            21 => set_y(&mut fits, number(tag, file)?),
            _ => {}
        }
    }
    let malformed = |what: String| DrawingError::Malformed {
        at: entity.place(file),
        what,
        help: "draw the spline anew or export it as polylines".to_owned(),
    };
    if controls.is_empty() {
        fits.dedup_by(|a, b| (*a - *b).norm() < 1e-9);
        if fits.len() < 2 {
            return Err(malformed("a spline without points".to_owned()));
        }
        if entity.flags(70) & 1 == 1 {
            fits.push(fits[0]);
            return Ok(smooth_pieces(&fits, PI));
        }
        return Ok(NaturalSpline::new(fits).map(|s| s.pieces()).unwrap_or_default());
    }
    let degree = usize::try_from(entity.flags(71)).unwrap_or(0);
    if !weights.is_empty() && weights.len() != controls.len() {
        return Err(malformed(format!(
            "a spline with {} points and {} weights",
            controls.len(),
            weights.len()
        )));
    }
    weights.resize(controls.len(), 1.0);
    let controls: Vec<(Vec2, f64)> = controls.into_iter().zip(weights).collect();
    PlanarNurbs { degree, knots, controls }.pieces().map_err(malformed)
}

fn set_y(points: &mut [Vec2], y: f64) {
    if let Some(last) = points.last_mut() {
        last.y = y;
    }
}
