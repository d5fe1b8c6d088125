//! What sensors give, as their physics says: from a scene to switched outputs and codes.

mod image;
mod light_barrier;
mod sounders;
mod triangulation;

pub use image::{Dark, Imager};
pub use light_barrier::{LightBarrier, Stuck};
pub use sounders::{Silent, Sounders};
pub use triangulation::{Triangulation, code_of, distance_of};
