//! How a body moves: a pose of its frame for every instant of path time.
//!
//! In: increments of path time, which the operator's speed and Suspend scale. Out: `X_WB`, the exact end once, then
//! nothing. A path begins at rest where the body is, and learns that when it begins.

use mrroc::prelude::*;
use nalgebra::Translation3;

use crate::bspline::{SpanStream, SplinePoint, SplineSettings};
use crate::feed::{FedPath, FeedError, FeedLimits};
use crate::line::{LinePath, ToolLimits};
use crate::profile::ProfileCursor;

/// A Cartesian path of a body.
pub trait BodyPath {
    /// Begins where the body is, at `X_WB`.
    ///
    /// # Errors
    /// A limit or a goal that makes no path.
    #[allow(non_snake_case)]
    fn begin(&mut self, X_WB: &Pose) -> Result<(), Fault>;

    /// `X_WB` after `dt` \[s\], >= 0, more of path time; the exact end once, then `None`.
    ///
    /// # Errors
    /// A path that turns out to be faulty during the motion.
    fn advance(&mut self, dt: f64) -> Result<Option<Pose>, Fault>;
}

/// Where a straight line ends.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Goal {
    /// `X_WB` of the end.
    Pose(Pose),
    /// `X_BsB`, the end in the body's frame of the start.
    Displacement(Pose),
}

/// Along a straight line while the body turns through the smaller angle, by one trapezoidal profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightBody {
    goal: Goal,
    limits: ToolLimits,
    path: Option<(LinePath, ProfileCursor)>,
}

impl StraightBody {
    /// To `X_WB` in the world.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn to(X_WB: Pose, limits: ToolLimits) -> Self {
        StraightBody { goal: Goal::Pose(X_WB), limits, path: None }
    }

    /// By `X_BsB`, in the body's own axes at the start.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn by(X_BsB: Pose, limits: ToolLimits) -> Self {
        StraightBody { goal: Goal::Displacement(X_BsB), limits, path: None }
    }
}

impl BodyPath for StraightBody {
    #[allow(non_snake_case)]
    fn begin(&mut self, X_WB: &Pose) -> Result<(), Fault> {
        let goal = match self.goal {
            Goal::Pose(pose) => pose,
            Goal::Displacement(displacement) => X_WB * displacement,
        };
        let line = LinePath::new(*X_WB, goal);
        let profile = line.profile(self.limits).map_err(|error| Fault::thrown(&error.to_string()))?;
        self.path = Some((line, ProfileCursor::new(profile)));
        Ok(())
    }

    fn advance(&mut self, dt: f64) -> Result<Option<Pose>, Fault> {
        let Some((line, cursor)) = &mut self.path else { return Ok(None) };
        Ok(cursor.advance(dt).map(|point| line.pose(point.s)))
    }
}

/// The moving-segment B-spline of the body's origin, at the orientation of the start, from rest to rest.
#[derive(Clone, Debug)]
pub struct SplineBody<I> {
    path: FedPath<SpanStream<I>>,
    start: Pose,
}

impl<I> SplineBody<I>
where
    I: Iterator,
    I::Item: Into<SplinePoint>,
{
    /// Through `points` \[m\] from the origin's place at the start, along the world's axes; the first is zero.
    ///
    /// # Errors
    /// A setting or a limit out of range.
    pub fn through<J>(points: J, spline: SplineSettings, feed: FeedLimits) -> Result<Self, FeedError>
    where
        J: IntoIterator<IntoIter = I>,
    {
        Ok(SplineBody {
            path: FedPath::new(feed, SpanStream::new(spline, points)?)?,
            start: Pose::identity(),
        })
    }
}

impl<I> BodyPath for SplineBody<I>
where
    I: Iterator,
    I::Item: Into<SplinePoint>,
{
    #[allow(non_snake_case)]
    fn begin(&mut self, X_WB: &Pose) -> Result<(), Fault> {
        self.start = *X_WB;
        Ok(())
    }

    fn advance(&mut self, dt: f64) -> Result<Option<Pose>, Fault> {
        match (self.path.advance(dt), self.path.error()) {
            (Some(point), _) => Ok(Some(Translation3::from(point.position) * self.start)),
            (None, Some(error)) => Err(Fault::thrown(&error.to_string())),
            (None, None) => Ok(None),
        }
    }
}

