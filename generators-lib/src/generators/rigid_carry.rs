//! Several arms carry a rigid body along a path.

use core::marker::PhantomData;

use mrroc::generator::{Motion, RobotList, RobotsEach};
use mrroc::prelude::*;

use mrroc_generators::cooperation::{BodyFrame, BodyPath, Displacement, Grasps, Placed};

/// Moves all tools of the list `L` so that none moves against another: `X_WE_i = X_WB(t) X_BE_i`.
///
/// The first step learns where each arm holds the body, from the poses demanded last, at rest. After that all demands
/// follow from the path alone, so that a Suspend leaves all arms on it. It demands poses of transparent ECPs;
/// [`by_displacements`](RigidCarry::by_displacements) it orders displacements, which
/// [`TransmitDisplacement`](mrroc_generators::generators::TransmitDisplacement) or a program's own generator passes on.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::conformance::Given;
/// use mrroc_generators::cooperation::{BodyFrame, StraightBody};
/// use mrroc_generators::generators::RigidCarry;
/// use mrroc_generators::line::ToolLimits;
/// use mrroc_generators::profile::ProfileLimits;
/// use mrroc_generators::rehearsal::{at_rest, rehearse_all};
/// use mrroc_robots::Irp6;
/// use nalgebra::Vector3;
///
/// let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
/// let limits = ToolLimits { translation: limits, rotation: limits };
/// let path = StraightBody::by(Pose::new(Vector3::z() * 0.1, Vector3::z() * 0.1), limits);
/// let arms = [0.0, 0.5].map(|y| {
///     let base = Pose::translation(0.0, y, 0.0);
///     at_rest(&Irp6::nominal().with_base(base), Irp6::READY)
/// });
/// // In a Move the handles say which arms they are: `RigidCarry::along(..)`.
/// let carry = RigidCarry::<[Irp6; 2], _>::along(BodyFrame::Centroid, path);
/// let demands = rehearse_all(carry, 0.002, |_| {
///     Ok(Given { order: Order::new(()), e: State::new(arms), v: Reading::new(()) })
/// })?;
/// // The tools keep their distance during the motion, and the body takes D / V + V / A = 1.2 s.
/// let poses = demands.iter().map(|told| told.map(|demand| demand.as_pose().unwrap_or_default()));
/// let far = |[a, b]: [Pose; 2]| (b.translation.vector - a.translation.vector).norm();
/// assert!(poses.into_iter().all(|both| (far(both) - 0.5).abs() < 1e-12));
/// assert_eq!(demands.len(), 600);
/// # Ok::<(), Fault>(())
/// ```
pub struct RigidCarry<L: RobotList, P, O = Motion> {
    body: BodyFrame,
    path: P,
    starts: L::Each<Pose>,
    grasps: Grasps<L::Each<Pose>>,
    of: PhantomData<O>,
}

impl<L: RobotsEach<Placed>, P: BodyPath> RigidCarry<L, P> {
    /// The body whose frame is `body` at the start along `path`. The Move says which arms carry it.
    #[must_use]
    pub fn along(body: BodyFrame, path: P) -> Self {
        let starts = L::array(|_| Pose::identity());
        RigidCarry { body, path, starts, grasps: Grasps::close(&Pose::identity(), starts), of: PhantomData }
    }

    /// The same, by orders of displacements, which the ECPs' own generators transmit.
    #[must_use]
    pub fn by_displacements(self) -> RigidCarry<L, P, Displacement> {
        let RigidCarry { body, path, starts, grasps, .. } = self;
        RigidCarry { body, path, starts, grasps, of: PhantomData }
    }
}

impl<L: RobotsEach<Placed, O>, P: BodyPath, O: 'static> RigidCarry<L, P, O> {
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

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc_generators::cooperation::StraightBody;
    use mrroc_generators::line::ToolLimits;
    use mrroc_generators::profile::ProfileLimits;
    use mrroc_robots::{Irp6, SimulatedIrp6};
    use nalgebra::Vector3;
    use std::time::Duration;

    #[test]
    fn two_arms_lift_a_body_in_the_closed_form_time() {
        let start = Irp6::READY;
        let left = Irp6::nominal();
        let right = Irp6::nominal().with_base(Pose::translation(1.8, 0.3, 0.0));
        let arms = [SimulatedIrp6::new(left.clone(), &start), SimulatedIrp6::new(right.clone(), &start)];
        let shafts = arms.each_ref().map(|arm| arm.shaft());
        let [one, two] = arms;
        let cell = Cell::new(Duration::from_millis(2))
            .robot(RobotSetup::new("left", left.clone(), one))
            .robot(RobotSetup::new("right", right.clone(), two));
        let cell = cell.program(|mp| {
            let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
            let limits = ToolLimits { translation: limits, rotation: limits };
            let path = StraightBody::by(Pose::translation(0.0, 0.0, 0.05), limits);
            let mut one = mp.robot::<Irp6>("left")?;
            let mut two = mp.robot::<Irp6>("right")?;
            let lift = RigidCarry::along(BodyFrame::Centroid, path);
            mp.move_robots((&mut one, &mut two), (), lift).map(drop)
        });
        let report = cell.run().expect("within the limits");
        // T = D / V + V / A = 0.05 / 0.1 + 0.1 / 0.5.
        let duration = report.time.as_secs_f64();
        assert!((0.70..0.72).contains(&duration), "{duration} s");
        for (robot, shaft) in [left, right].iter().zip(&shafts) {
            let up = mrroc::robot::Robot::forward(robot, &shaft.state().position).translation.vector
                - mrroc::robot::Robot::forward(robot, &start).translation.vector;
            assert!((up - Vector3::z() * 0.05).norm() < 1e-3, "{up}");
        }
    }
}
