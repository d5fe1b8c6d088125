//! A straight motion until something is touched.

use core::marker::PhantomData;

use mrroc::prelude::*;
use mrroc_generators::line::{LinePath, ToolLimits};
use mrroc_generators::profile::ProfileCursor;
use mrroc_robots::Irp6;

use crate::feeling::Feeling;

/// Goes straight to a pose, or until the sensor `S` touches.
pub struct Leg<S> {
    goal: Pose,
    limits: ToolLimits,
    path: Option<(LinePath, ProfileCursor)>,
    touched: bool,
    of: PhantomData<S>,
}

impl<S: Feeling<Irp6>> Leg<S> {
    /// To the pose `X_WE`.
    #[must_use]
    pub const fn to(goal: Pose, limits: ToolLimits) -> Self {
        Self { goal, limits, path: None, touched: false, of: PhantomData }
    }

    /// Whether it ended by a touch.
    #[must_use]
    pub const fn has_touched(&self) -> bool {
        self.touched
    }
}

#[generator(ecp)]
impl<S: Feeling<Irp6>> Leg<S> {
    fn first_step(&mut self, e: &State<Irp6>, v: &Reading<(S,)>, t: Tick) -> Result<Step<Irp6>, Fault> {
        let line = LinePath::new(e.demanded().pose, self.goal);
        let profile = line.profile(self.limits).map_err(|error| Fault::thrown(&error.to_string()))?;
        self.path = Some((line, ProfileCursor::new(profile)));
        self.touched = false;
        Ok(self.next_step(v, t))
    }

    fn next_step(&mut self, v: &Reading<(S,)>, t: Tick) -> Step<Irp6> {
        self.touched = v.0.reading().is_some_and(|felt| S::touch(&felt).touching);
        match &mut self.path {
            Some((line, cursor)) if !self.touched => match cursor.advance(t.dt) {
                Some(point) => Step::Next(Demand::pose(line.pose(point.s))),
                None => Step::Done,
            },
            Some(_) | None => Step::Done,
        }
    }
}
