//! Moves the joints through positions at times, as other programs plan them.

use core::marker::PhantomData;

use mrroc::prelude::*;
use mrroc::robot::JointVector;

use mrroc_generators::trajectory::{JointTrajectory, TrajectoryGroup};

/// Moves the joints of a robot through positions at times, as other programs plan them: along one [`JointTrajectory`], or along those
/// that a [`TrajectoryGroup`] is given while it moves.
///
/// Each trajectory is checked as a whole before the robot moves. Those that a group is given replace the one at work without a step of
/// velocity, and can be cancelled on their path.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::FollowTrajectory;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_generators::trajectory::{JointBounds, JointTrajectory, TrajectoryPoint};
/// use mrroc_robots::Irp6;
///
/// let irp6 = Irp6::nominal();
/// // By 0.2 rad of the first joint, past a point in between.
/// let point = |time, turned: f64| TrajectoryPoint {
///     time,
///     positions: [turned, 0.0, 0.0, 0.0, 0.0, 0.0].iter().zip(&Irp6::READY).map(|(by, q)| by + q).collect(),
///     ..TrajectoryPoint::default()
/// };
/// let points = vec![point(0.0, 0.0), point(1.0, 0.12), point(2.0, 0.2)];
/// let trajectory = JointTrajectory::new(JointBounds::of(irp6.limits()), points)?;
/// let demands = rehearse(FollowTrajectory::along(&trajectory), &irp6, Irp6::READY, 0.002)?;
/// assert_eq!(demands.len(), 1000);
/// let turned = |step: usize| demands[step - 1].as_joints().map(|q| q[0] - Irp6::READY[0]);
/// assert!(turned(500).is_some_and(|turned| (turned - 0.12).abs() < 1e-12));
/// assert!(turned(1000).is_some_and(|turned| (turned - 0.2).abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct FollowTrajectory<R: Robot> {
    group: TrajectoryGroup,
    /// Its place in the group.
    place: usize,
    /// Its number among the motions of the robot, 0 before its first step.
    motion: u64,
    /// What it follows alone.
    alone: Option<JointTrajectory>,
    of: PhantomData<fn() -> R>,
}

impl<R: Robot> FollowTrajectory<R> {
    /// Along one trajectory of one robot, to its end.
    #[must_use]
    pub fn along(trajectory: &JointTrajectory) -> Self {
        let alone = Some(trajectory.clone());
        FollowTrajectory { group: TrajectoryGroup::new(&[""]), place: 0, motion: 0, alone, of: PhantomData }
    }

    /// As a robot of a group.
    pub(crate) fn in_group(group: TrajectoryGroup, place: usize) -> Self {
        FollowTrajectory { group, place, motion: 0, alone: None, of: PhantomData }
    }
}

impl<R: Robot> Drop for FollowTrajectory<R> {
    fn drop(&mut self) {
        self.group.leave(self.place, self.motion);
    }
}

#[generator(ecp)]
impl<R: Robot> FollowTrajectory<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        self.motion = self.group.start(self.place, e.demanded().joints.as_slice());
        if let Some(trajectory) = &self.alone {
            self.group.begin(&[""], trajectory).map_err(|why| Fault::thrown(&why.to_string()))?;
            self.group.finish();
        }
        Ok(self.next_step(t))
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        match self.group.advance(self.place, t) {
            Some(joints) => Step::Next(Demand::joints(joints)),
            None => Step::Done,
        }
    }
}
