//! Why something cannot be an obstacle.

use nalgebra::Vector3;

/// Numbers that make no obstacle.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ObstacleError {
    /// A cloud of no points.
    #[error("a cloud has no points: give at least one, or leave the obstacle out")]
    EmptyCloud,
    /// A point that is NaN, infinite or beyond what single precision holds.
    #[error(
        "point {index} of a cloud is ({:?}, {:?}, {:?}) m: leave out points that were not measured, and give metres",
        .point.x, .point.y, .point.z
    )]
    BadPoint {
        /// Its number, counted from 0.
        index: usize,
        /// The point \[m\].
        point: Vector3<f64>,
    },
    /// More points than a cloud may have.
    #[error("a cloud has {points} points, {most} are the most: thin it by Cloud::thinned")]
    TooManyPoints {
        /// How many were given.
        points: usize,
        /// How many may be.
        most: usize,
    },
    /// What a point stands for is not a ball.
    #[error("the radius of a cloud's points is {radius} m: it must be finite and above 0")]
    BadRadius {
        /// The radius \[m\].
        radius: f64,
    },
    /// The grid on which a cloud is thinned, or of a height field, has no size.
    #[error("a cell of {cell} m: it must be finite and above 0")]
    BadCell {
        /// The edge of a cell \[m\].
        cell: f64,
    },
    /// A list of no capsules.
    #[error("a body of no capsules: give at least one, or leave the obstacle out")]
    NoCapsules,
    /// More capsules than a body may have.
    #[error("a body of {capsules} capsules, {most} are the most: cover it by fewer and larger ones")]
    TooManyCapsules {
        /// How many were given.
        capsules: usize,
        /// How many may be.
        most: usize,
    },
    /// A capsule with ends that are not finite or with a radius that is not above 0.
    #[error("capsule {index} of a body: its ends must be finite, its radius finite and above 0")]
    BadCapsule {
        /// Its number, counted from 0.
        index: usize,
    },
    /// Heights that make no grid.
    #[error(
        "a height field of {heights} heights in rows of {columns}: give at least one, full rows, and {most} at most"
    )]
    BadGrid {
        /// How many were given.
        heights: usize,
        /// How many a row has.
        columns: usize,
        /// How many there may be in all.
        most: usize,
    },
    /// A height that is NaN or infinite.
    #[error("the height in column {column} of row {row} is {height} m: it must be finite")]
    BadHeight {
        /// The column, along x, counted from 0.
        column: usize,
        /// The row, along y, counted from 0.
        row: usize,
        /// The height \[m\].
        height: f64,
    },
    /// A pose that is not finite.
    #[error("the pose of an obstacle has numbers that are not finite")]
    BadPose,
}
