//! What stands in a cell, drawn as outlines that are seen through.
//!
//! In: simple solids by their frames. Out: faces of boxes, silhouettes of round ones, dots for points; they never move.

use std::f64::consts::TAU;

use mrroc::observe::solid::{ObstacleLayout, Solid};
use mrroc::pose::Pose;
use nalgebra::{Point3, Vector2, Vector3};

use crate::block::FACES;
use crate::projection::Projection;
use crate::svg::palette::{GREY, RULE};
use crate::svg::{Look, Svg};

/// Corners of a circle.
const CORNERS: u32 = 48;
/// The most dots of a cloud in a view: about 40 bytes each.
const DOTS: usize = 600;
/// The least radius of a point's dot \[px\].
const DOT: f64 = 0.8;

/// The outermost points of a solid \[m\], by which a picture is made large enough: those that are numbers.
pub(crate) fn points(obstacle: &ObstacleLayout) -> Vec<Vector3<f64>> {
    let mut found = outermost(&obstacle.pose, &obstacle.solid);
    found.retain(|point| point.iter().all(|x| x.is_finite()));
    found
}

fn outermost(pose: &Pose, solid: &Solid) -> Vec<Vector3<f64>> {
    let at = |p: Vector3<f64>| (pose * Point3::from(p)).coords;
    let around = |[x, y, z]: [f64; 3]| corners([x, y, z]).map(at).to_vec();
    match solid {
        Solid::Box { edges } => around(*edges),
        Solid::Cylinder { radius, length } => around([2.0 * radius, 2.0 * radius, *length]),
        Solid::Capsule { radius, length } => {
            let thickness = 2.0 * radius;
            around([thickness, thickness, length + thickness])
        }
        Solid::Ball { radius } => around([2.0 * radius; 3]),
        Solid::HalfSpace => Vec::new(),
        Solid::Points { points, .. } => points.iter().map(|point| at(*point)).collect(),
        Solid::Several(parts) => {
            parts.iter().flat_map(|(place, part)| outermost(&(pose * place), part)).collect()
        }
    }
}

/// The corners of a box about the origin, by the bits of their places along x, y, z.
fn corners(edges: [f64; 3]) -> [Vector3<f64>; 8] {
    std::array::from_fn(|i| {
        Vector3::from_fn(|axis, _| if i >> axis & 1 == 0 { -0.5 } else { 0.5 } * edges[axis])
    })
}

/// Draws a solid with its name as the text that a pointer shows.
pub(crate) fn draw(svg: &mut Svg, on: &Projection, obstacle: &ObstacleLayout) {
    if points(obstacle).is_empty() {
        return;
    }
    let look = Look::filled(RULE).fill_opacity(0.22).stroke(GREY).stroke_opacity(0.55);
    svg.group(look.class("obstacle").width(1.0).round(), |svg| {
        svg.explained(&obstacle.name, |svg| solid(svg, on, &obstacle.pose, &obstacle.solid));
    });
}

fn solid(svg: &mut Svg, on: &Projection, pose: &Pose, solid: &Solid) {
    let at = |p: Vector3<f64>| on.at((pose * Point3::from(p)).coords);
    let along = |length: f64| [-0.5, 0.5].map(|share| Vector3::z() * (share * length));
    match solid {
        Solid::Box { edges } => {
            let corners = corners(*edges).map(at);
            for face in FACES {
                svg.polygon(&face.map(|corner| corners[corner]), Look::new());
            }
        }
        Solid::Cylinder { radius, length } => {
            let circles = along(*length).map(|middle| {
                let on_rim = |(cosine, sine)| at(middle + Vector3::new(cosine, sine, 0.0) * *radius);
                circle().map(on_rim).collect::<Vec<_>>()
            });
            svg.polygon(&hull(circles.concat()), Look::new());
            for circle in &circles {
                svg.polygon(circle, Look::new());
            }
        }
        Solid::Capsule { radius, length } => {
            let ends = along(*length).map(at);
            svg.polygon(&around(ends, *radius * on.scale), Look::new());
        }
        Solid::Ball { radius } => svg.circle(at(Vector3::zeros()), radius * on.scale, Look::new()),
        Solid::HalfSpace => {}
        Solid::Points { points, radius } => {
            let dot = (radius * on.scale).max(DOT);
            svg.group(Look::filled(GREY).fill_opacity(0.35).width(0.0), |svg| {
                let some = points.iter().step_by(points.len().div_ceil(DOTS).max(1));
                some.for_each(|point| svg.circle(at(*point), dot, Look::new()));
            });
        }
        Solid::Several(parts) => {
            parts.iter().for_each(|(place, part)| self::solid(svg, on, &(pose * place), part))
        }
    }
}

fn circle() -> impl Iterator<Item = (f64, f64)> {
    (0..CORNERS)
        .map(|corner| (TAU * f64::from(corner) / f64::from(CORNERS)).sin_cos())
        .map(|(sine, cosine)| (cosine, sine))
}

/// The outline of a line with round ends.
fn around(ends: [Vector2<f64>; 2], radius: f64) -> Vec<Vector2<f64>> {
    let circles =
        ends.into_iter().flat_map(|end| circle().map(move |(x, y)| end + Vector2::new(x, y) * radius));
    hull(circles.collect())
}

/// The convex hull of points, counter-clockwise (Andrew, Information Processing Letters 9, 1979).
fn hull(mut points: Vec<Vector2<f64>>) -> Vec<Vector2<f64>> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = &Vector2<f64>>| {
        let mut chain: Vec<Vector2<f64>> = Vec::new();
        for point in points {
            while let [.., before, last] = chain[..]
                && (last - before).perp(&(point - last)) <= 0.0
            {
                chain.pop();
            }
            chain.push(*point);
        }
        // The last point is the first one of the other half.
        chain.pop();
        chain
    };
    let mut found = half(&mut points.iter());
    found.extend(half(&mut points.iter().rev()));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hull_has_the_outermost_points_in_their_order() {
        let at = Vector2::new;
        let inside = [at(0.5, 0.5), at(0.2, 0.7), at(0.5, 0.0)];
        let corners = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        assert_eq!(hull([&inside[..], &corners[..]].concat()), corners);
    }

    #[test]
    fn the_outermost_points_of_a_capsule_hold_its_balls() {
        let pose = Pose::translation(0.0, 0.0, 2.0);
        let capsule = Solid::Capsule { radius: 0.1, length: 0.5 };
        let found = points(&ObstacleLayout { name: "rail".to_owned(), pose, solid: capsule.clone() });
        let parts = Solid::Several([(Pose::translation(0.0, 0.0, 1.0), capsule)].into());
        let lower = Pose::translation(0.0, 0.0, 1.0);
        assert_eq!(points(&ObstacleLayout { name: "rail".to_owned(), pose: lower, solid: parts }), found);
        let top = found.iter().map(|point| point.z).fold(f64::NEG_INFINITY, f64::max);
        assert!((top - (2.0 + 0.25 + 0.1)).abs() < 1e-12);
        let nowhere = ObstacleLayout {
            name: "nowhere".to_owned(),
            pose: Pose::translation(f64::NAN, 0.0, 0.0),
            solid: Solid::Ball { radius: 0.1 },
        };
        assert!(points(&nowhere).is_empty());
    }
}
