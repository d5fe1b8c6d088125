//! What stands in a cell and does not move, as simple solids for those who draw it.
//!
//! A cell keeps nothing away from it by this: what is drawn and what is avoided are told from the same file, by the crates
//! that know each.

use core::fmt;
use std::sync::Arc;

use nalgebra::Vector3;

use crate::model::pose::Pose;

/// A body that stands in a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct ObstacleLayout {
    /// Its name in the cell.
    pub name: String,
    /// The frame of its solid in the world, `X_WO` \[m\].
    pub pose: Pose,
    /// Its form.
    pub solid: Solid,
}

/// A form about its frame. All lengths are finite and > 0.
#[derive(Clone, Debug, PartialEq)]
pub enum Solid {
    /// A box about the origin.
    Box {
        /// Edges along x, y, z \[m\].
        edges: [f64; 3],
    },
    /// A cylinder with plane ends, the middle of its axis in the origin.
    Cylinder {
        /// Radius \[m\].
        radius: f64,
        /// Length along z \[m\].
        length: f64,
    },
    /// A cylinder with a half ball on each end, the middle of its axis in the origin.
    Capsule {
        /// Radius \[m\].
        radius: f64,
        /// Length of the cylinder along z, without the half balls \[m\].
        length: f64,
    },
    /// A ball about the origin.
    Ball {
        /// Radius \[m\].
        radius: f64,
    },
    /// All that lies below z = 0: a floor, a wall. It has no end, and is not drawn.
    HalfSpace,
    /// Balls about points: some of those that a scanner saw, or of the tops of a height field.
    Points {
        /// The points \[m\].
        points: Arc<[Vector3<f64>]>,
        /// Radius of each ball \[m\].
        radius: f64,
    },
    /// Several solids, each with its frame in this one \[m\]: the capsules that cover a mesh.
    Several(Arc<[(Pose, Solid)]>),
}

impl fmt::Display for Solid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Solid::Box { edges: [x, y, z] } => write!(f, "box, {x} x {y} x {z} m"),
            Solid::Cylinder { radius, length } => write!(f, "cylinder, radius {radius} m, length {length} m"),
            Solid::Capsule { radius, length } => write!(f, "capsule, radius {radius} m, length {length} m"),
            Solid::Ball { radius } => write!(f, "ball, radius {radius} m"),
            Solid::HalfSpace => f.write_str("half space"),
            Solid::Points { points, radius } => {
                write!(f, "points, {} are drawn, radius {radius} m", points.len())
            }
            Solid::Several(parts) => write!(f, "{} parts", parts.len()),
        }
    }
}
