//! SPLINE: by control points and knots, or through fit points.

use super::entity::{Entity, number};
use super::space::{Lie, Space, lie_of_points};
use crate::drawing::{NaturalSpline, Piece, PlanarNurbs, Vec2, Vec3, smooth_ring};
use crate::error::DrawingError;

/// What a SPLINE says.
#[derive(Default)]
struct Said {
    knots: Vec<f64>,
    weights: Vec<f64>,
    controls: Vec<Vec3>,
    fits: Vec<Vec3>,
    /// Groups 12 and 13: the directions at the start and at the end of a spline through fit points.
    ends: [Option<Vec3>; 2],
}

/// The exact pieces of a SPLINE, as `map` places it and it is seen from above, and how it lies over the plate.
///
/// Through fit points alone it is the cubic spline over chord length. Where the file gives no direction at an end, the
/// second derivative is 0 there, which is AutoCAD's own default.
pub fn pieces(entity: &Entity<'_>, map: &Space, file: &str) -> Result<(Vec<Piece>, Lie), DrawingError> {
    let Said { knots, mut weights, controls, mut fits, ends } = said(entity, file)?;
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
        let lie = lie_of_points(fits.iter().map(|fit| map.point(*fit)));
        if entity.flags(70) & 1 == 1 {
            let mut fits: Vec<Vec2> = fits.iter().map(|fit| map.point(*fit).xy()).collect();
            // Also where the last point is the first one again.
            if fits.len() > 2 && (fits[0] - fits[fits.len() - 1]).norm() < 1e-9 {
                fits.pop();
            }
            return Ok((smooth_ring(&fits), lie));
        }
        let ends = ends.map(|end| end.and_then(|end| end.try_normalize(1e-12)));
        let spline = NaturalSpline::with_ends(fits, ends);
        let seen = |controls: [Vec3; 4]| Piece::Cubic(controls.map(|p| map.point(p).xy()));
        return Ok((spline.iter().flat_map(NaturalSpline::controls).map(seen).collect(), lie));
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
    let controls: Vec<Vec3> = controls.into_iter().map(|p| map.point(p)).collect();
    let lie = lie_of_points(controls.iter().copied());
    let controls: Vec<(Vec2, f64)> = controls.iter().map(|p| p.xy()).zip(weights).collect();
    Ok((PlanarNurbs { degree, knots, controls }.pieces().map_err(malformed)?, lie))
}

fn said(entity: &Entity<'_>, file: &str) -> Result<Said, DrawingError> {
    let mut said = Said::default();
    for tag in &entity.tags {
        let axis = (tag.code / 10 - 1).clamp(0, 2) as usize;
        match tag.code {
            40 => said.knots.push(number(tag, file)?),
            41 => said.weights.push(number(tag, file)?),
            10 => said.controls.push(Vec3::new(number(tag, file)?, 0.0, 0.0)),
            11 => said.fits.push(Vec3::new(number(tag, file)?, 0.0, 0.0)),
            20 | 30 => set(said.controls.last_mut(), axis, number(tag, file)?),
            21 | 31 => set(said.fits.last_mut(), axis, number(tag, file)?),
            12 | 22 | 32 => set(Some(said.ends[0].get_or_insert_default()), axis, number(tag, file)?),
            13 | 23 | 33 => set(Some(said.ends[1].get_or_insert_default()), axis, number(tag, file)?),
            _ => {}
        }
    }
    Ok(said)
}

fn set(point: Option<&mut Vec3>, axis: usize, value: f64) {
    if let Some(point) = point {
        point[axis] = value;
    }
}
