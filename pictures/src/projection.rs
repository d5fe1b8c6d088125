//! From the world to the page: parallel projections.
//!
//! In: points in the world \[m\]. Out: points on the page \[px\], y down: `x = cx + s r·p`, `y = cy - s u·p` with the view's
//! unit vectors r (to the right) and u (up) and the scale s [px/m].

use nalgebra::{Vector2, Vector3};

use crate::svg::Area;

/// From where the world is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct View {
    /// What points to the right on the page: a unit vector in the world.
    pub right: Vector3<f64>,
    /// What points up on the page: a unit vector in the world, at right angles to `right`.
    pub up: Vector3<f64>,
}

impl View {
    /// From this direction, `azimuth` \[rad\] from x towards y and `elevation` \[rad\] above the floor.
    pub fn from(azimuth: f64, elevation: f64) -> View {
        let ((sa, ca), (se, ce)) = (azimuth.sin_cos(), elevation.sin_cos());
        View { right: Vector3::new(-sa, ca, 0.0), up: Vector3::new(-se * ca, -se * sa, ce) }
    }

    /// In space: x to the right, y away to the right, z up.
    pub fn space() -> View {
        View::from(-58_f64.to_radians(), 28_f64.to_radians())
    }

    /// From above: x to the right, y up.
    pub fn above() -> View {
        View { right: Vector3::x(), up: Vector3::y() }
    }

    /// From the front: x to the right, z up.
    pub fn front() -> View {
        View { right: Vector3::x(), up: Vector3::z() }
    }

    /// From the side: y to the right, z up.
    pub fn side() -> View {
        View { right: Vector3::y(), up: Vector3::z() }
    }

    /// To the right and up \[m\].
    pub fn plane(&self, point: Vector3<f64>) -> Vector2<f64> {
        Vector2::new(self.right.dot(&point), self.up.dot(&point))
    }
}

/// What points span in a view \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent {
    pub low: Vector2<f64>,
    pub high: Vector2<f64>,
}

impl Extent {
    /// Of points in a view; a point at the origin when there are none.
    pub fn of(points: impl Iterator<Item = Vector2<f64>>) -> Extent {
        let spanned = points.fold(None, |extent: Option<Extent>, point| {
            Some(extent.map_or(Extent { low: point, high: point }, |extent| Extent {
                low: extent.low.inf(&point),
                high: extent.high.sup(&point),
            }))
        });
        spanned.unwrap_or(Extent { low: Vector2::zeros(), high: Vector2::zeros() })
    }

    /// Widened about its middle to at least `least` \[m\] in each direction.
    pub fn at_least(self, least: f64) -> Extent {
        let middle = 0.5 * (self.low + self.high);
        let half = (0.5 * (self.high - self.low)).sup(&Vector2::repeat(0.5 * least));
        Extent { low: middle - half, high: middle + half }
    }

    pub fn size(&self) -> Vector2<f64> {
        self.high - self.low
    }

    /// The scale at which it just fits into an area [px/m], > 0 when the extent is no point.
    pub fn scale(&self, area: Area) -> f64 {
        let size = self.size();
        (area.width / size.x).min(area.height / size.y)
    }
}

/// A view on the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Projection {
    view: View,
    /// The middle of what is shown \[m\].
    middle: Vector2<f64>,
    /// Where that is on the page \[px\].
    centre: Vector2<f64>,
    /// [px/m]
    pub scale: f64,
}

impl Projection {
    /// Puts the middle of an extent into the middle of an area, at this scale [px/m].
    pub fn new(view: View, extent: &Extent, area: Area, scale: f64) -> Projection {
        let centre = Vector2::new(area.x + 0.5 * area.width, area.y + 0.5 * area.height);
        Projection { view, middle: 0.5 * (extent.low + extent.high), centre, scale }
    }

    /// Where a point of the world is on the page \[px\].
    pub fn at(&self, point: Vector3<f64>) -> Vector2<f64> {
        self.on_page(self.view.plane(point))
    }

    /// Where a point of the view's plane \[m\] is on the page \[px\].
    pub fn on_page(&self, point: Vector2<f64>) -> Vector2<f64> {
        let offset = (point - self.middle) * self.scale;
        self.centre + Vector2::new(offset.x, -offset.y)
    }

    /// What the area shows of the view's plane \[m\].
    pub fn shown(&self, area: Area) -> Extent {
        let half = Vector2::new(area.width, area.height) * (0.5 / self.scale);
        Extent { low: self.middle - half, high: self.middle + half }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_views_are_right_handed_and_look_at_what_they_say() {
        for view in [View::space(), View::above(), View::front()] {
            assert!(view.right.dot(&view.up).abs() < 1e-15);
            assert!((view.right.norm() - 1.0).abs() < 1e-15 && (view.up.norm() - 1.0).abs() < 1e-15);
        }
        let towards = |view: View| view.right.cross(&view.up);
        assert!((towards(View::above()) - Vector3::z()).norm() < 1e-15);
        assert!((towards(View::front()) + Vector3::y()).norm() < 1e-15);
        assert!((towards(View::side()) - Vector3::x()).norm() < 1e-15);
        let (azimuth, elevation) = (0.7_f64, 0.3_f64);
        let expected =
            Vector3::new(elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin());
        assert!((towards(View::from(azimuth, elevation)) - expected).norm() < 1e-15);
    }

    #[test]
    fn what_fits_just_touches_the_sides() {
        let points = [Vector2::new(-1.0, 0.0), Vector2::new(3.0, 1.0)];
        let extent = Extent::of(points.into_iter());
        let area = Area { x: 10.0, y: 20.0, width: 200.0, height: 300.0 };
        let scale = extent.scale(area);
        assert_eq!(scale, 50.0);
        let projection = Projection::new(View::front(), &extent, area, scale);
        assert_eq!(projection.at(Vector3::new(-1.0, 9.0, 0.0)), Vector2::new(10.0, 195.0));
        assert_eq!(projection.at(Vector3::new(3.0, -9.0, 1.0)), Vector2::new(210.0, 145.0));
        assert_eq!(projection.shown(area).low.x, -1.0);
    }
}
