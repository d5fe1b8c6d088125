//! An Archimedean spiral that grows from a point, with a time law: the path of a search.
//!
//! ```text
//! r = a phi,   a = pitch / 2 pi                                   the distance between two turns is the pitch
//! s(phi) = integral of sqrt(c^2 + a^2 phi^2),   c^2 = a^2 + b^2    what the profile moves; the length is that with b = 0
//!        = [phi sqrt(c^2 + a^2 phi^2) + c^2 / a asinh(a phi / c)] / 2
//! speed  = s' sqrt((a^2 + r^2) / (a^2 + r^2 + b^2)),   b = V^2 / A
//! ```
//!
//! In the middle a spiral is so narrow that no arm goes along it at the speed `V`. So the speed grows with the radius there: it
//! is `V` but for a share of at most `b^2 / 2 r^2`. With `w^2 = 1 + phi^2` the acceleration across the path is
//! `V^2 a (w + 1 / w) / (a^2 w^2 + b^2) <= V^2 / b = A`, as `a w / (a^2 w^2 + b^2) <= 1 / 2 b`.
//!
//! **Coverage.** On every ray from the middle neighbouring turns are one pitch apart, and the last one is farther out than the
//! radius less half a pitch. So no point within the radius is farther from the path than half a pitch.
//!
//! Source: Chhatpar and Branicky, *Search strategies for peg-in-hole assemblies with position uncertainty* (IROS 2001); Park et
//! al., *Compliance-based robotic peg-in-hole assembly strategy without force feedback* (2017). The time law is our own.

use core::f64::consts::TAU;

use nalgebra::Vector2;
use thiserror::Error;

use crate::profile::{JerkLimits, ProfileError, SevenPhase};

/// An Archimedean spiral in a plane: of distances \[m\], or of tilts \[rad\]. *Units* are either.
///
/// ```
/// use mrroc_generators::profile::{JerkLimits, Profile};
/// use mrroc_generators::spiral::Spiral;
///
/// // Turns 1 mm apart, over all within 5 mm, at 10 mm/s.
/// let limits = JerkLimits { velocity: 0.01, acceleration: 0.1, jerk: 2.0 };
/// let spiral = Spiral::new(1e-3, 5e-3, limits)?;
/// assert!((spiral.at(spiral.profile().distance()).norm() - 5.5e-3).abs() < 1e-12);
/// # Ok::<(), mrroc_generators::spiral::BadSpiral>(())
/// ```
#[derive(Clone, Debug)]
pub struct Spiral {
    /// Radius per angle [units/rad].
    a: f64,
    /// The square of `c` [units²].
    c2: f64,
    profile: SevenPhase,
}

/// Why there is no spiral.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum BadSpiral {
    /// A number is out of range.
    #[error("the {name} of a spiral is {value}, it must lie within {least:e} and {most:e}")]
    Range {
        /// Which number.
        name: &'static str,
        /// Its value, SI.
        value: f64,
        /// The least that it may be.
        least: f64,
        /// The most that it may be.
        most: f64,
    },
    /// A limit of its time law.
    #[error(transparent)]
    Limits(#[from] ProfileError),
}

impl Spiral {
    /// The most turns of a spiral.
    pub const TURNS: f64 = 1e4;

    /// From the middle outwards: `pitch` \[units\] between two turns, so far that no point within `radius` \[units\] is farther
    /// from the path than half a pitch. It ends at `radius + pitch / 2`. From rest to rest within `limits`.
    ///
    /// # Errors
    /// Pitch or radius not within 1e-9 and 1e3, a speed that takes more than 1e3 to be reached by the acceleration, more turns
    /// than [`TURNS`](Self::TURNS), or limits that are none.
    pub fn new(pitch: f64, radius: f64, limits: JerkLimits) -> Result<Self, BadSpiral> {
        let b = limits.velocity * limits.velocity / limits.acceleration;
        for (name, value, least, most) in [
            ("pitch", pitch, 1e-9, 1e3),
            ("radius", radius, 1e-9, 1e3),
            ("number of turns", radius / pitch, 0.0, Self::TURNS),
            ("square of the speed by the acceleration", b, 0.0, 1e3),
        ] {
            if !(least..=most).contains(&value) {
                return Err(BadSpiral::Range { name, value, least, most });
            }
        }
        let a = pitch / TAU;
        let c2 = a * a + b * b;
        let length = nominal(a, c2, (radius + 0.5 * pitch) / a);
        Ok(Spiral { a, c2, profile: SevenPhase::new(length, limits)? })
    }

