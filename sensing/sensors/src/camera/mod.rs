//! A camera's geometry: between pixels, rays, and the plane of a belt.

mod model;
mod plane;

pub use model::{Camera, Lens};
pub use plane::Plane;
