//! Moves the tool along any curve with limited jerk, from rest to rest.

use core::marker::PhantomData;

use mrroc::prelude::*;
use nalgebra::Translation3;

use mrroc_generators::ahead::Ahead;
use mrroc_generators::curve::Curve;
use mrroc_generators::profile::{JerkLimits, ProfileCursor, SevenPhase};

/// Moves the tool from where it is along a curve (a helix, an ellipse, a blended polyline ..), with a constant
/// orientation.
///
/// The displacements of the curve from its start are along the axes of the world. The limits hold along the curve; the
/// acceleration across it is `v^2` times its curvature.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::curve::Helix;
/// use mrroc_generators::generators::CurveMove;
/// use mrroc_generators::profile::JerkLimits;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::Irp6;
/// use nalgebra::Vector3;
///
/// // A turn about the z axis of the tool as it stands at the start, 5 cm beside it, which advances by 2 cm.
/// let helix = Helix::about(Vector3::zeros(), Vector3::x() * 0.05, Vector3::z_axis(), std::f64::consts::TAU, 0.02);
/// let helix = helix.map_err(|bad| Fault::thrown(&bad.to_string()))?;
/// let limits = JerkLimits { velocity: 0.1, acceleration: 0.5, jerk: 5.0 };
/// let demands = rehearse(CurveMove::along(helix, limits), &Irp6::nominal(), Irp6::READY, 0.002)?;
/// // D / V + V / A + A / J with D = |(0.05 * 2 pi, 0.02)| = 0.3148 m: 3.448 s.
/// assert_eq!(demands.len(), 1724);
/// # Ok::<(), Fault>(())
/// ```
pub struct CurveMove<R, C> {
    curve: C,
    limits: JerkLimits,
    path: Option<(Pose, ProfileCursor<SevenPhase>)>,
    ahead: Ahead,
    of: PhantomData<R>,
}

impl<R: Robot, C: Curve> CurveMove<R, C> {
    /// Along `curve` \[m\] within `limits` [m/s], [m/s²], [m/s³].
    #[must_use]
    pub fn along(curve: C, limits: JerkLimits) -> Self {
        CurveMove { curve, limits, path: None, ahead: Ahead::default(), of: PhantomData }
    }

    fn advance(&mut self, t: Tick) -> Step<R> {
        let Some((start, cursor)) = &mut self.path else { return Step::Done };
        let Some(point) = cursor.advance(t.dt) else { return Step::Done };
        let origin = self.curve.at(0.0).position;
        let at = |s: f64| Demand::pose(Translation3::from(self.curve.at(s).position - origin) * *start);
        let step = Step::Next(at(point.s));
        match self.ahead.next() {
            Some(share) => step.with_goal(at(share * self.curve.length())),
            None => step,
        }
    }
}

#[generator(ecp)]
impl<R: Robot, C: Curve + 'static> CurveMove<R, C> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        let profile = SevenPhase::new(self.curve.length(), self.limits);
        let profile = profile.map_err(|error| Fault::thrown(&error.to_string()))?;
        self.path = Some((e.demanded().pose, ProfileCursor::new(profile)));
        Ok(self.advance(t))
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        self.advance(t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc_generators::curve::Helix;
    use mrroc_robots::{Irp6, SimulatedIrp6};
    use nalgebra::Vector3;
    use std::time::Duration;

    #[test]
    fn a_turn_of_a_helix_ends_one_pitch_higher_in_the_closed_form_time() {
        let irp6 = Irp6::nominal();
        let start = Irp6::READY;
        let arm = SimulatedIrp6::new(irp6.clone(), &start);
        let shaft = arm.shaft();
        let turn = std::f64::consts::TAU;
        let helix = Helix::about(Vector3::x() * 0.02, Vector3::zeros(), Vector3::z_axis(), turn, 0.03);
        let helix = helix.expect("a helix");
        let limits = JerkLimits { velocity: 0.05, acceleration: 0.25, jerk: 2.5 };
        let robot = RobotSetup::new("irp6", irp6.clone(), arm)
            .program(move |ecp| ecp.move_robot((), CurveMove::along(helix, limits)).map(drop));
        let report = Cell::new(Duration::from_millis(2)).robot(robot).run().expect("within the limits");
        // T = D / V + V / A + A / J, D = hypot(2 pi r, pitch).
        let least = (turn * 0.02).hypot(0.03) / 0.05 + 0.3;
        let duration = report.time.as_secs_f64();
        assert!((least - 0.01..least + 0.02).contains(&duration), "{duration} s, {least} s");
        let up = irp6.forward(&shaft.state().position).translation.vector
            - irp6.forward(&start).translation.vector;
        assert!((up - Vector3::z() * 0.03).norm() < 1e-3, "{up}");
    }
}
