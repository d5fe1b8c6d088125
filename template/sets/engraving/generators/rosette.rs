//! A rosette with three leaves: a generator of the library, through points of your own.

use std::f64::consts::PI;

use mrroc::prelude::*;
use mrroc_generators::bspline::SplineSettings;
use mrroc_generators::feed::FeedLimits;
use mrroc_generators::generators::SplineTrack;
use nalgebra::{Translation3, Vector3};

use crate::arm::Arm;

/// How deep it is engraved [m].
pub const DEPTH: f64 = 0.0005;

/// Length of a leaf [m].
const LEAF: f64 = 0.04;

/// FILL IN: the points of your curve, in order; x and y from the middle of the plate, z into it below 0 [m].
fn points() -> Vec<Vector3<f64>> {
    let steps = 240;
    let angles = (0..=steps).map(|i| PI * (f64::from(i) / f64::from(steps) - 0.5));
    let place = |angle: f64| LEAF * (3.0 * angle).cos() * Vector3::new(angle.cos(), angle.sin(), 0.0);
    angles.map(|angle| place(angle) - Vector3::z() * DEPTH).collect()
}

/// Leads the tool along the curve; where the plate was found, `X_WE`, gives its height and the tool's orientation.
#[allow(non_snake_case)]
pub fn rosette(X_WE: &Pose) -> Result<SplineTrack<Arm, std::vec::IntoIter<Vector3<f64>>>, Fault> {
    let feed = FeedLimits {
        feed: 0.02,
        tangential: 0.2,
        normal: 0.2,
        step: 0.002,
        chord_error: f64::INFINITY,
        jerk: f64::INFINITY,
    };
    let X_WP = Pose::from_parts(Translation3::from(X_WE.translation.vector), Default::default());
    SplineTrack::through(points(), SplineSettings::default(), feed, X_WP, X_WE.rotation)
        .map_err(|error| Fault::thrown(&error.to_string()))
}
