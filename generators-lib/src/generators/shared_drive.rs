//! Arms close kinematic loops on one drive frame, each in its own time, and then move with it.

use core::marker::PhantomData;

use mrroc::generator::{Motion, RobotList, RobotsEach};
use mrroc::prelude::*;

use mrroc_generators::cooperation::{BodyPath, KinematicLoop, Placed, Transform};
use mrroc_generators::line::{LinePath, ToolLimits};
use mrroc_generators::profile::ProfileCursor;

/// Solves every arm's loop for its tool: `X_WE_i = X_WD(t) X_DG_i X_EG_i^-1`, as KALI does.
///
/// First the arms are asynchronous: each goes straight from where it was demanded to where its loop closes, in the time
/// that it needs itself. When the last has arrived, all are engaged: the drive frame D starts along its path, and all
/// tools with it. Functional transforms of the loops count their age from then on.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::conformance::Given;
/// use mrroc_generators::cooperation::{KinematicLoop, StraightBody};
/// use mrroc_generators::generators::SharedDrive;
/// use mrroc_generators::line::ToolLimits;
/// use mrroc_generators::profile::ProfileLimits;
/// use mrroc_generators::rehearsal::{at_rest, rehearse_all};
/// use mrroc_robots::Irp6;
///
/// let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
/// let limits = ToolLimits { translation: limits, rotation: limits };
/// let arms = [0.0, 0.5].map(|y| {
///     let base = Pose::translation(0.0, y, 0.0);
///     at_rest(&Irp6::nominal().with_base(base), Irp6::READY)
/// });
/// // Each arm goes to its place 2 cm above where it is, by itself; then both move with the drive by 10 cm.
/// let loops = arms.map(|arm| {
///     KinematicLoop::held(&Pose::identity(), &(Pose::translation(0.0, 0.0, 0.02) * arm.demanded().pose))
/// });
/// let path = StraightBody::by(Pose::translation(0.1, 0.0, 0.0), limits);
/// let drive = SharedDrive::<[Irp6; 2], _>::from(Pose::identity(), path, loops, limits);
/// let demands = rehearse_all(drive, 0.002, |_| {
///     Ok(Given { order: Order::new(()), e: State::new(arms), v: Reading::new(()) })
/// })?;
/// // 0.02 / 0.1 + 0.2 s, then 0.1 / 0.1 + 0.2 s.
/// assert_eq!(demands.len(), 200 + 600);
/// # Ok::<(), Fault>(())
/// ```
pub struct SharedDrive<L: RobotList, P, D: Copy = Pose, E: Copy = Pose, O = Motion> {
    drive: Pose,
    path: P,
    loops: L::Each<KinematicLoop<D, E>>,
    limits: ToolLimits,
    starts: L::Each<Pose>,
    approaches: L::Each<Option<(LinePath, ProfileCursor)>>,
    engaged: bool,
    age: f64,
    of: PhantomData<O>,
}

impl<L, P, D, E, O> SharedDrive<L, P, D, E, O>
where
    L: RobotsEach<Placed, O>,
    P: BodyPath,
    D: Transform + Copy,
    E: Transform + Copy,
    O: 'static,
{
    /// Loops on a drive frame that is at `X_WD` and will go along `path`; the arms approach within `limits`.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn from(X_WD: Pose, path: P, loops: L::Each<KinematicLoop<D, E>>, limits: ToolLimits) -> Self {
        let starts = L::array(|_| Pose::identity());
        let approaches = L::array(|_| None);
        let of = PhantomData;
        SharedDrive { drive: X_WD, path, loops, limits, starts, approaches, engaged: false, age: 0.0, of }
    }

    #[allow(non_snake_case)]
    fn advance(&mut self, t: Tick) -> Result<Step<L, O>, Fault> {
        let X_WEs = self.starts;
        let loops = self.loops.as_mut();
        if !self.engaged {
            let mut moving = false;
            let X_WE = L::array(|i| {
                let approach = self.approaches.as_mut()[i].as_mut();
                let X_WE = approach.and_then(|(line, cursor)| Some(line.pose(cursor.advance(t.dt)?.s)));
                moving |= X_WE.is_some();
                X_WE.unwrap_or_else(|| loops[i].tool(&self.drive, 0.0))
            });
            if moving {
                let placed = |i| Placed { X_WEs: X_WEs.as_ref()[i], X_WE: X_WE.as_ref()[i] };
                return Ok(Step::Next(L::each(placed)));
            }
            self.engaged = true;
        }
        let Some(X_WD) = self.path.advance(t.dt)? else { return Ok(Step::Done) };
        self.age += t.dt;
        let age = self.age;
        Ok(Step::Next(L::each(|i| Placed { X_WEs: X_WEs.as_ref()[i], X_WE: loops[i].tool(&X_WD, age) })))
    }
}

