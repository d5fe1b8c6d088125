//! Tilts the tool about its x and y axes in a pattern that grows: a search for the direction of a hole.

use core::marker::PhantomData;

use mrroc::prelude::*;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use mrroc_generators::ahead::Ahead;
use mrroc_generators::profile::{JerkLimits, Profile, ProfileCursor, SevenPhase};
use mrroc_generators::spiral::Spiral;

/// Tilts the tool about its origin, where it is at the start, to every side: its rotation vector in the tool's axes goes on a
/// [`Spiral`] in the plane of x and y, from no tilt outwards. No direction within the largest tilt is missed by more than half
/// of the pitch.
///
/// It presses on nothing and feels nothing. [`Compliant`](crate::combinators::Compliant) presses meanwhile and ends it where the
/// tool goes on into the hole. The origin of the tool is its tip, so that the tip stays in the hole.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::TiltSearch;
/// use mrroc_generators::profile::JerkLimits;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::Irp6;
///
/// // All within 0.03 rad, turns 0.01 rad apart, at 0.05 rad/s.
/// let limits = JerkLimits { velocity: 0.05, acceleration: 0.5, jerk: 10.0 };
/// let irp6 = Irp6::nominal();
/// let demands = rehearse(TiltSearch::within(0.03, 0.01, limits), &irp6, Irp6::READY, 0.002)?;
/// let end = demands.last().and_then(Demand::as_pose).map(|end| irp6.forward(&Irp6::READY).inv_mul(&end));
/// assert!(end.is_some_and(|end| (end.rotation.angle() - 0.035).abs() < 1e-9));
/// assert!(end.is_some_and(|end| end.translation.vector.norm() < 1e-12));
/// # Ok::<(), Fault>(())
/// ```
pub struct TiltSearch<R> {
    largest: f64,
    pitch: f64,
    limits: JerkLimits,
    path: Option<(Pose, Spiral, ProfileCursor<SevenPhase>)>,
    ahead: Ahead,
    of: PhantomData<R>,
}

impl<R: Robot> TiltSearch<R> {
    /// Over all tilts within `largest` \[rad\], with `pitch` \[rad\] between two turns, within `limits` [rad/s], [rad/s²], [rad/s³].
    #[must_use]
    pub fn within(largest: f64, pitch: f64, limits: JerkLimits) -> Self {
        TiltSearch { largest, pitch, limits, path: None, ahead: Ahead::default(), of: PhantomData }
    }
}

#[generator(ecp)]
impl<R: Robot> TiltSearch<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        if self.largest > core::f64::consts::FRAC_PI_2 {
            let fault = Fault::thrown("a search by tilts goes farther than a quarter turn");
            return Err(fault.exceeds(self.largest, core::f64::consts::FRAC_PI_2, "rad"));
        }
        let spiral = Spiral::new(self.pitch, self.largest, self.limits);
        let spiral = spiral.map_err(|bad| Fault::thrown(&bad.to_string()))?;
        let cursor = ProfileCursor::new(*spiral.profile());
        self.path = Some((e.demanded().pose, spiral, cursor));
        Ok(self.next_step(t))
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        let Some((start, spiral, cursor)) = &mut self.path else { return Step::Done };
        let Some(point) = cursor.advance(t.dt) else { return Step::Done };
        let tilted = |s: f64| {
            let tilt = spiral.at(s);
            let turn = UnitQuaternion::from_scaled_axis(Vector3::new(tilt.x, tilt.y, 0.0));
            Demand::pose(*start * Pose::from_parts(Translation3::identity(), turn))
        };
        let step = Step::Next(tilted(point.s));
        match self.ahead.next() {
            Some(share) => step.with_goal(tilted(share * cursor.profile().distance())),
            None => step,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc_generators::rehearsal::rehearse;
    use mrroc_robots::Irp6;

    /// Every tilt on a grid within the largest one comes within half of the pitch, while the tip stays where it is.
    #[test]
    fn no_tilt_is_missed_by_more_than_half_of_the_pitch_and_the_tip_stays() {
        let irp6 = Irp6::nominal();
        let start = irp6.forward(&Irp6::READY);
        let limits = JerkLimits { velocity: 0.05, acceleration: 0.5, jerk: 10.0 };
        let (largest, pitch) = (0.03, 0.01);
        let demands = rehearse(TiltSearch::within(largest, pitch, limits), &irp6, Irp6::READY, 0.002);
        let tilt = |demand: &Demand<Irp6>| {
            let tilted = start.inv_mul(&demand.as_pose().expect("a pose"));
            assert!(tilted.translation.vector.norm() < 1e-12, "{tilted}");
            tilted.rotation.scaled_axis()
        };
        let tilts: Vec<_> = demands.expect("in range").iter().map(tilt).collect();
        for i in -20..=20 {
            for j in -20..=20 {
                let wanted = Vector3::new(f64::from(i), f64::from(j), 0.0) * (largest / 20.0);
                let nearest = tilts.iter().map(|tilt| (tilt - wanted).norm()).fold(f64::INFINITY, f64::min);
                // Steps of 0.1 mrad.
                assert!(
                    wanted.norm() > largest || nearest <= 0.5 * pitch + 5e-5,
                    "{nearest} rad from {wanted}"
                );
            }
        }
    }

    #[test]
    fn a_tilt_beyond_a_quarter_turn_is_refused() {
        let limits = JerkLimits { velocity: 0.05, acceleration: 0.5, jerk: 10.0 };
        let search = TiltSearch::within(1.6, 0.1, limits);
        let fault = rehearse(search, &Irp6::nominal(), Irp6::READY, 0.002).expect_err("too far");
        assert!(fault.to_string().contains("quarter turn"), "{fault}");
    }
}
