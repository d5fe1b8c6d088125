//! Moves the tool on a straight line to a pose, from rest to rest.

use core::marker::PhantomData;

use mrroc::prelude::*;

use mrroc_generators::line::{LinePath, MotionLimits, ToolLimits};
use mrroc_generators::profile::ProfileCursor;

/// Moves the tool straight to a pose. Meanwhile the tool turns through the smaller angle. One profile leads both; the type of the
/// limits decides which: `ToolLimits` give a trapezoidal profile, `SmoothToolLimits` limit its jerk, too.
///
/// Starts from the pose demanded last, at rest. It uses no joint coordinates, so it serves every robot.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::StraightLine;
/// use mrroc_generators::line::ToolLimits;
/// use mrroc_generators::profile::ProfileLimits;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::Irp6;
///
/// let irp6 = Irp6::nominal();
/// let limits = ProfileLimits { velocity: 0.1, acceleration: 0.1 };
/// let limits = ToolLimits { translation: limits, rotation: limits };
/// let along_z = StraightLine::by(Pose::translation(0.0, 0.0, 0.1), limits);
/// let demands = rehearse(along_z, &irp6, Irp6::READY, 0.002)?;
/// // D / V + V / A = 2 s.
/// assert_eq!(demands.len(), 1000);
/// let end = demands[999].as_pose().map(|end| irp6.forward(&Irp6::READY).inv_mul(&end).translation.vector);
/// assert!(end.is_some_and(|end| (end - nalgebra::Vector3::z() * 0.1).norm() < 1e-12));
/// # Ok::<(), Fault>(())
/// ```
pub struct StraightLine<R, L: MotionLimits = ToolLimits> {
    goal: Goal,
    limits: L,
    path: Option<(LinePath, ProfileCursor<L::Profile>)>,
    of: PhantomData<R>,
}

enum Goal {
    /// `X_WE` of the end.
    Pose(Pose),
    /// The end in the tool frame of the start.
    Displacement(Pose),
}

impl<R: Robot, L: MotionLimits> StraightLine<R, L> {
    /// To the pose `X_WE` of the tool in the world.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn to(X_WE: Pose, limits: L) -> Self {
        StraightLine { goal: Goal::Pose(X_WE), limits, path: None, of: PhantomData }
    }

    /// By `X_EsE`, in the tool's own axes at the start.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn by(X_EsE: Pose, limits: L) -> Self {
        StraightLine { goal: Goal::Displacement(X_EsE), limits, path: None, of: PhantomData }
    }

    fn advance(&mut self, t: Tick) -> Step<R> {
        let Some((line, cursor)) = &mut self.path else { return Step::Done };
        match cursor.advance(t.dt) {
            Some(point) => Step::Next(Demand::pose(line.pose(point.s))),
            None => Step::Done,
        }
    }
}

#[generator(ecp)]
impl<R: Robot, L: MotionLimits> StraightLine<R, L> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        let start = e.demanded().pose;
        let goal = match self.goal {
            Goal::Pose(pose) => pose,
            Goal::Displacement(displacement) => start * displacement,
        };
        let line = LinePath::new(start, goal);
        let profile = line.profile(self.limits).map_err(|error| Fault::thrown(&error.to_string()))?;
        self.path = Some((line, ProfileCursor::new(profile)));
        // A goal out of reach is refused here, and not on arrival.
        Ok(self.advance(t).with_goal(Demand::pose(goal)))
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        self.advance(t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::observe::ServoRecord;

    use mrroc_generators::line::SmoothToolLimits;
    use mrroc_generators::profile::{JerkLimits, ProfileLimits};
    use mrroc_robots::{Irp6, SimulatedIrp6};
    use std::{cell::RefCell, rc::Rc, time::Duration};

    /// Moves the tool of an arm straight down by 50 mm, sees that it went there straight, and returns how long it took \[s\].
    fn straight_down(limits: impl MotionLimits) -> f64 {
        let irp6 = Irp6::nominal();
        let start = Irp6::READY;
        let trace = Rc::new(RefCell::new(Vec::new()));
        let recorder = Rc::clone(&trace);
        let robot = RobotSetup::new("irp6", irp6.clone(), SimulatedIrp6::new(irp6.clone(), &start))
            .observe(move |record: &ServoRecord<Irp6>| recorder.borrow_mut().push(record.demanded))
            .program(move |ecp| {
                ecp.move_robot((), StraightLine::by(Pose::translation(0.0, 0.0, 0.05), limits)).map(drop)
            });
        let report = Cell::new(Duration::from_millis(2)).robot(robot).run().expect("within the limits");
        // Seen from the tool of the start, it goes along z: to 10 um, as the encoders count the start.
        for q in trace.borrow().iter() {
            let deviation = irp6.forward(&start).inv_mul(&irp6.forward(q));
            let aside = deviation.translation.vector.xy().norm();
            assert!(aside < 1e-5 && deviation.rotation.angle() < 1e-4, "{deviation}");
        }
        let end = irp6.forward(trace.borrow().last().expect("recorded"));
        let displacement = irp6.forward(&start).inv_mul(&end).translation.vector;
        assert!((displacement.z - 0.05).abs() < 1e-5, "{displacement}");
        report.time.as_secs_f64()
    }

    #[test]
    fn the_tool_goes_straight_down_in_the_closed_form_time() {
        let translation = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
        let rotation = ProfileLimits { velocity: 0.5, acceleration: 2.0 };
        let duration = straight_down(ToolLimits { translation, rotation });
        // T = D / V + V / A = 0.05 / 0.1 + 0.1 / 0.5.
        assert!((0.70..0.72).contains(&duration), "{duration} s");
    }

    #[test]
    fn with_limited_jerk_it_goes_along_the_same_path_in_the_closed_form_time() {
        let translation = JerkLimits { velocity: 0.1, acceleration: 0.5, jerk: 5.0 };
        let rotation = JerkLimits { velocity: 0.5, acceleration: 2.0, jerk: 20.0 };
        let duration = straight_down(SmoothToolLimits { translation, rotation });
        // T = D / V + V / A + A / J = 0.05 / 0.1 + 0.1 / 0.5 + 0.5 / 5.
        assert!((0.80..0.82).contains(&duration), "{duration} s");
    }
}
