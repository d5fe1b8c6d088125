//! The transforms of the document in `f64`, found by what usvg has rounded them to.
//!
//! usvg says which transforms lie round an outline, in `f32`. Each of them that the document states is known here in
//! `f64`; another, such as that of a marker, is good to `f32`, some 0.02 um on a plate.

use super::cascade::attribute;
use super::expansion::{Ids, used};
use super::source::{Source, name_of};
use super::units;
use crate::drawing::{Affine, Vec2};
use crate::error::DrawingError;
use roxmltree::Node;
use std::str::FromStr;

/// How far numbers of usvg's transforms may lie from the exact ones, over the greatest that they are computed from: some
/// steps of `f32`.
const ROUNDED: f64 = 4e-7;
/// Most of the document's transforms that are compared with one of usvg's.
const MOST_COMPARED: usize = 200;

/// The transforms of a document.
pub struct Transforms {
    /// In the order of their sums, which few of them share.
    sorted: Vec<(f64, Affine)>,
    /// The document's size [px]: usvg computes places as differences of such lengths.
    page: f64,
}

fn numbers(map: &Affine) -> [f64; 6] {
    [map.x_axis.x, map.x_axis.y, map.y_axis.x, map.y_axis.y, map.origin.x, map.origin.y]
}

/// Weights no two of which stand in a simple ratio, so that different transforms have different sums.
fn sum(map: &Affine) -> f64 {
    let weights = [1.0, 0.754_877, 0.569_840, 0.430_159, 0.324_717, 0.245_122];
    numbers(map).iter().zip(weights).map(|(n, w)| n * w).sum()
}

impl Transforms {
    /// All that the document states.
    ///
    /// # Errors
    /// [`DrawingError::Malformed`] for a `transform` or `viewBox` that cannot be read.
    pub fn of<'a>(source: &Source<'a>, ids: &Ids<'a>) -> Result<Self, DrawingError> {
        let mut maps = Vec::new();
        for node in source.document.descendants().filter(Node::is_element) {
            let name = name_of(node);
            if name.is_empty() {
                continue;
            }
            let own = own(source, node)?;
            let at = |n, axis| source.length(node, n, axis).map(|l| l.unwrap_or(0.0));
            match name {
                "svg" if node.parent_element().is_none() => {
                    maps.extend(view_map(source, node, source.page())?.map(|view| own.after(&view)));
                    maps.push(own);
                }
                "svg" => {
                    let place = Affine::translation(Vec2::new(at("x", 'x')?, at("y", 'y')?));
                    let view = view_map(source, node, source.extent(node))?;
                    let inner = view.map_or(place, |view| place.after(&view));
                    maps.extend([own, inner, own.after(&inner)]);
                }
                "use" => {
                    let place = Affine::translation(Vec2::new(at("x", 'x')?, at("y", 'y')?));
                    maps.extend([own, own.after(&place)]);
                    let Some(target) = used(node, ids).filter(|t| matches!(name_of(*t), "symbol" | "svg"))
                    else {
                        continue;
                    };
                    let is_svg = name_of(target) == "svg";
                    let otherwise = if is_svg { source.extent(target) } else { source.viewport(node) };
                    let size = Vec2::new(
                        source.length(node, "width", 'x')?.unwrap_or(otherwise.x),
                        source.length(node, "height", 'y')?.unwrap_or(otherwise.y),
                    );
                    if let Some(view) = view_map(source, target, size)? {
                        let start = |n, axis| source.length(target, n, axis).map(|l| l.unwrap_or(0.0));
                        let place = if is_svg {
                            Affine::translation(Vec2::new(start("x", 'x')?, start("y", 'y')?))
                        } else {
                            place
                        };
                        maps.extend([place.after(&view), own.after(&place).after(&view)]);
                    }
                }
                _ => maps.push(own),
            }
        }
        let mut sorted: Vec<_> = maps.into_iter().map(|map| (sum(&map), map)).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        sorted.dedup();
        Ok(Self { sorted, page: source.page().norm() })
    }

    /// The exact transform for one of usvg's.
    pub fn exact(&self, rounded: usvg::Transform) -> Affine {
        let usvg::Transform { sx, kx, ky, sy, tx, ty } = rounded;
        let [a, b, c, d, e, f] = [sx, ky, kx, sy, tx, ty].map(f64::from);
        let map = Affine::new(a, b, c, d, e, f);
        let greatest = |part: &[f64], least: f64| ROUNDED * part.iter().fold(least, |m, n| m.max(n.abs()));
        let all = numbers(&map);
        let (turn, place) = (greatest(&all[..4], 0.0), greatest(&all[4..], self.page));
        let off = |other: &Affine| {
            // In units of what is allowed.
            let off = numbers(other).into_iter().zip(all).zip([turn, turn, turn, turn, place, place]);
            off.map(|((a, b), allowed)| (a - b).abs() / allowed).fold(0.0, f64::max)
        };
        let (middle, reach) = (sum(&map), 4.0 * turn + 2.0 * place);
        let from = self.sorted.partition_point(|(s, _)| *s < middle - reach);
        let near = self.sorted[from..].iter().take(MOST_COMPARED).take_while(|(s, _)| *s <= middle + reach);
        let nearest = near.map(|(_, other)| (off(other), other)).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.filter(|(off, _)| *off <= 1.0).map_or(map, |(_, exact)| *exact)
    }
}

/// The element's own transform about its origin.
fn own<'a>(source: &Source<'a>, node: Node<'a, 'a>) -> Result<Affine, DrawingError> {
    let Some(text) = source.cascade.own(node, "transform") else { return Ok(Affine::IDENTITY) };
    let t = match svgtypes::Transform::from_str(&text) {
        Ok(t) => t,
        // In a style there may be what has no meaning here, such as three dimensions.
        Err(error)
            if attribute(node, "transform").is_some_and(|said| said.trim() == text && text != "none") =>
        {
            return Err(source.bad_data(node, "transform", 0, &error.to_string()));
        }
        Err(_) => return Ok(Affine::IDENTITY),
    };
    let map = Affine::new(t.a, t.b, t.c, t.d, t.e, t.f);
    let is_root = node.parent_element().is_none();
    let origin = source.cascade.own(node, "transform-origin");
    let origin = origin.and_then(|text| svgtypes::TransformOrigin::from_str(&text).ok());
    let origin = match origin {
        Some(origin) if is_root => {
            let page = source.page();
            let size = source.font_size(node);
            Vec2::new(
                units::to_px(origin.x_offset, page.x, size),
                units::to_px(origin.y_offset, page.y, size),
            )
        }
        Some(origin) => {
            Vec2::new(source.px(node, origin.x_offset, 'x'), source.px(node, origin.y_offset, 'y'))
        }
        None if is_root => source.page() * 0.5,
        None => return Ok(map),
    };
    Ok(Affine::translation(origin).after(&map).after(&Affine::translation(-origin)))
}

fn view_map<'a>(source: &Source<'a>, node: Node<'a, 'a>, size: Vec2) -> Result<Option<Affine>, DrawingError> {
    let view = source.view_box(node)?;
    Ok(view.map(|view| units::view_box_map(view, size.x, size.y, attribute(node, "preserveAspectRatio"))))
}
