//! Several arms carry a rigid body along a path.

use core::marker::PhantomData;

use mrroc::{Fault, Motion, Pose, RobotList, RobotsEach, State, Step, Tick, generator};

use mrroc_generators::cooperation::{BodyFrame, BodyPath, Grasps, Placed};

/// Moves all tools of the list `L` so that none moves against another: `X_WE_i = X_WB(t) X_BE_i`.
///
/// The first step learns where each arm holds the body from the poses demanded last, at rest; only the path is
/// followed from then on, so that a Suspend finds all arms on it. In the language [`Motion`] it demands poses of
/// transparent ECPs; in the language [`Displacement`](mrroc_generators::cooperation::Displacement) it orders
/// displacements, which [`TransmitDisplacement`](mrroc_generators::generators::TransmitDisplacement) or a program's own generator passes on.
pub struct RigidCarry<L: RobotList, P, O = Motion> {
    body: BodyFrame,
    path: P,
    starts: L::Each<Pose>,
    grasps: Grasps<L::Each<Pose>>,
    of: PhantomData<O>,
}

impl<L: RobotsEach<Placed, O>, P: BodyPath, O: 'static> RigidCarry<L, P, O> {
    /// The body whose frame is `body` at the start along `path`.
    #[must_use]
    pub fn along(body: BodyFrame, path: P) -> Self {
        let starts = L::array(|_| Pose::identity());
        RigidCarry { body, path, starts, grasps: Grasps::close(&Pose::identity(), starts), of: PhantomData }
    }

    #[allow(non_snake_case)]
    fn advance(&mut self, t: Tick) -> Result<Step<L, O>, Fault> {
        let Some(X_WB) = self.path.advance(t.dt)? else { return Ok(Step::Done) };
        Ok(Step::Next(L::each(|i| Placed {
            X_WEs: self.starts.as_ref()[i],
            X_WE: self.grasps.tool(i, &X_WB),
        })))
    }
}

#[generator(mp)]
impl<L: RobotsEach<Placed, O>, P: BodyPath, O: 'static> RigidCarry<L, P, O> {
    #[allow(non_snake_case)]
    fn first_step(&mut self, e: &State<L>, t: Tick) -> Result<Step<L, O>, Fault> {
        self.starts = e.demanded_poses();
        let X_WB = self.body.pose(self.starts.as_ref());
        self.grasps = Grasps::close(&X_WB, self.starts);
        self.path.begin(&X_WB)?;
        self.advance(t)
    }

    fn next_step(&mut self, t: Tick) -> Result<Step<L, O>, Fault> {
        self.advance(t)
    }
}
