//! Meshes of triangles, read from files, and capsules that cover them.
//!
//! ```text
//! STL, OBJ, COLLADA --file--> TriangleMesh --cover--> Cover: capsules, and how far they stand out
//!
//! cover:  search (greedy) --- patches (what is covered)      proof: each patch in one capsule
//!           '--- grid (levels, about) --- solid (levels) --- bound: no capsule stands out farther than the excess
//!                                           '--- surface (distances, rays)
//! ```

mod bound;
mod cover;
mod dae;
mod error;
mod file;
mod grid;
mod obj;
mod patches;
mod search;
mod solid;
mod stl;
mod surface;
mod text;
mod triangles;

pub use cover::{Cover, MOST_CAPSULES, cover};
pub use error::MeshError;
pub use file::MESH_EXTENSIONS;
pub use triangles::TriangleMesh;
