//! What stands in a cell and does not move, as simple solids for those who draw it.
//!
//! A cell keeps nothing away from it by this: what is drawn and what is avoided are told from the same file, by the crates
//! that know each.

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
    /// Balls about points: some of those that a scanner saw, or of the tops of a height field.
    Points {
        /// The points \[m\].
        points: Arc<[Vector3<f64>]>,
        /// Radius of each ball \[m\].
        radius: f64,
    },
}