    /// The time law, of the `s` that [`at`](Self::at) takes.
    #[must_use]
    pub const fn profile(&self) -> &SevenPhase {
        &self.profile
    }

    /// The point at `s` \[units\] of the profile, from the middle on; it leaves along x.
    #[must_use]
    pub fn at(&self, s: f64) -> Vector2<f64> {
        let phi = self.angle(s);
        Vector2::new(phi.cos(), phi.sin()) * (self.a * phi)
    }

    /// The angle at `s`: Newton's iteration from above. As `s(phi)` is convex, it comes down to the root without passing it.
    fn angle(&self, s: f64) -> f64 {
        let mut phi = (s / self.c2.sqrt()).min((2.0 * s / self.a).sqrt());
        for _ in 0..50 {
            let step = (nominal(self.a, self.c2, phi) - s) / (self.c2 + (self.a * phi).powi(2)).sqrt();
            phi -= step;
            if step.abs() <= 1e-14 * (1.0 + phi) {
                break;
            }
        }
        phi
    }
}

/// `s(phi)`.
fn nominal(a: f64, c2: f64, phi: f64) -> f64 {
    0.5 * (phi * (c2 + (a * phi).powi(2)).sqrt() + c2 / a * (a * phi / c2.sqrt()).asinh())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::Profile;
    use core::f64::consts::PI;

    const LIMITS: JerkLimits = JerkLimits { velocity: 0.01, acceleration: 0.1, jerk: 2.0 };
    const PITCH: f64 = 1e-3;
    const RADIUS: f64 = 5e-3;

    fn spiral() -> Spiral {
        Spiral::new(PITCH, RADIUS, LIMITS).expect("in range")
    }

    /// Points every `dt` of its time law, to the end.
    fn points(spiral: &Spiral, dt: f64) -> Vec<Vector2<f64>> {
        let profile = spiral.profile();
        let steps = (profile.duration() / dt).ceil() as usize;
        (0..=steps).map(|i| spiral.at(profile.at(i as f64 * dt).s)).collect()
    }

    #[test]
    fn turns_are_a_pitch_apart_on_every_ray() {
        let points = points(&spiral(), 1e-4);
        // The angle is counted on: r = pitch phi / 2 pi at each point, and so at each turn.
        let mut phi = 0.0;
        for pair in points.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            if from.norm() > 1e-9 {
                phi += (from.x * to.y - from.y * to.x).atan2(from.dot(&to));
            } else {
                phi = to.norm() * TAU / PITCH;
            }
            assert!((to.norm() - PITCH * phi / TAU).abs() < 1e-9, "{} at {phi}", to.norm());
        }
        assert!((phi - (TAU * RADIUS / PITCH + PI)).abs() < 1e-6, "{phi}");
    }

    #[test]
    fn no_point_within_the_radius_is_farther_from_the_path_than_half_a_pitch() {
        let path = points(&spiral(), 1e-3);
        // Points of the path are 10 um apart at most.
        let reach = 0.5 * PITCH + 5e-6;
        let mut farthest = 0.0_f64;
        for i in -50..=50 {
            for j in -50..=50 {
                let point = Vector2::new(f64::from(i), f64::from(j)) * (RADIUS / 50.0);
                if point.norm() <= RADIUS {
                    let nearest =
                        path.iter().map(|at| (at - point).norm_squared()).fold(f64::INFINITY, f64::min);
                    farthest = farthest.max(nearest.sqrt());
                }
            }
        }
        assert!(farthest <= reach && farthest > 0.45 * PITCH, "{farthest}");
    }

    /// Differences of points a time `dt` apart, between start and stop: the speed is the one of the equation above, and its share
    /// below `V` at most `b^2 / 2 r^2`.
    #[test]
    fn the_speed_is_constant_but_near_the_middle_and_the_acceleration_is_within_its_bounds() {
        let (spiral, dt) = (spiral(), 1e-4);
        let points = points(&spiral, dt);
        let ramp = 0.01 / 0.1 + 0.1 / 2.0;
        let duration = spiral.profile().duration();
        let b = 0.01 * 0.01 / 0.1;
        let mut slowest_outside = f64::INFINITY;
        for (i, w) in points.windows(3).enumerate() {
            let velocity = (w[2] - w[0]) / (2.0 * dt);
            let acceleration = (w[2] - 2.0 * w[1] + w[0]) / (dt * dt);
            let (t, r) = ((i + 1) as f64 * dt, w[1].norm());
            assert!(velocity.norm() <= 0.01 * (1.0 + 1e-6), "{} m/s", velocity.norm());
            let across = (velocity.x * acceleration.y - velocity.y * acceleration.x) / velocity.norm();
            let along = velocity.dot(&acceleration) / velocity.norm();
            // 9 / 16 sqrt(3) of A comes from the speed that grows with the radius.
            assert!(across.abs() <= 0.1 * 1.001 && along.abs() <= 0.1 * 1.33, "{across} {along} at {t}");
            if (ramp..duration - ramp).contains(&t) {
                let a2 = (PITCH / TAU).powi(2);
                let speed = 0.01 * ((a2 + r * r) / (a2 + r * r + b * b)).sqrt();
                assert!((velocity.norm() - speed).abs() < 1e-6, "{} {speed} at {t}", velocity.norm());
                if r > 3.0 * b {
                    slowest_outside = slowest_outside.min(velocity.norm());
                }
            }
        }
        assert!(slowest_outside >= 0.01 * (1.0 - 0.5 / 9.0), "{slowest_outside}");
    }

    /// The length of an Archimedean spiral, `a / 2 (phi sqrt(1 + phi^2) + asinh phi)`, against the sum of chords.
    #[test]
    fn its_length_is_the_closed_form() {
        let chords: f64 = points(&spiral(), 1e-4).windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        let (a, phi) = (PITCH / TAU, TAU * RADIUS / PITCH + PI);
        let length = 0.5 * a * (phi * phi.hypot(1.0) + phi.asinh());
        assert!((chords - length).abs() < 1e-6 * length, "{chords} {length}");
    }

    #[test]
    fn numbers_out_of_range_are_named() {
        let name = |pitch, radius, limits| match Spiral::new(pitch, radius, limits) {
            Err(BadSpiral::Range { name, .. }) => name,
            Err(BadSpiral::Limits(_)) => "limits",
            Ok(_) => "none",
        };
        assert_eq!(name(0.0, RADIUS, LIMITS), "pitch");
        assert_eq!(name(f64::NAN, RADIUS, LIMITS), "pitch");
        assert_eq!(name(PITCH, f64::INFINITY, LIMITS), "radius");
        assert_eq!(name(1e-8, 1.0, LIMITS), "number of turns");
        assert_eq!(
            name(PITCH, RADIUS, JerkLimits { velocity: 1e9, ..LIMITS }),
            "square of the speed by the acceleration"
        );
        assert_eq!(name(PITCH, RADIUS, JerkLimits { jerk: 0.0, ..LIMITS }), "limits");
        assert_eq!(name(PITCH, RADIUS, LIMITS), "none");
    }
}
