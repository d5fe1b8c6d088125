//! Moves the tool on a B-spline through a stream of points, from rest to rest.

use core::marker::PhantomData;

use mrroc::prelude::*;
use nalgebra::{Translation3, UnitQuaternion};

use mrroc_generators::bspline::{SpanStream, SplinePoint, SplineSettings};
use mrroc_generators::feed::{FedPath, FeedError, FeedLimits};

/// Moves the tool along the moving-segment B-spline through points that come one by one, with a constant orientation.
///
/// The curve is computed from eight points at a time. Only its piece between the first two is used before this window
/// moves on by one point, so memory does not grow with the path. The tool must stand at the first point.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::bspline::SplineSettings;
/// use mrroc_generators::feed::FeedLimits;
/// use mrroc_generators::generators::SplineTrack;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::Irp6;
/// use nalgebra::{UnitQuaternion, Vector3};
///
/// // Points of a wave, in the coordinates of the tool as it stands; they may come from any iterator.
/// let point = |i: i32| Vector3::new(0.002 * f64::from(i), 0.01 * (0.2 * f64::from(i)).sin(), 0.0);
/// let (tangential, normal, chord_error, jerk) = (0.5, 0.5, f64::INFINITY, f64::INFINITY);
/// let feed = FeedLimits { feed: 0.1, tangential, normal, step: 0.002, chord_error, jerk };
/// let irp6 = Irp6::nominal();
/// let (at, upright) = (irp6.forward(&Irp6::READY), UnitQuaternion::identity());
/// let track = SplineTrack::through((0..=50).map(point), SplineSettings::default(), feed, at, upright);
/// let track = track.map_err(|bad| Fault::thrown(&bad.to_string()))?;
/// let demands = rehearse(track, &irp6, Irp6::READY, 0.002)?;
/// let end = demands.last().and_then(Demand::as_pose).map(|end| at.inv_mul(&end).translation.vector);
/// assert!(end.is_some_and(|end| (end - point(50)).norm() < 1e-6), "{end:?}");
/// # Ok::<(), Fault>(())
/// ```
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

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::observe::ServoRecord;

    use mrroc_robots::{Irp6, SimulatedIrp6};
    use nalgebra::Vector3;
    use std::{cell::RefCell, rc::Rc, time::Duration};

    #[test]
    fn a_circle_of_points_is_tracked_as_a_circle() {
        const RADIUS: f64 = 0.02;
        const SPAN: f64 = std::f64::consts::TAU / 48.0;
        let irp6 = Irp6::nominal();
        let start = Irp6::READY;
        let points = (0..=48)
            .map(|i| f64::from(i) * SPAN)
            .map(|angle| Vector3::new(angle.cos(), angle.sin(), 0.0) * RADIUS);
        let feed = FeedLimits {
            feed: 0.02,
            tangential: 0.2,
            normal: 0.2,
            step: 2e-3,
            chord_error: f64::INFINITY,
            jerk: f64::INFINITY,
        };
        // The tool stands at the circle's first point.
        let frame = irp6.forward(&start) * Pose::translation(-RADIUS, 0.0, 0.0);
        let track = SplineTrack::through(
            points.collect::<Vec<_>>(),
            SplineSettings::default(),
            feed,
            frame,
            UnitQuaternion::identity(),
        );
        let mut track = Some(track.expect("settings in range"));
        let trace = Rc::new(RefCell::new(Vec::new()));
        let recorder = Rc::clone(&trace);
        let robot = RobotSetup::new("irp6", irp6.clone(), SimulatedIrp6::new(irp6.clone(), &start))
            .observe(move |record: &ServoRecord<Irp6>| recorder.borrow_mut().push(record.demanded))
            .program(move |ecp| ecp.move_robot((), track.take().expect("one run")).map(drop));
        let report = Cell::new(Duration::from_millis(2)).robot(robot).run().expect("within the limits");
        // T = D / V + V / A = 2 pi r / V + V / A.
        let least = std::f64::consts::TAU * RADIUS / 0.02 + 0.02 / 0.2;
        let duration = report.time.as_secs_f64();
        assert!((least - 0.01..least + 0.05).contains(&duration), "{duration} s, {least} s");
        for q in trace.borrow().iter() {
            let p = frame.inv_mul(&irp6.forward(q)).translation.vector;
            // A natural end has no curvature where the circle has 1 / r: an error of at most 0.05 h^2 / r.
            assert!((p.xy().norm() - RADIUS).abs() < 0.05 * SPAN * SPAN * RADIUS && p.z.abs() < 1e-5, "{p}");
        }
    }
}
