//! What clips an outline: the page, a nested viewport or a clip path. An outline is not cut: what lies outside of a
//! viewport or clip path is left out, and what may lie partly outside, or lies outside of the page, is told of: programs
//! differ in what they show beyond the page.

use crate::drawing::{Affine, Bounds, Vec2};

/// How much of an outline is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Within {
    /// All of it.
    Whole,
    /// Perhaps not all of it.
    Part,
    /// Nothing.
    Nothing,
}

/// A clip within those round it.
pub struct Clip<'c> {
    /// A rectangle \[mm\]; `None` for any other shape.
    rectangle: Option<Bounds>,
    outer: Option<&'c Clip<'c>>,
    /// What is seen of an outline beyond the rectangle.
    beyond: Within,
}

/// How far an outline may lie outside and count as inside \[mm\]: `f32` over a plate.
const TOLERANCE: f64 = 1e-4;

impl<'c> Clip<'c> {
    /// The page with these corners \[mm\]. What lies beyond it is engraved.
    pub fn page(corners: [Vec2; 4]) -> Clip<'static> {
        let bounds = Bounds::around(corners);
        Clip { rectangle: bounds, outer: None, beyond: Within::Part }
    }

    /// A clip path of usvg, with the map to mm of what it clips.
    pub fn of(path: &usvg::ClipPath, map: &Affine, outer: Option<&'c Clip<'c>>) -> Self {
        let [usvg::Node::Path(shape)] = path.root().children() else {
            return Self { rectangle: None, outer, beyond: Within::Part };
        };
        let usvg::Transform { sx, kx, ky, sy, tx, ty } = path.transform();
        let [a, b, c, d, e, f] = [sx, ky, kx, sy, tx, ty].map(f64::from);
        let map = map.after(&Affine::new(a, b, c, d, e, f));
        let points = shape.data().points().iter();
        let points: Vec<Vec2> =
            points.map(|p| map.point(Vec2::new(f64::from(p.x), f64::from(p.y)))).collect();
        let bounds = Bounds::around(points.iter().copied());
        let near = |a: f64, b: f64| (a - b).abs() < TOLERANCE;
        let is_corner = |p: &Vec2| {
            bounds.is_some_and(|b| {
                (near(p.x, b.min.x) || near(p.x, b.max.x)) && (near(p.y, b.min.y) || near(p.y, b.max.y))
            })
        };
        let sides = points.windows(2).all(|w| near(w[0].x, w[1].x) || near(w[0].y, w[1].y));
        let is_rectangle =
            path.clip_path().is_none() && points.len() == 4 && sides && points.iter().all(is_corner);
        Self { rectangle: bounds.filter(|_| is_rectangle), outer, beyond: Within::Nothing }
    }

    /// How much of an outline with these bounds \[mm\] is seen.
    pub fn shows(&self, outline: &Bounds) -> Within {
        let own = match self.rectangle {
            None => Within::Part,
            Some(clip) => {
                let low = outline.min - clip.min;
                let high = clip.max - outline.max;
                let apart = [clip.max - outline.min, outline.max - clip.min];
                if low.min().min(high.min()) >= -TOLERANCE {
                    Within::Whole
                } else if apart.iter().any(|gap| gap.min() < -TOLERANCE) {
                    self.beyond
                } else {
                    Within::Part
                }
            }
        };
        match (own, self.outer.map_or(Within::Whole, |outer| outer.shows(outline))) {
            (Within::Nothing, _) | (_, Within::Nothing) => Within::Nothing,
            (Within::Whole, Within::Whole) => Within::Whole,
            _ => Within::Part,
        }
    }
}
