//! Separate motions, an arm's half: to a pose of its own.

use core::marker::PhantomData;

use mrroc::{Demand, Pose, Robot, State, Step, Tick, generator};
use mrroc_generators::line::LinePath;

use crate::paths::share;

/// Moves the tool straight, from rest to rest, as softly as it can in its time.
pub struct Approach<R> {
    goal: Goal,
    duration: f64,
    t: f64,
    line: Option<LinePath>,
    of: PhantomData<R>,
}

enum Goal {
    /// `X_WE` of the end.
    Pose(Pose),
    /// `X_EsE` of the end, from the start.
    Displacement(Pose),
}

#[allow(non_snake_case)]
impl<R: Robot> Approach<R> {
    /// To `X_WE`, in `duration` \[s\], > 0.
    #[must_use]
    pub fn to(X_WE: Pose, duration: f64) -> Self {
        Approach { goal: Goal::Pose(X_WE), duration, t: 0.0, line: None, of: PhantomData }
    }

    /// By `X_EsE`, in the tool's own axes, in `duration` \[s\], > 0.
    #[must_use]
    pub fn by(X_EsE: Pose, duration: f64) -> Self {
        Approach { goal: Goal::Displacement(X_EsE), duration, t: 0.0, line: None, of: PhantomData }
    }
}

/// Learns where the tool is.
fn begin<R: Robot>(c: &mut Approach<R>, e: &State<R>, t: Tick) -> Step<R> {
    let start = e.demanded().pose;
    let end = match c.goal {
        Goal::Pose(pose) => pose,
        Goal::Displacement(displacement) => start * displacement,
    };
    c.line = Some(LinePath::new(start, end));
    approach(c, t)
}

/// The next pose on the line.
#[generator(ecp, first = begin)]
fn approach<R: Robot>(c: &mut Approach<R>, t: Tick) -> Step<R> {
    let Some(line) = c.line.filter(|_| c.t < c.duration) else { return Step::Done };
    c.t += t.dt;
    Step::Next(Demand::pose(line.pose(share(c.t / c.duration))))
}
