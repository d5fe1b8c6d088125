//! The common motion, the coordinator's half: the trajectory of the body, and what it makes of both arms.

use mrroc::prelude::*;
use mrroc_generators::cooperation::{BodyPath, Displacement};

use mrroc_robots::{Polycrank, Rnt};

/// Carries the body along a path: `X_WE_i = X_WB(t) X_BE_i` of both tools, ordered as displacements from where they were.
#[allow(non_snake_case)]
pub struct Carry<P> {
    path: P,
    /// The body at the start.
    X_WB: Pose,
    /// The tools at the start.
    X_WEs: [Pose; 2],
    /// Where each holds the body.
    X_BE: [Pose; 2],
}

impl<P: BodyPath> Carry<P> {
    /// The body at `X_WB` along `path`.
    #[allow(non_snake_case)]
    pub fn along(X_WB: Pose, path: P) -> Self {
        Carry { path, X_WB, X_WEs: [Pose::identity(); 2], X_BE: [Pose::identity(); 2] }
    }
}

/// Learns where each arm holds the body: the one place that needs the arms' states.
#[allow(non_snake_case)]
fn grasp<P: BodyPath>(
    c: &mut Carry<P>,
    e: &State<(Rnt, Polycrank)>,
    t: Tick,
) -> Result<Step<(Rnt, Polycrank), Displacement>, Fault> {
    c.X_WEs = e.demanded_poses();
    c.X_BE = c.X_WEs.map(|X_WE| c.X_WB.inv_mul(&X_WE));
    c.path.begin(&c.X_WB)?;
    carry(c, t)
}

/// Where the body is next, and with it the tools that hold it.
#[generator(mp, first = grasp)]
#[allow(non_snake_case)]
fn carry<P: BodyPath>(c: &mut Carry<P>, t: Tick) -> Result<Step<(Rnt, Polycrank), Displacement>, Fault> {
    let Some(X_WB) = c.path.advance(t.dt)? else { return Ok(Step::Done) };
    let moved = |i: usize| Displacement::between(&c.X_WEs[i], &(X_WB * c.X_BE[i]));
    Ok(Step::Next((moved(0), moved(1))))
}
