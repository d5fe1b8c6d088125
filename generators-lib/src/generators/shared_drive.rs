//! Arms close kinematic loops on one drive frame, each in its own time, and then move with it.

use core::marker::PhantomData;

use mrroc::{Fault, Motion, Pose, RobotList, RobotsEach, State, Step, Tick, generator};

use mrroc_generators::cooperation::{BodyPath, KinematicLoop, Placed, Transform};
use mrroc_generators::line::{LinePath, ToolLimits};
use mrroc_generators::profile::ProfileCursor;

/// Solves every arm's loop for its tool: `X_WE_i = X_WD(t) X_DG_i X_EG_i^-1`, as KALI does.
///
/// First the arms are asynchronous: each goes straight from where it was demanded to where its loop closes, in the time
/// that it needs itself. When the last has arrived, all are engaged: the drive frame D starts along its path, and all
/// tools with it. Functional transforms of the loops count their age from then on.
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
        let (starts, approaches) = (L::array(|_| Pose::identity()), L::array(|_| None));
        let (engaged, age, of) = (false, 0.0, PhantomData);
        SharedDrive { drive: X_WD, path, loops, limits, starts, approaches, engaged, age, of }
    }

    #[allow(non_snake_case)]
    fn advance(&mut self, t: Tick) -> Result<Step<L, O>, Fault> {
        let (X_WEs, loops) = (self.starts, self.loops.as_mut());
        if !self.engaged {
            let mut under_way = false;
            let X_WE = L::array(|i| {
                let approach = self.approaches.as_mut()[i].as_mut();
                match approach.and_then(|(line, cursor)| Some(line.pose(cursor.advance(t.dt)?.s))) {
                    Some(X_WE) => {
                        under_way = true;
                        X_WE
                    }
                    None => loops[i].tool(&self.drive, 0.0),
                }
            });
            if under_way {
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
            self.approaches.as_mut()[i] = Some((line, profile.cursor()));
        }
        self.advance(t)
    }

    fn next_step(&mut self, t: Tick) -> Result<Step<L, O>, Fault> {
        self.advance(t)
    }
}
