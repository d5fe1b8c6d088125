//! The motion along a path between walls, as the coordinator orders it.
//!
//! ```text
//! taut path -> places, close on arcs -> cubic spline by length, in W -> the fastest motion within limits of the ball's two axes
//! ```

use mrroc::prelude::*;
use mrroc_generators::curve::{CubicSpline, CurveError, SplineEnds};
use mrroc_generators::profile::ProfileCursor;
use mrroc_generators::timing::{PathLimits, TimeOptimal, TimingError, grid};
use mrroc_map::{Place, Taut};
use mrroc_robots::Irp6;
use nalgebra::{Point3, Vector2};
use thiserror::Error;

use super::orders::Along;

/// Between two places on an arc or beside it, and on a line at most \[m\].
const FINE: f64 = 4e-4;
/// See [`FINE`].
const COARSE: f64 = 8e-3;
/// Velocity [m/s] and acceleration [m/s²] of the ball along each axis of the world: drives that follow with little lag keep it within 0.1 mm
/// of its path.
const LIMITS: PathLimits<Vector2<f64>> =
    PathLimits { velocity: Vector2::new(0.05, 0.05), acceleration: Vector2::new(0.2, 0.2), speed: 0.05 };

/// Orders the places of a path, from rest to rest.
pub struct Trace {
    path: CubicSpline<Vector2<f64>>,
    cursor: ProfileCursor<TimeOptimal>,
}

/// Why there is no motion.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum NoTrace {
    /// The path is no curve.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// There is no motion along it.
    #[error(transparent)]
    Timing(#[from] TimingError),
}

impl Trace {
    /// Along a path in a maze that stands at `X_WM`.
    ///
    /// # Errors
    /// A path without length.
    #[allow(non_snake_case)]
    pub fn along(path: &Taut, X_WM: &Pose) -> Result<Self, NoTrace> {
        let there = |place: &Place| X_WM.transform_point(&Point3::new(place.x, place.y, 0.0)).coords.xy();
        let points: Vec<_> = path.points(FINE, COARSE).iter().map(there).collect();
        let mut knots = vec![0.0];
        for leg in points.windows(2) {
            knots.push(knots[knots.len() - 1] + (leg[1] - leg[0]).norm());
        }
        let path = CubicSpline::new(knots, points, SplineEnds::Natural)?;
        let plan = TimeOptimal::plan(&path, &grid(&path, 0), &LIMITS, [0.0; 2])?;
        Ok(Self { path, cursor: ProfileCursor::new(plan) })
    }
}

#[generator(mp)]
impl Trace {
    fn next_step(&mut self, t: Tick) -> Step<(Irp6,), Along> {
        match self.cursor.advance(t.dt) {
            Some(point) => {
                let at = self.path.at(point.s).value;
                Step::Next((Along { x: at.x, y: at.y },))
            }
            None => Step::Done,
        }
    }
}
