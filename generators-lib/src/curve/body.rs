//! A body on a curve.

use mrroc::prelude::*;
use nalgebra::{Translation3, Vector3};

use super::Curve;
use crate::cooperation::BodyPath;
use crate::profile::{Profile, ProfileCursor};

/// Leads a body along any curve by any profile, at the orientation of its start: the curve's displacements from its own
/// start, along the world's axes.
#[derive(Clone, Debug)]
pub struct CurveBody<C, P> {
    curve: C,
    cursor: ProfileCursor<P>,
    start: Pose,
    origin: Vector3<f64>,
}

impl<C: Curve, P: Profile> CurveBody<C, P> {
    /// Along `curve` by `profile`, whose distance is the curve's length.
    #[must_use]
    pub fn new(curve: C, profile: P) -> Self {
        let origin = curve.at(0.0).position;
        CurveBody { curve, cursor: ProfileCursor::new(profile), start: Pose::identity(), origin }
    }
}

impl<C: Curve, P: Profile> BodyPath for CurveBody<C, P> {
    #[allow(non_snake_case)]
    fn begin(&mut self, X_WB: &Pose) -> Result<(), Fault> {
        let distance = self.cursor.profile().distance();
        let length = self.curve.length();
        if (distance - length).abs() > 1e-9 * length {
            return Err(Fault::thrown("the distance of the profile is not the length of the curve"));
        }
        self.start = *X_WB;
        Ok(())
    }

    fn advance(&mut self, dt: f64) -> Result<Option<Pose>, Fault> {
        Ok(self.cursor.advance(dt).map(|point| {
            let displacement = self.curve.at(point.s).position - self.origin;
            Translation3::from(displacement) * self.start
        }))
    }
}
