//! Where an entity lies in space, and what of it is seen from above.
//!
//! Most flat entities have object coordinates: x and y in their own plane, whose normal is the extrusion (groups 210,
//! 220, 230). The arbitrary axis algorithm of the DXF reference says where the plane's x axis points.

use super::entity::Entity;
use crate::drawing::{Affine, Vec2, Vec3};
use crate::error::DrawingError;
use nalgebra::Matrix3;

/// How an entity lies over the plate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lie {
    /// Parallel to the plate.
    Flat,
    /// Inclined: what is seen from above differs from it.
    Inclined,
    /// Upright on the plate: from above there is nothing but a line or a point.
    Upright,
}

/// An affine map of space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Space {
    linear: Matrix3<f64>,
    origin: Vec3,
}

impl Space {
    /// The map that changes nothing.
    pub fn identity() -> Self {
        Self { linear: Matrix3::identity(), origin: Vec3::zeros() }
    }

    /// Axes at an origin.
    pub fn new(axes: [Vec3; 3], origin: Vec3) -> Self {
        Self { linear: Matrix3::from_columns(&axes), origin }
    }

    /// A displacement.
    pub fn translation(by: Vec3) -> Self {
        Self { origin: by, ..Self::identity() }
    }

    /// From object coordinates to those of the drawing, by the arbitrary axis algorithm.
    pub fn of_object(entity: &Entity<'_>, file: &str) -> Result<Self, DrawingError> {
        let normal = normal(entity, file)?;
        if normal == Vec3::z() {
            return Ok(Self::identity());
        }
        let near_z = normal.x.abs() < 1.0 / 64.0 && normal.y.abs() < 1.0 / 64.0;
        let reference = if near_z { Vec3::y() } else { Vec3::z() };
        let x = reference.cross(&normal).normalize();
        Ok(Self::new([x, normal.cross(&x), normal], Vec3::zeros()))
    }

    /// First `inner`, then this map.
    pub fn after(&self, inner: &Self) -> Self {
        Self { linear: self.linear * inner.linear, origin: self.point(inner.origin) }
    }

    /// The image of a point.
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.linear * p + self.origin
    }

    /// The image of a displacement.
    pub fn direction(&self, v: Vec3) -> Vec3 {
        self.linear * v
    }

    /// The image, seen from above, of the plane of x and y.
    pub fn seen(&self) -> Affine {
        let column = |k: usize| Vec2::new(self.linear[(0, k)], self.linear[(1, k)]);
        Affine { x_axis: column(0), y_axis: column(1), origin: self.origin.xy() }
    }

    /// How the image of the plane of x and y lies over the plate.
    pub fn lie(&self) -> Lie {
        lie(self.direction(Vec3::x()), self.direction(Vec3::y()))
    }
}

/// How the plane of two vectors lies over the plate.
pub fn lie(u: Vec3, v: Vec3) -> Lie {
    let normal = u.cross(&v);
    let size = normal.norm();
    // Below a millionth is rounding in the file; a normal of no length is a map that leaves nothing in any case.
    if normal.xy().norm() <= 1e-6 * size {
        Lie::Flat
    } else if normal.z.abs() <= 1e-6 * size {
        Lie::Upright
    } else {
        Lie::Inclined
    }
}

/// How a curve through these points lies over the plate.
pub fn lie_of_points(points: impl Iterator<Item = Vec3>) -> Lie {
    let mut corners: Option<(Vec3, Vec3)> = None;
    for p in points {
        corners = Some(corners.map_or((p, p), |(low, high)| (low.inf(&p), high.sup(&p))));
    }
    let Some((low, high)) = corners else { return Lie::Flat };
    let size = high - low;
    if size.z <= 1e-6 * size.norm() {
        Lie::Flat
    } else if size.xy().norm() <= 1e-6 * size.norm() {
        Lie::Upright
    } else {
        Lie::Inclined
    }
}

/// The extrusion, of length 1.
pub fn normal(entity: &Entity<'_>, file: &str) -> Result<Vec3, DrawingError> {
    let mut said = false;
    let mut normal = Vec3::zeros();
    for (axis, code) in [210, 220, 230].into_iter().enumerate() {
        if let Some(value) = entity.number(code, file)? {
            normal[axis] = value;
            said = true;
        }
    }
    // By its largest component first: the square of a tiny one would be 0.
    let largest = normal.amax();
    if !said || largest == 0.0 {
        return Ok(Vec3::z());
    }
    let normal = normal / largest;
    Ok(if normal == Vec3::z() { normal } else { normal.normalize() })
}
