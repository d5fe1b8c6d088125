//! Moves the tool along an arc of a circle with limited jerk, from rest to rest.

use core::marker::PhantomData;

use mrroc::prelude::*;
use nalgebra::Vector3;

use mrroc_generators::ahead::Ahead;
use mrroc_generators::curve::{Arc, Curve, TurnedCurve};
use mrroc_generators::line::SmoothToolLimits;
use mrroc_generators::profile::{JerkLimits, ProfileCursor, SevenPhase};

/// Moves the tool along a circle, through a point, to a pose. Meanwhile the tool turns through the smaller angle. One jerk-limited
/// profile leads both.
///
/// Starts from the pose demanded last, at rest. The limits hold along the circle; the acceleration across it is
/// `v^2 / r`.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::CircularMove;
/// use mrroc_generators::line::SmoothToolLimits;
/// use mrroc_generators::profile::JerkLimits;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::Irp6;
///
/// let irp6 = Irp6::nominal();
/// let limits = JerkLimits { velocity: 0.1, acceleration: 0.5, jerk: 5.0 };
/// let limits = SmoothToolLimits { translation: limits, rotation: limits };
/// // Half a circle of 5 cm radius beside the tool.
/// let at = |x, y| irp6.forward(&Irp6::READY) * Pose::translation(x, y, 0.0);
/// let arc = CircularMove::through(at(0.05, 0.05).translation.vector, at(0.1, 0.0), limits);
/// let demands = rehearse(arc, &irp6, Irp6::READY, 0.002)?;
/// // D / V + V / A + A / J = (1.5708 + 0.2 + 0.1) s, in steps of 2 ms.
/// assert_eq!(demands.len(), 936);
/// let radius = |pose: Pose| (pose.translation.vector - at(0.05, 0.0).translation.vector).norm();
/// assert!(demands.iter().filter_map(Demand::as_pose).all(|pose| (radius(pose) - 0.05).abs() < 1e-9));
/// # Ok::<(), Fault>(())
/// ```
pub struct CircularMove<R> {
    via: Vector3<f64>,
    goal: Pose,
    limits: SmoothToolLimits,
    path: Option<(TurnedCurve<Arc>, ProfileCursor<SevenPhase>)>,
    ahead: Ahead,
    of: PhantomData<R>,
}

impl<R: Robot> CircularMove<R> {
    /// Through the point `p_WV` of the world \[m\] to the pose `X_WE` of the tool.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn through(p_WV: Vector3<f64>, X_WE: Pose, limits: SmoothToolLimits) -> Self {
        CircularMove { via: p_WV, goal: X_WE, limits, path: None, ahead: Ahead::default(), of: PhantomData }
    }

    fn advance(&mut self, t: Tick) -> Step<R> {
        let Some((path, cursor)) = &mut self.path else { return Step::Done };
        let Some(point) = cursor.advance(t.dt) else { return Step::Done };
        let step = Step::Next(Demand::pose(path.pose(point.s)));
        match self.ahead.next() {
            Some(share) => step.with_goal(Demand::pose(path.pose(share * path.curve().length()))),
            None => step,
        }
    }
}

#[generator(ecp)]
impl<R: Robot> CircularMove<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        let start = e.demanded().pose;
        let arc = Arc::through(start.translation.vector, self.via, self.goal.translation.vector);
        let path = arc.and_then(|arc| TurnedCurve::new(arc, start, self.goal));
        let path = path.map_err(|error| Fault::thrown(&error.to_string()))?;
        let SmoothToolLimits { translation, rotation } = self.limits;
        // The turn's limits, as limits of the length that goes with it.
        let length = path.curve().length();
        let rate = length / path.angle().max(1e-12);
        let limits = JerkLimits {
            velocity: translation.velocity.min(rotation.velocity * rate),
            acceleration: translation.acceleration.min(rotation.acceleration * rate),
            jerk: translation.jerk.min(rotation.jerk * rate),
        };
        let profile = SevenPhase::new(length, limits);
        let profile = profile.map_err(|error| Fault::thrown(&error.to_string()))?;
        self.path = Some((path, ProfileCursor::new(profile)));
        Ok(self.advance(t))
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        self.advance(t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::observe::ServoRecord;

    use mrroc_robots::{Irp6, SimulatedIrp6};
    use std::{cell::RefCell, rc::Rc, time::Duration};

    #[test]
    fn half_a_circle_is_a_circle_and_takes_the_closed_form_time() {
        const RADIUS: f64 = 0.03;
        let irp6 = Irp6::nominal();
        let start = Irp6::READY;
        let trace = Rc::new(RefCell::new(Vec::new()));
        let pose = irp6.forward(&start);
        let recorder = Rc::clone(&trace);
        let at = |x: f64, y: f64| pose * Pose::translation(x, y, 0.0);
        let via = at(RADIUS, RADIUS).translation.vector;
        let goal = at(2.0 * RADIUS, 0.0);
        let limits = JerkLimits { velocity: 0.05, acceleration: 0.25, jerk: 2.5 };
        let limits = SmoothToolLimits { translation: limits, rotation: limits };
        let robot = RobotSetup::new("irp6", irp6.clone(), SimulatedIrp6::new(irp6.clone(), &start))
            .observe(move |record: &ServoRecord<Irp6>| recorder.borrow_mut().push(record.demanded))
            .program(move |ecp| ecp.move_robot((), CircularMove::through(via, goal, limits)).map(drop));
        let report = Cell::new(Duration::from_millis(2)).robot(robot).run().expect("within the limits");
        // T = D / V + V / A + A / J = pi r / 0.05 + 0.2 + 0.1.
        let least = std::f64::consts::PI * RADIUS / 0.05 + 0.3;
        let duration = report.time.as_secs_f64();
        assert!((least - 0.01..least + 0.02).contains(&duration), "{duration} s, {least} s");
        // To 20 um, as the encoders count the start.
        let centre = at(RADIUS, 0.0);
        for q in trace.borrow().iter() {
            let p = centre.inv_mul(&irp6.forward(q)).translation.vector;
            assert!((p.xy().norm() - RADIUS).abs() < 2e-5 && p.z.abs() < 2e-5, "{p}");
        }
    }
}
