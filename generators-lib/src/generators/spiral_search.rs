//! Leads the tool on a spiral across its z axis, from where it is outwards: a search for a hole.

use core::marker::PhantomData;

use mrroc::prelude::*;

use mrroc_generators::ahead::Ahead;
use mrroc_generators::profile::{JerkLimits, Profile, ProfileCursor, SevenPhase};
use mrroc_generators::spiral::Spiral;

/// Leads the tool on an Archimedean spiral in the plane of its x and y axes as they are at the start, with a constant
/// orientation: turns one pitch apart, at a constant speed but near the middle. See [`Spiral`].
///
/// It presses on nothing and feels nothing. [`Compliant`](crate::combinators::Compliant) presses meanwhile and ends it where the
/// tool falls into the hole. A hole that catches a tool which is up to a distance beside its middle is not missed by
/// turns twice that far apart.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::SpiralSearch;
/// use mrroc_generators::profile::JerkLimits;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::Irp6;
///
/// // All within 3 mm, turns 1 mm apart, at 5 mm/s.
/// let limits = JerkLimits { velocity: 0.005, acceleration: 0.05, jerk: 1.0 };
/// let irp6 = Irp6::nominal();
/// let demands = rehearse(SpiralSearch::over(3e-3, 1e-3, limits), &irp6, Irp6::READY, 0.002)?;
/// // Its last turn ends half a pitch farther out.
/// let end = demands.last().and_then(Demand::as_pose).map(|end| irp6.forward(&Irp6::READY).inv_mul(&end));
/// assert!(end.is_some_and(|end| (end.translation.vector.norm() - 3.5e-3).abs() < 1e-9));
/// # Ok::<(), Fault>(())
/// ```
pub struct SpiralSearch<R> {
    radius: f64,
    pitch: f64,
    limits: JerkLimits,
    path: Option<(Pose, Spiral, ProfileCursor<SevenPhase>)>,
    ahead: Ahead,
    of: PhantomData<R>,
}

impl<R: Robot> SpiralSearch<R> {
    /// Over all within `radius` \[m\], with `pitch` \[m\] between two turns, within `limits` [m/s], [m/s²], [m/s³].
    #[must_use]
    pub fn over(radius: f64, pitch: f64, limits: JerkLimits) -> Self {
        SpiralSearch { radius, pitch, limits, path: None, ahead: Ahead::default(), of: PhantomData }
    }
}

#[generator(ecp)]
impl<R: Robot> SpiralSearch<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        let spiral = Spiral::new(self.pitch, self.radius, self.limits);
        let spiral = spiral.map_err(|bad| Fault::thrown(&bad.to_string()))?;
        let cursor = ProfileCursor::new(*spiral.profile());
        self.path = Some((e.demanded().pose, spiral, cursor));
        Ok(self.next_step(t))
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        let Some((start, spiral, cursor)) = &mut self.path else { return Step::Done };
        let Some(point) = cursor.advance(t.dt) else { return Step::Done };
        let beside = |s: f64| {
            let place = spiral.at(s);
            Demand::pose(*start * Pose::translation(place.x, place.y, 0.0))
        };
        let step = Step::Next(beside(point.s));
        match self.ahead.next() {
            Some(share) => step.with_goal(beside(share * cursor.profile().distance())),
            None => step,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc_robots::{Irp6, SimulatedIrp6};
    use std::time::Duration;

    #[test]
    fn an_arm_goes_round_in_the_plane_of_its_tool_as_long_as_the_closed_form_says() {
        let irp6 = Irp6::nominal();
        let start = Irp6::READY;
        let arm = SimulatedIrp6::new(irp6.clone(), &start);
        let shaft = arm.shaft();
        let limits = JerkLimits { velocity: 0.005, acceleration: 0.05, jerk: 1.0 };
        let (pitch, radius) = (1e-3, 3e-3);
        let robot = RobotSetup::new("irp6", irp6.clone(), arm)
            .program(move |ecp| ecp.move_robot((), SpiralSearch::over(radius, pitch, limits)).map(drop));
        let report = Cell::new(Duration::from_millis(2)).robot(robot).run().expect("within the limits");
        // D / V + V / A + A / J, D = c / 2 (u sqrt(1 + u^2) + asinh u) c / a, u = r / c, as in the module `spiral`.
        let (a, b) = (pitch / std::f64::consts::TAU, 0.005_f64.powi(2) / 0.05);
        let c = a.hypot(b);
        let u: f64 = (radius + 0.5 * pitch) / c;
        let length = 0.5 * c * c / a * (u * u.hypot(1.0) + u.asinh());
        let least = length / 0.005 + 0.005 / 0.05 + 0.05 / 1.0;
        let duration = report.time.as_secs_f64();
        assert!((least - 0.01..least + 0.02).contains(&duration), "{duration} s, {least} s");
        let end = irp6.forward(&start).inv_mul(&irp6.forward(&shaft.state().position));
        let across = end.translation.vector.xy().norm();
        assert!((across - 3.5e-3).abs() < 2e-4 && end.translation.z.abs() < 2e-4, "{end}");
        assert!(end.rotation.angle() < 1e-3, "{end}");
    }
}
