//! A master arm goes along a path, and its slaves keep their poses relative to it.

use core::marker::PhantomData;

use mrroc::generator::{Motion, RobotList, RobotsEach};
use mrroc::prelude::*;

use mrroc_generators::cooperation::{BodyPath, Grasps, Placed, Smoothed};

/// Moves the first arm of the list along a path of its tool, and the others according to where the first one *is*:
/// `X_WS_i = X_WM X_MS_i` with `X_WM` measured. So they also follow a master that is pushed or held back.
///
/// The slaves are behind the master: a measurement moves a slave one step later at the earliest, the drives of the
/// slave add their delay, and the smoothing of encoder counts adds `lag`. At 0.1 m/s, with steps of 2 ms and a lag of
/// 20 ms, that is 2.4 mm and more. To move arms on one rigid body, or slaves that shall follow the demands of the
/// master, use one path for all arms.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc::robot::{RobotImage, RobotState};
/// use mrroc_generators::conformance::Given;
/// use mrroc_generators::cooperation::StraightBody;
/// use mrroc_generators::generators::FollowMaster;
/// use mrroc_generators::line::ToolLimits;
/// use mrroc_generators::profile::ProfileLimits;
/// use mrroc_generators::rehearsal::{at_rest, rehearse_all};
/// use mrroc_robots::Irp6;
///
/// let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
/// let limits = ToolLimits { translation: limits, rotation: limits };
/// let path = StraightBody::by(Pose::translation(0.05, 0.0, -0.05), limits);
/// let arms = [0.0, 0.5].map(|y| {
///     let base = Pose::translation(0.0, y, 0.0);
///     at_rest(&Irp6::nominal().with_base(base), Irp6::READY)
/// });
/// // Arms that are where they are demanded to be.
/// let image = |i: usize, demand: &Demand<Irp6>| {
///     let pose = demand.as_pose().unwrap_or(arms[i].demanded().pose);
///     let state = RobotState { pose, ..*arms[i].demanded() };
///     RobotImage::new(state, state)
/// };
/// let follow = FollowMaster::<[Irp6; 2], _>::along(path, 0.02);
/// let demands = rehearse_all(follow, 0.002, |last| {
///     let e = State::new(last.map_or(arms, |told| [image(0, &told[0]), image(1, &told[1])]));
///     Ok(Given { order: Order::new(()), e, v: Reading::new(()) })
/// })?;
/// // In the end, the slave is as far from its master as at the start.
/// let ends = demands[demands.len() - 1].map(|told| told.as_pose().map(|pose| pose.translation.vector));
/// assert!(ends[0].zip(ends[1]).is_some_and(|(master, slave)| ((slave - master).y - 0.5).abs() < 1e-5));
/// # Ok::<(), Fault>(())
/// ```
pub struct FollowMaster<L: RobotList, P, O = Motion> {
    path: P,
    lag: f64,
    goal: Pose,
    settling: f64,
    starts: L::Each<Pose>,
    slaves: Grasps<L::Each<Pose>>,
    master: Smoothed,
    of: PhantomData<O>,
}

impl<L: RobotsEach<Placed, O>, P: BodyPath, O: 'static> FollowMaster<L, P, O> {
    /// The master's tool along `path`, the slaves with a time constant `lag` \[s\], >= 0. Relative poses are those of the
    /// start; the motion ends ten times the lag after the path.
    #[must_use]
    pub fn along(path: P, lag: f64) -> Self {
        let goal = Pose::identity();
        let starts = L::array(|_| Pose::identity());
        let slaves = Grasps::close(&goal, starts);
        let master = Smoothed::new(goal, lag);
        FollowMaster { path, lag, goal, settling: 0.0, starts, slaves, master, of: PhantomData }
    }

    #[allow(non_snake_case)]
    fn advance(&mut self, measured: &Pose, t: Tick) -> Result<Step<L, O>, Fault> {
        match self.path.advance(t.dt)? {
            Some(X_WM) => self.goal = X_WM,
            None if self.settling >= 10.0 * self.lag => return Ok(Step::Done),
            None => self.settling += t.dt,
        }
        let X_WM = self.master.follow(measured, t.dt);
        Ok(Step::Next(L::each(|i| Placed {
            X_WEs: self.starts.as_ref()[i],
            X_WE: if i == 0 { self.goal } else { self.slaves.tool(i, &X_WM) },
        })))
    }
}

#[generator(mp)]
impl<L: RobotsEach<Placed, O>, P: BodyPath, O: 'static> FollowMaster<L, P, O> {
    fn first_step(&mut self, e: &State<L>, t: Tick) -> Result<Step<L, O>, Fault> {
        if !(self.lag.is_finite() && self.lag >= 0.0) {
            return Err(Fault::thrown("the lag of a slave must be finite and >= 0"));
        }
        self.starts = e.demanded_poses();
        self.goal = self.starts.as_ref()[0];
        let measured = e.measured_poses().as_ref()[0];
        // From the master as measured to the slaves as demanded: no jump at the start.
        self.slaves = Grasps::close(&measured, self.starts);
        self.master = Smoothed::new(measured, self.lag);
        self.path.begin(&self.goal)?;
        self.advance(&measured, t)
    }

    fn next_step(&mut self, e: &State<L>, t: Tick) -> Result<Step<L, O>, Fault> {
        self.advance(&e.measured_poses().as_ref()[0], t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc_generators::cooperation::TimedBody;
    use mrroc_robots::{Irp6, Six};

    fn image(measured: Pose, demanded: Pose) -> RobotImage<Irp6> {
        let state = |pose| RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose };
        RobotImage::new(state(measured), state(demanded))
    }

    #[test]
    fn slaves_go_where_the_master_is_pushed() {
        let one = Pose::translation(0.5, 0.0, 0.25);
        let two = Pose::translation(0.875, 0.125, 0.25);
        let at = |push: f64| {
            let measured = Pose::translation(0.0, push, 0.0) * one;
            State::<[Irp6; 2]>::new([image(measured, one), image(two, two)])
        };
        let rest = TimedBody::new(1.0, |_| Pose::identity());
        let mut generator = FollowMaster::<[Irp6; 2], _>::along(rest, 0.0);
        let t = Tick { step: 0, dt: 2e-3, duration: 2e-3 };
        let Ok(Step::Next([master, slave])) = generator.first_step(&at(0.0), t) else { panic!("ended") };
        assert_eq!(
            (master, slave),
            (mrroc::generator::Demand::pose(one), mrroc::generator::Demand::pose(two))
        );
        let Ok(Step::Next([master, slave])) = generator.next_step(&at(0.0625), t) else { panic!("ended") };
        let pushed = Pose::translation(0.875, 0.1875, 0.25);
        assert_eq!(
            (master, slave),
            (mrroc::generator::Demand::pose(one), mrroc::generator::Demand::pose(pushed))
        );
    }
}
