//! Separate motions, an arm's half: to a pose of its own.

use core::marker::PhantomData;

use mrroc::prelude::*;
use mrroc_generators::line::ToolLimits;

use crate::paths::Soft;

/// Moves the tool softly along a straight line, from rest to rest.
pub struct Approach<R> {
    goal: Goal,
    limits: ToolLimits,
    t: f64,
    motion: Option<Soft>,
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
    /// To `X_WE`, within `limits`.
    #[must_use]
    pub fn to(X_WE: Pose, limits: ToolLimits) -> Self {
        Approach { goal: Goal::Pose(X_WE), limits, t: 0.0, motion: None, of: PhantomData }
    }

    /// By `X_EsE`, in the tool's own axes, within `limits`.
    #[must_use]
    pub fn by(X_EsE: Pose, limits: ToolLimits) -> Self {
        Approach { goal: Goal::Displacement(X_EsE), limits, t: 0.0, motion: None, of: PhantomData }
    }
}

/// Learns where the tool is.
fn begin<R: Robot>(c: &mut Approach<R>, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
    let start = e.demanded().pose;
    let end = match c.goal {
        Goal::Pose(pose) => pose,
        Goal::Displacement(displacement) => start * displacement,
    };
    c.motion = Some(Soft::between(start, end, c.limits)?);
    approach(c, t)
}

/// The next pose on the line.
#[generator(ecp, first = begin)]
fn approach<R: Robot>(c: &mut Approach<R>, t: Tick) -> Result<Step<R>, Fault> {
    let Some(motion) = c.motion.filter(|motion| c.t < motion.duration()) else { return Ok(Step::Done) };
    c.t += t.dt;
    Ok(Step::Next(Demand::pose(motion.pose(c.t))))
}