/// A function of path time: `X_BsB(t)`, the displacement from the start in the body's own axes of that moment.
#[derive(Clone, Copy, Debug)]
pub struct TimedBody<F> {
    displacement: F,
    duration: f64,
    time: f64,
    start: Pose,
    ended: bool,
}

impl<F: FnMut(f64) -> Pose> TimedBody<F> {
    /// Along `displacement` of path time, 0 to `duration` \[s\]; identity and at rest at 0, at rest at the end.
    #[must_use]
    pub fn new(duration: f64, displacement: F) -> Self {
        TimedBody { displacement, duration, time: 0.0, start: Pose::identity(), ended: false }
    }
}

impl<F: FnMut(f64) -> Pose> BodyPath for TimedBody<F> {
    #[allow(non_snake_case)]
    fn begin(&mut self, X_WB: &Pose) -> Result<(), Fault> {
        if !(self.duration.is_finite() && self.duration >= 0.0) {
            return Err(Fault::thrown("the duration of a body's path must be finite and not negative"));
        }
        self.start = *X_WB;
        self.time = 0.0;
        self.ended = false;
        Ok(())
    }

    fn advance(&mut self, dt: f64) -> Result<Option<Pose>, Fault> {
        if self.ended {
            return Ok(None);
        }
        self.time += dt;
        // The sum of n increments may miss n * dt by rounding; that must not cost a step.
        if self.duration - self.time <= 1e-9 * dt {
            self.time = self.duration;
            self.ended = true;
        }
        Ok(Some(self.start * (self.displacement)(self.time)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::ProfileLimits;
    use nalgebra::Vector3;

    fn walk(path: &mut impl BodyPath, from: &Pose, dt: f64) -> Vec<Pose> {
        path.begin(from).expect("limits in range");
        core::iter::from_fn(|| path.advance(dt).expect("a good path")).collect()
    }

    fn start() -> Pose {
        Pose::new(Vector3::new(0.8, -0.3, 0.5), Vector3::new(3.0, 0.1, -0.2))
    }

    #[test]
    fn a_straight_path_ends_where_it_is_told_in_the_closed_form_time() {
        let limits = ProfileLimits { velocity: 0.2, acceleration: 1.0 };
        let limits = ToolLimits { translation: limits, rotation: limits };
        let goal = Pose::translation(0.0, 0.1, 0.0) * start();
        let poses = walk(&mut StraightBody::to(goal, limits), &start(), 1e-3);
        // D / V + V / A = 0.5 + 0.2 s.
        assert_eq!((poses.len(), poses[699]), (700, goal));
        let poses = walk(&mut StraightBody::by(Pose::translation(0.0, 0.1, 0.0), limits), &start(), 1e-3);
        assert_eq!(poses[699], start() * Pose::translation(0.0, 0.1, 0.0));
    }

    #[test]
    fn a_function_of_path_time_is_told_the_sum_of_the_increments_and_its_exact_end() {
        let turn = |t: f64| Pose::rotation(Vector3::z() * t * t);
        let poses = walk(&mut TimedBody::new(0.5, turn), &start(), 0.1);
        assert_eq!(poses.len(), 5);
        assert!((poses[2].rotation.inverse() * (start() * turn(0.3)).rotation).angle() < 1e-7);
        assert_eq!(poses[4], start() * turn(0.5));
    }

    #[test]
    fn a_spline_starts_from_the_body_and_keeps_its_orientation() {
        let points = (0..=20).map(|i| f64::from(i) * 0.01).map(|x| Vector3::new(x, x * x, 0.0));
        let feed = FeedLimits {
            feed: 0.1,
            tangential: 0.5,
            normal: 0.5,
            step: 1e-3,
            chord_error: f64::INFINITY,
            jerk: f64::INFINITY,
        };
        let mut path = SplineBody::through(points, SplineSettings::default(), feed).expect("in range");
        let poses = walk(&mut path, &start(), 1e-3);
        let last = poses.last().expect("a path");
        let end = start().translation.vector + Vector3::new(0.2, 0.04, 0.0);
        assert!((last.translation.vector - end).norm() < 1e-12);
        assert!(poses.iter().all(|pose| pose.rotation == start().rotation));
    }
}
