//! Plane affine maps `p -> M p + d`, as SVG transforms, DXF inserts and the placement on the plate use them.

use super::Vec2;

/// An affine map of the plane: `x' = a x + c y + e`, `y' = b x + d y + f` (the letters of SVG's `matrix`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Image of the x axis.
    pub x_axis: Vec2,
    /// Image of the y axis.
    pub y_axis: Vec2,
    /// Image of the origin.
    pub origin: Vec2,
}

impl Affine {
    /// The map that changes nothing.
    pub const IDENTITY: Self =
        Self { x_axis: Vec2::new(1.0, 0.0), y_axis: Vec2::new(0.0, 1.0), origin: Vec2::new(0.0, 0.0) };

    /// The map with SVG's six numbers.
    #[must_use]
    pub fn new(a: f64, b: f64, c: f64, d: f64, e: f64, f: f64) -> Self {
        Self { x_axis: Vec2::new(a, b), y_axis: Vec2::new(c, d), origin: Vec2::new(e, f) }
    }

    /// A displacement.
    #[must_use]
    pub fn translation(by: Vec2) -> Self {
        Self { origin: by, ..Self::IDENTITY }
    }

    /// A scaling about the origin.
    #[must_use]
    pub fn scaling(x: f64, y: f64) -> Self {
        Self::new(x, 0.0, 0.0, y, 0.0, 0.0)
    }

    /// A turn about the origin \[rad\], counter-clockwise where y points up.
    #[must_use]
    pub fn rotation(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self::new(cos, sin, -sin, cos, 0.0, 0.0)
    }

    /// The image of a point.
    #[must_use]
    pub fn point(&self, p: Vec2) -> Vec2 {
        self.origin + self.direction(p)
    }

    /// The image of a displacement: the origin does not count.
    #[must_use]
    pub fn direction(&self, v: Vec2) -> Vec2 {
        self.x_axis * v.x + self.y_axis * v.y
    }

    /// First `inner`, then this map.
    #[must_use]
    pub fn after(&self, inner: &Self) -> Self {
        Self {
            x_axis: self.direction(inner.x_axis),
            y_axis: self.direction(inner.y_axis),
            origin: self.point(inner.origin),
        }
    }

    /// Whether all six numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        [self.x_axis, self.y_axis, self.origin].iter().all(|v| v.x.is_finite() && v.y.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inner_map_is_applied_first() {
        let both = Affine::translation(Vec2::new(10.0, 0.0)).after(&Affine::scaling(2.0, 3.0));
        assert_eq!(both.point(Vec2::new(1.0, 1.0)), Vec2::new(12.0, 3.0));
    }
}