#[generator(mp)]
impl<L, P, D, E, O> SharedDrive<L, P, D, E, O>
where
    L: RobotsEach<Placed, O>,
    P: BodyPath,
    D: Transform + Copy,
    E: Transform + Copy,
    O: 'static,
{
    fn first_step(&mut self, e: &State<L>, t: Tick) -> Result<Step<L, O>, Fault> {
        self.starts = e.demanded_poses();
        self.path.begin(&self.drive)?;
        for i in 0..L::LEN {
            let goal = self.loops.as_mut()[i].tool(&self.drive, 0.0);
            let line = LinePath::new(self.starts.as_ref()[i], goal);
            let profile = line.profile(self.limits).map_err(|error| Fault::thrown(&error.to_string()))?;
            self.approaches.as_mut()[i] = Some((line, ProfileCursor::new(profile)));
        }
        self.advance(t)
    }

    fn next_step(&mut self, t: Tick) -> Result<Step<L, O>, Fault> {
        self.advance(t)
    }
}

#[cfg(test)]
#[allow(non_snake_case)]
mod tests {
    use super::*;
    use mrroc::generator::Demand;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc_generators::cooperation::TimedBody;
    use mrroc_generators::profile::ProfileLimits;
    use mrroc_robots::{Irp6, Six};

    fn image(pose: Pose) -> RobotImage<Irp6> {
        let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose };
        RobotImage::new(state, state)
    }

    #[test]
    fn the_drive_frame_starts_when_the_last_arm_has_engaged() {
        let one = Pose::translation(0.5, 0.0, 0.3);
        let two = Pose::translation(0.9, 0.1, 0.3);
        let X_WD = Pose::identity();
        let up = Pose::translation(0.0, 0.0, 0.01);
        let loops = [KinematicLoop::held(&X_WD, &one), KinematicLoop::held(&X_WD, &(up * two))];
        let limits = ProfileLimits { velocity: 0.1, acceleration: 1.0 };
        let limits = ToolLimits { translation: limits, rotation: limits };
        let path = TimedBody::new(0.01, |t| Pose::translation(t, 0.0, 0.0));
        let mut generator = SharedDrive::<[Irp6; 2], _>::from(X_WD, path, loops, limits);
        let t = Tick { step: 0, dt: 2e-3, duration: 2e-3 };
        let mut step = generator.first_step(&State::new([image(one), image(two)]), t);
        let mut demands = Vec::new();
        while let Ok(Step::Next(both)) = step {
            demands.push(both);
            step = generator.next_step(t);
        }
        // 10 mm by the triangle of 2 sqrt(D / A) = 0.2 s, then 10 ms.
        assert_eq!(demands.len(), 100 + 5);
        assert!(demands[..100].iter().all(|both| both[0] == Demand::pose(one)));
        assert_eq!(demands[99][1], Demand::pose(up * two));
        let along = |pose: Pose| Demand::pose(Pose::translation(0.01, 0.0, 0.0) * pose);
        assert_eq!(demands[104], [along(one), along(up * two)]);
    }
}
