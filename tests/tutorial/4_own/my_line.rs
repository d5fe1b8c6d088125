//! Moves the tool on a straight line to a pose, from rest to rest.

use core::marker::PhantomData;

use mrroc::prelude::*;

use mrroc_generators::line::{LinePath, MotionLimits, ToolLimits};
use mrroc_generators::profile::ProfileCursor;

/// Moves the tool straight to a pose. Meanwhile the tool turns through the smaller angle. One profile leads both; the type of the
/// limits decides which: `ToolLimits` give a trapezoidal profile, `SmoothToolLimits` limit its jerk, too.
///
/// Starts from the pose demanded last, at rest. It uses no joint coordinates, so it serves every robot.
pub struct MyLine<R, L: MotionLimits = ToolLimits> {
    goal: Goal,
    limits: L,
    path: Option<(LinePath, ProfileCursor<L::Profile>)>,
    of: PhantomData<R>,
}

enum Goal {
    /// `X_WE` of the end.
    Pose(Pose),
    /// The end in the tool frame of the start.
    Displacement(Pose),
}

impl<R: Robot, L: MotionLimits> MyLine<R, L> {
    /// To the pose `X_WE` of the tool in the world.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn to(X_WE: Pose, limits: L) -> Self {
        MyLine { goal: Goal::Pose(X_WE), limits, path: None, of: PhantomData }
    }

    /// By `X_EsE`, in the tool's own axes at the start.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn by(X_EsE: Pose, limits: L) -> Self {
        MyLine { goal: Goal::Displacement(X_EsE), limits, path: None, of: PhantomData }
    }

    fn advance(&mut self, t: Tick) -> Step<R> {
        let Some((line, cursor)) = &mut self.path else { return Step::Done };
        match cursor.advance(t.dt) {
            // ANCHOR: bow
            Some(point) => {
                let bow = Pose::translation(0.08 * point.s * (1.0 - point.s), 0.0, 0.0);
                Step::Next(Demand::pose(line.pose(point.s) * bow))
            }
            // ANCHOR_END: bow
            None => Step::Done,
        }
    }
}

#[generator(ecp)]
impl<R: Robot, L: MotionLimits> MyLine<R, L> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        let start = e.demanded().pose;
        let goal = match self.goal {
            Goal::Pose(pose) => pose,
            Goal::Displacement(displacement) => start * displacement,
        };
        let line = LinePath::new(start, goal);
        let profile = line.profile(self.limits).map_err(|error| Fault::thrown(&error.to_string()))?;
        self.path = Some((line, ProfileCursor::new(profile)));
        // A goal out of reach is refused here, and not on arrival.
        Ok(self.advance(t).with_goal(Demand::pose(goal)))
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        self.advance(t)
    }
}
