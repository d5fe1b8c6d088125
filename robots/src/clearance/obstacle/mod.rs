//! What stands in the cell: tables, posts, fixtures, what a camera saw.
//!
//! In: a body that does not move, in the world, and a capsule or a ball. Out: their gap, or whether the ball touches it. A query
//! allocates nothing. What has many parts is shared: a clone of an [`Obstacle`] has the same points.

mod bodies;
mod bounds;
mod cloud;
mod cylinder;
mod error;
mod height_field;
mod place;
mod tree;

use std::sync::Arc;

use mrroc::pose::Pose;
use nalgebra::Vector3;

use self::bounds::Bounds;
use self::place::{gap_in, is_finite, seen_from};
use super::gap::Gap;
use crate::models::Capsule;

pub use bodies::Bodies;
pub use cloud::Cloud;
pub use error::ObstacleError;
pub use height_field::HeightField;

/// A body that does not move, in the world.
#[derive(Clone, Debug, PartialEq)]
pub enum Obstacle {
    /// All points `p` with `normal . p <= height` \[m\]: a table, a floor, a wall. `normal` has the length 1.
    HalfSpace {
        /// Away from the obstacle, of length 1.
        normal: Vector3<f64>,
        /// Distance of the surface from the world's origin along `normal` \[m\].
        height: f64,
    },
    /// A post, a pipe, a ball.
    Capsule(Capsule),
    /// A box.
    #[allow(non_snake_case)]
    Box {
        /// The centre of the box, its axes along the edges.
        X_WO: Pose,
        /// Half the edges \[m\], each > 0.
        half: Vector3<f64>,
    },
    /// A drum, a flat disc: a cylinder with plane ends.
    #[allow(non_snake_case)]
    Cylinder {
        /// The centre of the cylinder, its z axis along that of the cylinder.
        X_WO: Pose,
        /// Radius \[m\], finite, > 0.
        radius: f64,
        /// Half the length along z \[m\], finite, > 0.
        half_length: f64,
    },
    /// Many capsules: what covers a mesh.
    Bodies(Arc<Bodies>),
    /// Points, such as a camera sees.
    Cloud(Arc<Cloud>),
    /// Ground of which the height is known at each place.
    HeightField(Arc<HeightField>),
}

impl Obstacle {
    /// All that lies below `height` \[m\].
    #[must_use]
    pub fn table(height: f64) -> Self {
        Obstacle::HalfSpace { normal: Vector3::z(), height }
    }

    /// A ball of `radius` \[m\], finite, > 0, around `centre` \[m\].
    #[must_use]
    pub const fn ball(centre: Vector3<f64>, radius: f64) -> Self {
        Obstacle::Capsule(Capsule::new(centre, centre, radius))
    }

