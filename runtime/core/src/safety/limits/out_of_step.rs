//! Demands that come in another step than their own: a network has delayed them, or has become faster.
//!
//! In: a demand, and by how many steps it is late or early. Out: what it says of the path; and, step by step, where a robot is
//! that goes on along that path. Late by a constant time, every demand tells where the path was: the robot goes on to where the
//! path is, by its velocity, and comes back to it as after demands that were missing.

use crate::model::demand::{Coordinates, Demand};
use crate::model::fault::Fault;
use crate::model::robot::Robot;

use super::catching_up::{CatchingUp, Late};
use super::path::{OffPath, Path};
use super::{AcceptedDemand, Acceptor};

impl<R: Robot> Acceptor<R> {
    /// Whether a robot goes on by demands of other steps: one that comes back to its path by its joints. Robots with a jerk limit
    /// do not come back, and those that move together go by one another.
    pub fn goes_on_out_of_step(&self) -> bool {
        let by_joints =
            !matches!(self.track.off_path, Some(OffPath::Together(_))) && !self.track.path.on_twist;
        by_joints && self.checks.robot.limits().jerk.is_none()
    }

    /// A demand came that was for the step which ended `behind` steps before the present state; below 0 for one that is
    /// still to come. `dt` \[s\] is its path time in a step of `duration` \[s\]. Returns whether it is newer than what is known.
    ///
    /// # Errors
    /// What is wrong with the demand itself, or the first limit that the path breaks; nothing is changed then.
    pub fn hear(&mut self, demand: &Demand<R>, dt: f64, duration: f64, behind: f64) -> Result<bool, Fault> {
        let tool = self.tool_of(demand)?;
        let position = match &demand.coordinates {
            Coordinates::Hold if demand.redundancy.is_none() => {
                self.track.path.late.unwrap_or(self.track.path.position)
            }
            _ => self.position_of(demand, &tool)?,
        };
        if let Some(goal) = demand.goal() {
            self.check_goal(&goal, demand, &tool)?;
        }
        let before = &self.track.path;
        let since = before.missing - behind * duration;
        if since < 0.5 * duration {
            return Ok(false);
        }
        let velocity = (position - before.position) * since.recip();
        // Both velocities are those of the middles of their times.
        let acceleration = (velocity - before.velocity) * (0.5 * (since + before.span)).recip();
        let late =
            |fault: Fault| if fault.message().is_empty() { fault.text("after late demands") } else { fault };
        self.check(&position, &velocity, &velocity, &acceleration, duration).map_err(late)?;
        let limits = self.checks.robot.limits();
        let at_end = CatchingUp::velocity_at_end(&velocity, &acceleration, since - duration, limits);
        let gap = before.missing.max(since) + duration;
        let gap = match &self.track.off_path {
            Some(OffPath::Joints(known)) => known.gap.max(gap),
            Some(OffPath::Together(_)) | None => gap,
        };
        self.track.path = Path {
            missing: behind * duration,
            late: Some(position),
            ..Path::after(position, velocity, since)
        };
        self.track.off_path = Some(OffPath::Joints(CatchingUp { velocity: at_end, acceleration, gap }));
        self.motion.tool = tool;
        self.motion.starting = false;
        self.pace.accept(dt, duration, since - duration);
        self.pace.learn_path_speed(&at_end);
        Ok(true)
    }

    /// No demand is there for a step of `duration` \[s\], of a robot that is beside its path: it comes nearer to where the path is
    /// by now, if that goes on at its velocity. `None` where that breaks a limit, or is too far away; nothing is changed then.
    pub fn go_on_along_path(&mut self, duration: f64) -> Option<AcceptedDemand<R>> {
        let Some(OffPath::Joints(known)) = self.track.off_path else { return None };
        let limits = self.checks.robot.limits();
        if limits.jerk.is_some() {
            return None;
        }
        let path = &self.track.path;
        let demand = path.position + known.velocity * (path.missing + duration);
        let before = demand - known.velocity * duration;
        let late = Late {
            position: &self.state.position,
            velocity: &self.state.velocity,
            demand: &demand,
            before: &before,
            path_velocity: &known.velocity,
            path_acceleration: &known.acceleration,
            time: duration,
            duration,
        };
        let (position, _) = CatchingUp::next(Some(&known), &late, limits)?;
        let velocity = self.velocity_to(&position, None, duration).ok()?;
        self.check_tool(&self.motion.tool, &position, duration).ok()?;
        self.state.go_to(position, velocity, duration);
        self.track.path.missing += duration;
        self.pace.period = duration;
        Some(AcceptedDemand::new(position))
    }
}
