//! Moves the tool on straight lines past via poses within a deviation and without a stop.

use core::marker::PhantomData;

use mrroc::prelude::*;

use mrroc_generators::line::SmoothToolLimits;
use mrroc_generators::via::{PoseDeviation, ViaError, ViaPoses};
use mrroc_generators::waypoints::PointsError;

/// Moves the tool from where it is on straight lines from pose to pose, to rest at the last one: with limited jerk or,
/// if the limit is infinite, with parabolic blends.
///
/// The tool passes a pose at a distance and an angle of at most the deviation; the smaller the deviation, the slower
/// the corner. It uses no joint coordinates, so it serves every robot.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::LineVia;
/// use mrroc_generators::line::SmoothToolLimits;
/// use mrroc_generators::profile::JerkLimits;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_generators::via::PoseDeviation;
/// use mrroc_robots::Irp6;
///
/// let irp6 = Irp6::nominal();
/// let limits = JerkLimits { velocity: 0.1, acceleration: 0.5, jerk: 5.0 };
/// let limits = SmoothToolLimits { translation: limits, rotation: limits };
/// let at = |x, y| irp6.forward(&Irp6::READY) * Pose::translation(x, y, 0.0);
/// // Round a corner, which may be cut by 5 mm.
/// let within = PoseDeviation { distance: 0.005, angle: 0.05 };
/// let motion = LineVia::through(vec![at(0.08, 0.0), at(0.08, 0.08)], within, limits);
/// let demands = rehearse(motion, &irp6, Irp6::READY, 0.002)?;
/// let off = |pose: Pose| (pose.translation.vector - at(0.08, 0.0).translation.vector).norm();
/// let nearest = demands.iter().filter_map(Demand::as_pose).map(off).fold(1.0, f64::min);
/// // The nearest pose demanded may be half a step at 0.1 m/s before or behind the nearest of the path.
/// assert!(nearest > 1e-4 && nearest <= 0.005 + 1e-4, "{nearest}");
/// // Sooner than with a stop at the corner: twice D / V + V / A + A / J.
/// assert!(demands.len() < 2 * 550);
/// # Ok::<(), Fault>(())
/// ```
pub struct LineVia<R> {
    poses: Vec<Pose>,
    deviation: PoseDeviation,
    limits: SmoothToolLimits,
    motion: Option<(ViaPoses, f64)>,
    /// Where it leads, the end last: told one in each step.
    goals: Vec<Pose>,
    of: PhantomData<R>,
}

impl<R: Robot> LineVia<R> {
    /// Through `poses` `X_WE` of the tool in the world, each passed within `deviation`, and within `limits`.
    #[must_use]
    pub fn through(poses: Vec<Pose>, deviation: PoseDeviation, limits: SmoothToolLimits) -> Self {
        LineVia { poses, deviation, limits, motion: None, goals: Vec::new(), of: PhantomData }
    }

    fn advance(&mut self, t: Tick) -> Step<R> {
        let Some((motion, time)) = &mut self.motion else { return Step::Done };
        if *time >= motion.duration() {
            return Step::Done;
        }
        *time += t.dt;
        // The sum of n increments may miss n * dt by rounding; that must not cost a step.
        if motion.duration() - *time <= 1e-9 * t.dt {
            *time = motion.duration();
        }
        let demand = Demand::pose(motion.at(*time));
        Step::Next(match self.goals.pop() {
            Some(goal) => demand.with_goal(Demand::pose(goal)),
            None => demand,
        })
    }
}

#[generator(ecp)]
impl<R: Robot> LineVia<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        self.goals.clone_from(&self.poses);
        self.poses.insert(0, e.demanded().pose);
        let motion = match ViaPoses::new(&self.poses, self.limits, self.deviation) {
            // It is there.
            Err(ViaError::Points(PointsError::Coincident)) => return Ok(Step::Done),
            motion => motion.map_err(|error| Fault::thrown(&error.to_string()))?,
        };
        self.motion = Some((motion, 0.0));
        Ok(self.advance(t))
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        self.advance(t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc_generators::profile::JerkLimits;
    use mrroc_robots::{Irp6, SimulatedIrp6};
    use nalgebra::Vector3;
    use std::time::Duration;

    #[test]
    fn a_square_with_rounded_corners_is_executed_and_ends_where_it_began() {
        let irp6 = Irp6::nominal();
        let start = Irp6::READY;
        let arm = SimulatedIrp6::new(irp6.clone(), &start);
        let shaft = arm.shaft();
        let here = irp6.forward(&start);
        let by = |x: f64, y: f64| Pose::translation(x, y, 0.0) * here * Pose::rotation(Vector3::z() * y);
        let square = vec![by(0.1, 0.0), by(0.1, 0.1), by(0.0, 0.1), here];
        let limits = JerkLimits { velocity: 0.2, acceleration: 1.0, jerk: 10.0 };
        let limits = SmoothToolLimits { translation: limits, rotation: limits };
        let robot = RobotSetup::new("irp6", irp6.clone(), arm).program(move |ecp| {
            let deviation = PoseDeviation { distance: 0.005, angle: 0.1 };
            ecp.move_robot((), LineVia::through(square.clone(), deviation, limits)).map(drop)
        });
        let report = Cell::new(Duration::from_millis(2)).robot(robot).run().expect("within the limits");
        // Longer than 0.4 m at 0.2 m/s, shorter than four legs from rest to rest: D / V + V / A + A / J each.
        let duration = report.time.as_secs_f64();
        assert!((2.0..3.1).contains(&duration), "{duration} s");
        let off = irp6.forward(&shaft.state().position).translation.vector - here.translation.vector;
        assert!(off.norm() < 1e-3, "{off}");
    }
}
