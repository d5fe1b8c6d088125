//! What hangs on the links between base and tip without lying between them: hands, fingers, cameras, covers.
//!
//! In: the links of the chain, with their places. Out: their collision shapes as capsules, and those of what hangs on them wherever its own
//! joints may stand: the outline of an arm knows of the joints between base and tip alone.

use mrroc::prelude::*;
use mrroc::robot::JointKind;
use nalgebra::Vector3;

use super::collision::{LinkCapsule, Shapes};
use super::document::{Joint, Tree, origin, shown};
use super::error::UrdfError;
use super::places::{axis, displaced, moves};
use crate::models::shape::Capsule;

/// The most joints behind one another off the chain.
const DEEPEST: usize = 32;

/// In how many pieces the range of a joint is divided at most. Where that is not fine enough, balls take the place of capsules.
const MOST_PIECES: usize = 64;

/// The most capsules of all that hangs on one joint off the chain; with more of them, balls take their place.
const MOST_CAPSULES: usize = 2000;

/// A capsule and the link that it is of.
type Named = (String, Capsule);

/// Adds the shapes of `link`, which stands at `X_JL` in the frame of the last joint that moves it, and of all that hangs on it but `next`,
/// the link that follows in the chain.
#[allow(non_snake_case)]
pub(super) fn collect(
    shapes: &mut Shapes<'_>,
    tree: &Tree<'_, '_>,
    (link, next): (&str, Option<&str>),
    X_JL: &Pose,
    joints: usize,
) -> Result<(), UrdfError> {
    let mut found = shapes.of_link(tree, link)?.into_iter().map(|capsule| (shown(link), capsule)).collect();
    hanging(shapes, tree, (link, next), &mut found, 0)?;
    let placed = found.into_iter().map(|(link, capsule)| (link, capsule.moved(X_JL)));
    shapes.bodies.extend(placed.map(|(link, capsule)| LinkCapsule { link, joints, capsule }));
    Ok(())
}

/// Appends what hangs on a link but `next`, in the link's frame.
fn hanging(
    shapes: &mut Shapes<'_>,
    tree: &Tree<'_, '_>,
    (link, next): (&str, Option<&str>),
    found: &mut Vec<Named>,
    depth: usize,
) -> Result<(), UrdfError> {
    for joint in tree.below(link) {
        if Some(joint.child) == next || shapes.is_left_out(joint.child) {
            continue;
        }
        if depth >= DEEPEST {
            return Err(UrdfError::TooDeep { link: shown(joint.child), limit: DEEPEST });
        }
        let of_child = shapes.of_link(tree, joint.child)?;
        let mut behind: Vec<Named> =
            of_child.into_iter().map(|capsule| (shown(joint.child), capsule)).collect();
        hanging(shapes, tree, (joint.child, None), &mut behind, depth + 1)?;
        wherever(joint, tree, behind, shapes.excess(), found)?;
    }
    Ok(())
}

/// Appends what a joint carries, wherever it stands within its range, in the frame of the joint's parent. Capsules grow by at most `excess`
/// \[m\] by that, unless they would become too many.
#[allow(non_snake_case)]
fn wherever(
    joint: &Joint<'_, '_>,
    tree: &Tree<'_, '_>,
    carried: Vec<Named>,
    excess: f64,
    found: &mut Vec<Named>,
) -> Result<(), UrdfError> {
    let X_PJ = origin(&joint.element, tree.has_quaternions)?;
    let Some(moves) = moves(joint)? else {
        found.extend(carried.into_iter().map(|(link, capsule)| (link, capsule.moved(&X_PJ))));
        return Ok(());
    };
    if carried.is_empty() {
        return Ok(());
    }
    let axis = axis(joint)?;
    let (lower, upper) = moves.range;
    let full = core::f64::consts::TAU;
    let (lower, upper) = match moves.kind {
        JointKind::Revolute if upper - lower > full => (0.0, full),
        JointKind::Revolute | JointKind::Prismatic => (lower, upper),
    };
    // How far a unit of the joint moves any point of what it carries: 1 for a slide, the distance from the axis for a turn.
    let lever = match moves.kind {
        JointKind::Prismatic => 1.0,
        JointKind::Revolute => farthest(&carried, &axis),
    };
    let half = 0.5 * lever * (upper - lower);
    let pieces = (half / excess).ceil().max(1.0);
    if pieces <= MOST_PIECES as f64 && pieces * carried.len() as f64 <= MOST_CAPSULES as f64 {
        for k in 0..pieces as usize {
            let at = lower + (upper - lower) * (k as f64 + 0.5) / pieces;
            let X_PC = X_PJ * displaced(moves.kind, axis * at);
            found.extend(carried.iter().map(|(link, capsule)| {
                let [a, b] = capsule.ends;
                (link.clone(), Capsule::new(a, b, capsule.radius + half / pieces).moved(&X_PC))
            }));
        }
        return Ok(());
    }
    // One body for each link, however many capsules it has.
    let mut links: Vec<&str> = carried.iter().map(|(link, _)| link.as_str()).collect();
    links.sort_unstable();
    links.dedup();
    for link in links {
        let of_link = carried.iter().filter(|(name, _)| name == link).map(|(_, capsule)| capsule);
        let radius = of_link.map(reach).fold(0.0, f64::max);
        // About the origin of the joint, which a turn leaves where it is.
        let [from, to] = match moves.kind {
            JointKind::Revolute => [0.0; 2],
            JointKind::Prismatic => [lower, upper],
        };
        found.push((link.to_owned(), Capsule::new(axis * from, axis * to, radius).moved(&X_PJ)));
    }
    Ok(())
}

/// The greatest distance of a capsule from the origin.
fn reach(capsule: &Capsule) -> f64 {
    capsule.ends.iter().map(Vector3::norm).fold(0.0, f64::max) + capsule.radius
}

/// The greatest distance of any of them from an axis through the origin.
fn farthest(carried: &[Named], axis: &Vector3<f64>) -> f64 {
    let ends = carried.iter().flat_map(|(_, capsule)| capsule.ends.map(|end| (end, capsule.radius)));
    ends.map(|(end, radius)| axis.cross(&end).norm() + radius).fold(0.0, f64::max)
}
