//! Covers a mesh by few capsules, and proves it.
//!
//! In: a [`TriangleMesh`] and how far a cover may stand out. Out: [`Cover`]. Two things are proven of it, up to round-off:
//!
//! - **All is covered.** The triangles are cut into patches, and each patch lies in one capsule: that is convex, so it
//!   holds a triangle whose corners it holds.
//! - **Little else is.** No capsule has a point that is farther than the excess from the filled volume (`solid.rs`, `bound.rs`).
//!
//! How few capsules there are is not proven. They are found greedily: capsules through the centres of largest inner balls (the medial
//! axis), as far as they go along the edges of the body and in 13 directions, then improved by
//! moving their ends. Patches that few balls can cover count for more.

use super::error::MeshError;
use super::patches::{Holder, Patch};
use super::search::Search;
use super::triangles::TriangleMesh;
use crate::models::shape::Capsule;

/// Most capsules of a cover.
pub const MOST_CAPSULES: usize = 600;

/// The largest body that is covered, as a multiple of the excess \[1\]: 5 m at 5 mm.
const LARGEST: f64 = 1000.0;

/// Part of all that there is to cover that a capsule must cover at first \[1\].
const WORTH: f64 = 0.01;

/// Capsules that cover a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Cover {
    /// The capsules, in the frame of the mesh; a ball has its ends in one point.
    pub capsules: Vec<Capsule>,
    /// No point of a capsule is farther than this from the filled volume of the mesh \[m\], at most the excess that was asked for.
    pub excess: f64,
}

/// Capsules that hold all triangles of a mesh, and no point that is farther than `excess` \[m\], finite and above 0, from its filled
/// volume.
///
/// **The filled volume** is the triangles, and the inside of each part that is closed. A part is a set of triangles that hang
/// together; it is closed if each of its edges has an even number of triangles. Which side of a triangle is outside says nothing. A part that
/// is not closed is a sheet without an inside, and needs many capsules: [`TriangleMesh::with_openings_closed`] makes a body of it.
///
/// The same mesh and excess give the same capsules. For the links of arms (0.1 to 0.5 m, 300 to 1000 triangles) at 5 mm it takes
/// about a second, and 25 to 80 capsules; bodies made of parts that touch one another need several times as many.
///
/// # Errors
/// [`MeshError::Excess`], [`MeshError::TooFine`] for a body of more than a thousand times the excess, or [`MeshError::TooMany`] where
/// more than [`MOST_CAPSULES`] would be needed.
pub fn cover(mesh: &TriangleMesh, excess: f64) -> Result<Cover, MeshError> {
    if !(excess.is_finite() && excess > 0.0) {
        return Err(MeshError::Excess { excess });
    }
    let [least, most] = mesh.bounds();
    let size = (most - least).norm();
    if size > LARGEST * excess {
        return Err(MeshError::TooFine { size, excess, limit: LARGEST });
    }
    let mut search = Search::of(mesh, excess);
    let mut capsules = Vec::new();
    // The most worthy of all first, as long as they are worth it.
    let mut pool = search.pool();
    let least = WORTH * search.worth();
    while let Some(ends) = search.best(&mut pool, least) {
        capsules.extend(search.proven(ends).filter(|capsule| search.take(capsule)));
    }
    // What is left is told apart better, and covered piece by piece.
    search.refine(&capsules);
    while let Some(patch) = search.hardest() {
        if capsules.len() >= MOST_CAPSULES {
            let open_edges = mesh.open_edges().len();
            return Err(MeshError::TooMany { limit: MOST_CAPSULES, excess, open_edges });
        }
        match search.around(&patch) {
            Some(capsule) => {
                search.take(&capsule);
                capsules.push(capsule);
            }
            None => search.split(&patch),
        }
    }
    Ok(Cover { capsules: needed(capsules, search.held()), excess })
}

/// The capsules without those whose patches others hold.
fn needed(mut capsules: Vec<Capsule>, held: &[Patch]) -> Vec<Capsule> {
    let mut holders = vec![0_u32; held.len()];
    let patches_of = capsules.iter().map(|capsule| {
        let holder = Holder::of(capsule);
        (0..held.len()).filter(|at| holder.holds(&held[*at])).collect()
    });
    let patches_of: Vec<Vec<usize>> = patches_of.collect();
    patches_of.iter().flatten().for_each(|at| holders[*at] += 1);
    // Those that hold least go first.
    let mut order: Vec<usize> = (0..capsules.len()).collect();
    order.sort_by_key(|i| patches_of[*i].len());
    let mut is_needed = vec![true; capsules.len()];
    for i in order {
        if patches_of[i].iter().all(|at| holders[*at] > 1) {
            is_needed[i] = false;
            patches_of[i].iter().for_each(|at| holders[*at] -= 1);
        }
    }
    let mut is_needed = is_needed.into_iter();
    capsules.retain(|_| is_needed.next().unwrap_or(true));
    capsules
}