    /// Whether its numbers make a body. Bodies, clouds and height fields do: their constructors refuse others.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let positive = |x: f64| x.is_finite() && x > 0.0;
        match self {
            Obstacle::HalfSpace { normal, height } => {
                (normal.norm() - 1.0).abs() < 1e-9 && height.is_finite()
            }
            Obstacle::Capsule(capsule) => capsule.is_valid(),
            Obstacle::Box { X_WO, half } => is_finite(X_WO) && half.iter().all(|x| positive(*x)),
            Obstacle::Cylinder { X_WO, radius, half_length } => {
                is_finite(X_WO) && positive(*radius) && positive(*half_length)
            }
            Obstacle::Bodies(_) | Obstacle::Cloud(_) | Obstacle::HeightField(_) => true,
        }
    }

    /// The gap to a capsule, whose point comes first. Of a box, a cylinder or a height field whose inside the capsule's segment
    /// meets, the distance is the negative radius.
    #[must_use]
    pub fn gap(&self, capsule: &Capsule) -> Gap {
        match self {
            Obstacle::HalfSpace { normal, height } => {
                let heights = capsule.ends.map(|end| normal.dot(&end) - height);
                let lower = usize::from(heights[1] < heights[0]);
                let end = capsule.ends[lower];
                let above = heights[lower];
                let points = [end - normal * capsule.radius, end - normal * above];
                Gap { distance: above - capsule.radius, points }
            }
            Obstacle::Capsule(other) => capsule.gap(other),
            Obstacle::Box { X_WO, half } => {
                let bounds = Bounds { low: -half, high: *half };
                let p = bounds.nearest_of(&capsule.ends.map(|end| seen_from(X_WO, &end)));
                gap_in(X_WO, [p, bounds.onto(&p)], capsule.radius)
            }
            Obstacle::Cylinder { X_WO, radius, half_length } => {
                let segment = capsule.ends.map(|end| seen_from(X_WO, &end));
                let p = cylinder::nearest_of(&segment, *radius, *half_length);
                gap_in(X_WO, [p, cylinder::onto(&p, *radius, *half_length)], capsule.radius)
            }
            Obstacle::Bodies(bodies) => bodies.gap(capsule),
            Obstacle::Cloud(cloud) => cloud.gap(capsule),
            Obstacle::HeightField(field) => field.gap(capsule),
        }
    }

    /// As [`gap`](Self::gap), if its distance is less than `most` \[m\], which makes the search short if it is small.
    #[must_use]
    pub fn gap_below(&self, capsule: &Capsule, most: f64) -> Option<Gap> {
        match self {
            Obstacle::HalfSpace { .. }
            | Obstacle::Capsule(_)
            | Obstacle::Box { .. }
            | Obstacle::Cylinder { .. } => Some(self.gap(capsule)).filter(|gap| gap.distance < most),
            Obstacle::Bodies(bodies) => bodies.gap_below(capsule, most),
            Obstacle::Cloud(cloud) => cloud.gap_below(capsule, most),
            Obstacle::HeightField(field) => field.gap_below(capsule, most),
        }
    }

    /// The distance of a point \[m\] from the obstacle's surface, or `most` \[m\] if it is not nearer, which may be infinite
    /// and makes the search short if it is small. Inside it is 0 or less, as [`gap`](Self::gap) says.
    #[must_use]
    pub fn distance(&self, point: &Vector3<f64>, most: f64) -> f64 {
        let distance = match self {
            Obstacle::HalfSpace { normal, height } => normal.dot(point) - height,
            Obstacle::Capsule(capsule) => capsule.distance(point),
            Obstacle::Box { X_WO, half } => {
                Bounds { low: -half, high: *half }.distance_squared(&seen_from(X_WO, point)).sqrt()
            }
            Obstacle::Cylinder { X_WO, radius, half_length } => {
                let p = seen_from(X_WO, point);
                (p - cylinder::onto(&p, *radius, *half_length)).norm()
            }
            Obstacle::Bodies(bodies) => bodies.distance(point, most),
            Obstacle::Cloud(cloud) => cloud.distance(point, most),
            Obstacle::HeightField(field) => field.distance(point, most),
        };
        distance.min(most)
    }

    /// Whether a ball of `radius` \[m\], >= 0, around `centre` \[m\] does not touch it.
    #[must_use]
    pub fn ball_clear(&self, centre: &Vector3<f64>, radius: f64) -> bool {
        match self {
            Obstacle::HalfSpace { .. }
            | Obstacle::Capsule(_)
            | Obstacle::Box { .. }
            | Obstacle::Cylinder { .. } => self.distance(centre, f64::INFINITY) > radius,
            Obstacle::Bodies(bodies) => bodies.ball_clear(centre, radius),
            Obstacle::Cloud(cloud) => cloud.is_clear(centre, radius),
            Obstacle::HeightField(field) => field.is_clear(centre, radius),
        }
    }

    /// Whether a capsule is farther away from it than `margin` \[m\], finite, >= 0: as [`gap`](Self::gap), but without asking which
    /// part is nearest, which is many times faster for what has many parts.
    #[must_use]
    pub fn capsule_clear(&self, capsule: &Capsule, margin: f64) -> bool {
        match self {
            Obstacle::HalfSpace { .. }
            | Obstacle::Capsule(_)
            | Obstacle::Box { .. }
            | Obstacle::Cylinder { .. } => self.gap(capsule).distance > margin,
            Obstacle::Bodies(bodies) => bodies.capsule_clear(capsule, margin),
            Obstacle::Cloud(cloud) => cloud.capsule_clear(capsule, margin),
            Obstacle::HeightField(field) => field.capsule_clear(capsule, margin),
        }
    }

    /// The corners of a box along the world's axes that holds it \[m\]: the lowest and the highest coordinates. Below a height
    /// field it is infinite; `None` of a half space.
    #[must_use]
    pub fn bounds(&self) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let bounds = match self {
            Obstacle::HalfSpace { .. } => return None,
            Obstacle::Capsule(capsule) => Bounds::around(&capsule.ends, capsule.radius),
            Obstacle::Box { X_WO, half } => Bounds { low: -half, high: *half }.moved(X_WO),
            Obstacle::Cylinder { X_WO, radius, half_length } => {
                // Along a unit vector u a disc reaches as far as its radius times the sine of the angle from its axis.
                let axis = X_WO.rotation * Vector3::z();
                let reach = axis.map(|u| half_length * u.abs() + radius * (1.0 - u * u).max(0.0).sqrt());
                let centre = &X_WO.translation.vector;
                Bounds { low: centre - reach, high: centre + reach }
            }
            Obstacle::Bodies(bodies) => bodies.bounds(),
            Obstacle::Cloud(cloud) => cloud.bounds(),
            Obstacle::HeightField(field) => field.bounds(),
        };
        Some((bounds.low, bounds.high))
    }
}

#[cfg(test)]
mod tests;
