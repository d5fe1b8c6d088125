//! The moving-segment B-spline through a stream of points, from rest to rest.

use core::marker::PhantomData;

use mrroc::{Demand, Fault, Pose, Robot, Step, Tick, generator};
use nalgebra::{Translation3, UnitQuaternion};

use mrroc_generators::bspline::{SpanStream, SplinePoint, SplineSettings};
use mrroc_generators::feed::{FedPath, FeedError, FeedLimits};

/// Leads the tool along the curve through points that come one by one, at a steady orientation.
///
/// The curve spans eight points at a time, of which only the piece between the first two is used before the
/// window moves on by one, so memory does not grow with the path. The tool must stand at the first point.
pub struct SplineTrack<R, I> {
    path: FedPath<SpanStream<I>>,
    frame: Pose,
    orientation: UnitQuaternion<f64>,
    of: PhantomData<R>,
}

impl<R: Robot, I> SplineTrack<R, I>
where
    I: Iterator,
    I::Item: Into<SplinePoint>,
{
    /// Through `points` \[m\] of a frame P, which lies at `X_WP` in the world, with the tool at `R_PE` in it.
    ///
    /// # Errors
    /// A setting or a limit out of range.
    #[allow(non_snake_case)]
    pub fn through<J>(
        points: J,
        spline: SplineSettings,
        feed: FeedLimits,
        X_WP: Pose,
        R_PE: UnitQuaternion<f64>,
    ) -> Result<Self, FeedError>
    where
        J: IntoIterator<IntoIter = I>,
    {
        let path = FedPath::new(feed, SpanStream::new(spline, points)?)?;
        Ok(SplineTrack { path, frame: X_WP, orientation: R_PE, of: PhantomData })
    }
}

#[generator(ecp)]
impl<R: Robot, I> SplineTrack<R, I>
where
    I: Iterator,
    I::Item: Into<SplinePoint>,
{
    fn next_step(&mut self, t: Tick) -> Result<Step<R>, Fault> {
        match self.path.advance(t.dt) {
            Some(point) => {
                let pose = Pose::from_parts(Translation3::from(point.position), self.orientation);
                Ok(Step::Next(Demand::pose(self.frame * pose)))
            }
            None => match self.path.error() {
                Some(error) => Err(Fault::thrown(&error.to_string())),
                None => Ok(Step::Done),
            },
        }
    }
}
