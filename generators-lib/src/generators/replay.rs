//! Moves through poses that were taught.

use mrroc::prelude::*;
use mrroc::robot::JointVector;

use mrroc_generators::line::{JointLine, LinePath, ToolLimits};
use mrroc_generators::profile::{Profile, ProfileCursor, ProfileLimits};
use mrroc_generators::teach::{Reference, Space, Taught, TaughtPose};

/// Moves from pose to pose of a [`Taught`] sequence, each from rest to rest by one trapezoidal profile: straight in
/// joint space to a pose that was taught in joints, straight in space to one that was taught as a pose of the tool.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::Replay;
/// use mrroc_generators::line::ToolLimits;
/// use mrroc_generators::profile::ProfileLimits;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_generators::teach::{Reference, Space, Taught, TaughtPose};
/// use mrroc_robots::{Irp6, Six};
///
/// // Taught: by 0.2 rad of the first joint, at the whole velocity and acceleration, and back at half of either.
/// let leg = |(share, q)| TaughtPose::new(share, share, &[q, 0.0, 0.0, 0.0, 0.0, 0.0]);
/// let legs = [(1.0, 0.2), (0.5, -0.2)].map(leg);
/// let poses = legs.into_iter().flatten().collect();
/// let taught = Taught { space: Space::Joint, reference: Reference::Relative, poses };
/// let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
/// let limits = ToolLimits { translation: limits, rotation: limits };
/// let replay = Replay::of(taught, Six::repeat(0.4), Six::repeat(0.8), limits);
/// let demands = rehearse(replay, &Irp6::nominal(), Irp6::READY, 0.002)?;
/// // D / V + V / A = 1 s there and 0.2 / 0.2 + 0.2 / 0.4 = 1.5 s back.
/// assert_eq!(demands.len(), 500 + 750);
/// assert!(demands[1249].as_joints().is_some_and(|q| (q - Irp6::READY).amax() < 1e-12));
/// # Ok::<(), Fault>(())
/// ```
pub struct Replay<R: Robot> {
    taught: Taught,
    velocity: R::Joints,
    acceleration: R::Joints,
    limits: ToolLimits,
    /// Where the next leg starts: joints [rad or m] and `X_WE`.
    from: (R::Joints, Pose),
    next: usize,
    leg: Option<Leg<R::Joints>>,
    /// Where all poses lead, the first one last: told one in each step.
    goals: Vec<Demand<R>>,
}

enum Leg<J> {
    Joints(JointLine<J>, ProfileCursor),
    Tool(LinePath, ProfileCursor),
}

impl<R: Robot> Replay<R> {
    /// `taught`, by its shares of a velocity [rad/s or m/s] and an acceleration [rad/s² or m/s²] per joint, and of the tool's.
    #[must_use]
    pub fn of(taught: Taught, velocity: R::Joints, acceleration: R::Joints, limits: ToolLimits) -> Self {
        let from = (R::Joints::zeros(), Pose::identity());
        Replay { taught, velocity, acceleration, limits, from, next: 0, leg: None, goals: Vec::new() }
    }

    /// The path to a pose from the end of the path before it.
    fn begin(&mut self, pose: &TaughtPose) -> Result<Leg<R::Joints>, Fault> {
        let relative = self.taught.reference == Reference::Relative;
        let refused = |error: &dyn core::fmt::Display| Fault::thrown(&error.to_string());
        match self.taught.space {
            Space::Motor => Err(Fault::thrown("poses that are taught in motor angles cannot be replayed")),
            Space::Joint => {
                let q = pose
                    .joints::<R::Joints>()
                    .ok_or_else(|| Fault::thrown("a pose was taught to another robot"))?;
                let line = JointLine::new(self.from.0, if relative { self.from.0 + q } else { q });
                let v = self.velocity * pose.velocity;
                let a = self.acceleration * pose.acceleration;
                self.from.0 = line.joints(1.0);
                Ok(Leg::Joints(line, line.profile(&v, &a).map_err(|error| refused(&error))?.cursor()))
            }
            space @ (Space::Zyz | Space::AngleAxis) => {
                let goal =
                    pose.pose(space).ok_or_else(|| Fault::thrown("a taught pose needs six coordinates"))?;
                let line = LinePath::new(self.from.1, if relative { self.from.1 * goal } else { goal });
                let share = |limits: ProfileLimits| ProfileLimits {
                    velocity: limits.velocity * pose.velocity,
                    acceleration: limits.acceleration * pose.acceleration,
                };
                let ToolLimits { translation, rotation } = self.limits;
                let limits = ToolLimits { translation: share(translation), rotation: share(rotation) };
                self.from.1 = line.pose(1.0);
                Ok(Leg::Tool(line, line.profile(limits).map_err(|error| refused(&error))?.cursor()))
            }
        }
    }
}

#[generator(ecp)]
impl<R: Robot> Replay<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        self.from = (e.demanded().joints, e.demanded().pose);
        self.goals = self.taught.goals(self.from);
        self.next_step(t)
    }

    fn next_step(&mut self, t: Tick) -> Result<Step<R>, Fault> {
        loop {
            let demand = match &mut self.leg {
                Some(Leg::Joints(line, cursor)) => {
                    cursor.advance(t.dt).map(|at| Demand::joints(line.joints(at.s)))
                }
                Some(Leg::Tool(line, cursor)) => cursor.advance(t.dt).map(|at| Demand::pose(line.pose(at.s))),
                None => None,
            };
            if let Some(demand) = demand {
                return Ok(Step::Next(self.goals.pop().map_or(demand, |goal| demand.with_goal(goal))));
            }
            let Some(pose) = self.taught.poses.get(self.next).copied() else { return Ok(Step::Done) };
            self.next += 1;
            self.leg = Some(self.begin(&pose)?);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc_robots::{Irp6, SimulatedIrp6, Six};
    use std::time::Duration;

    #[test]
    fn a_trj_file_is_replayed_in_the_closed_form_time() {
        let start = Irp6::READY;
        let arm = SimulatedIrp6::new(Irp6::nominal(), &start);
        let shaft = arm.shaft();
        let share = |x: f64| [x; 6].map(|x| format!("{x} ")).concat() + "\n";
        let leg = |q: &str| format!("{}{}{q} 0 0 0 0 0\n", share(0.5), share(0.25));
        let file = format!("JOINT 2 RELATIVE\n{}{}", leg("0.2"), leg("-0.1"));
        let taught = Taught::from_trj(&file).expect("in order");
        let robot = RobotSetup::new("irp6", Irp6::nominal(), arm).program(move |ecp| {
            let tool = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
            let tool = ToolLimits { translation: tool, rotation: tool };
            ecp.move_robot((), Replay::of(taught.clone(), Six::repeat(0.8), Six::repeat(3.2), tool)).map(drop)
        });
        let report = Cell::new(Duration::from_millis(2)).robot(robot).run().expect("within the limits");
        // V = 0.4, A = 0.8: 0.2 / 0.4 + 0.4 / 0.8 = 1 s, then 2 sqrt(0.1 / 0.8) = 0.707 s.
        let duration = report.time.as_secs_f64();
        assert!((1.707..1.72).contains(&duration), "{duration} s");
        assert!((shaft.state().position - start - Six::new(0.1, 0.0, 0.0, 0.0, 0.0, 0.0)).amax() < 1e-3);
    }
}
