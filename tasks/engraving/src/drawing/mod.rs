//! Drawings: what the plate will show, as exact curves in millimetres.
//!
//! In flows a file (SVG, DXF or G-code) or a line of text in a single-stroke font; out flows an [`Import`]: the
//! [`Drawing`] and what the reader has to say about it. A drawing is a list of [`Stroke`]s, each a connected chain
//! of exact curve [`Piece`]s: nothing is flattened here. All bad input is refused with its file, line and remedy
//! before anything moves.

mod affine;
mod bezier;
mod bounds;
mod composed;
pub mod dxf;
mod ellipse;
mod flattening;
pub mod gcode;
mod height;
pub mod hershey;
mod import;
mod joining;
mod limits;
mod list;
mod manner;
mod nurbs;
mod piece;
mod spline;
mod stroke;
pub mod svg;

pub use affine::Affine;
pub use bezier::RationalBezier;
pub use bounds::Bounds;
pub use ellipse::EllipticalArc;
pub use height::Height;
pub use import::{Reading, read_bytes, read_file, read_str};
pub use joining::join_touching;
pub use limits::{Budget, Limits};
pub use list::{Drawing, Import, Order};
pub use manner::Manner;
pub(crate) use nurbs::PlanarNurbs;
pub use piece::Piece;
pub use spline::{NaturalSpline, smooth_pieces, smooth_ring};
pub use stroke::{Closure, Stroke};

/// A point or a displacement in the plane of the drawing \[mm\], x to the right, y up.
pub type Vec2 = nalgebra::Vector2<f64>;

/// The tool's tip: a place in the plane of the drawing and its height over the plate's surface \[mm\].
pub type Vec3 = nalgebra::Vector3<f64>;

/// The signed area of the parallelogram of two vectors: `a.x b.y - a.y b.x`.
#[must_use]
pub fn cross(a: Vec2, b: Vec2) -> f64 {
    a.x * b.y - a.y * b.x
}
