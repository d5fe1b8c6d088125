//! RNT's closed linkages: from the lengths of the two actuators to the directions of the links, and back.
//!
//! In: lengths of the actuators \[m\], or directions of upper arm and forearm in the arm's plane. Out: the other, the
//! derivatives, and how well the rods transmit. The three loops and the sketch stand at [`Rnt`](super::Rnt):
//!
//! ```text
//! |A2 - 0.25 e(theta2)| = q2,   |A3 - 0.2 e(rho)| = q3,   |T - R| = 0.52,  T = a2 e(theta2) - 0.2 e(theta3),  R = 0.2 e(rho)
//! ```

use mrroc::robot::NoInverse;
use nalgebra::Vector2;

use super::A2;

/// Where an actuator is fixed to the column, in the arm's plane from O.
#[derive(Clone, Copy)]
pub(super) struct Foot {
    /// Distance from O \[m\].
    pub(super) distance: f64,
    /// Cosine of its direction, forwards.
    pub(super) cosine: f64,
    /// Sine of its direction, upwards.
    pub(super) sine: f64,
}

/// Foot of the shoulder's actuator, at -20 deg.
pub(super) const FOOT2: Foot =
    Foot { distance: 0.40, cosine: 0.939_692_620_785_908_4, sine: -0.342_020_143_325_668_7 };
/// Foot of the elbow's actuator, at 250 deg.
pub(super) const FOOT3: Foot =
    Foot { distance: 0.55, cosine: -0.342_020_143_325_668_7, sine: -0.939_692_620_785_908_4 };
/// Where the shoulder's actuator takes the upper arm, from O \[m\].
pub(super) const CRANK: f64 = 0.25;
/// Rocker, O to R \[m\].
pub(super) const ROCKER: f64 = 0.20;
/// Forearm behind the elbow, E to T \[m\].
pub(super) const TAIL: f64 = 0.20;
/// Rod, R to T \[m\].
pub(super) const ROD: f64 = 0.52;

/// The linkages as the actuators set them, in the arm's plane: first coordinate forwards, second upwards, from O.
#[derive(Clone, Copy)]
pub(super) struct Linkage {
    /// Direction of the upper arm.
    pub(super) upper: Vector2<f64>,
    /// Direction of the forearm.
    pub(super) forearm: Vector2<f64>,
    /// Direction of the rocker.
    pub(super) rocker: Vector2<f64>,
    /// From R to T \[m\].
    pub(super) rod: Vector2<f64>,
    /// Sine of the angle between the foot's direction and the crank, and between the rocker and its foot's.
    pub(super) sines: [f64; 2],
}

/// A vector turned by 90 deg upwards.
pub(super) fn left(v: &Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-v.y, v.x)
}

impl Linkage {
    /// Solves the loops; `None` where they cannot be closed.
    #[inline]
    pub(super) fn of(q2: f64, q3: f64) -> Option<Self> {
        // The crank stands counter-clockwise of its foot, the rocker clockwise of its own.
        let (upper, sine2) = by_length(FOOT2, CRANK, q2, 1.0)?;
        let (rocker, sine3) = by_length(FOOT3, ROCKER, q3, -1.0)?;
        let elbow = upper * A2;
        let tip = rocker * ROCKER;
        // T on the circles about R and E, on the side away from O.
        let between = elbow - tip;
        let square = between.norm_squared();
        let along = 0.5 * (square + (ROD * ROD - TAIL * TAIL));
        let across = ROD * ROD * square - along * along;
        if across.is_nan() || across < 0.0 {
            return None;
        }
        let inverse = 1.0 / square;
        let aside = left(&between) * across.sqrt();
        let rod = (between * along + aside) * inverse;
        // (T - E) / -TAIL, without waiting for the rod.
        let forearm = (between * (square - along) - aside) * (inverse * (1.0 / TAIL));
        Some(Self { upper, forearm, rocker, rod, sines: [sine2, sine3] })
    }

    /// Derivatives of theta2 by q2 and of theta3 by q2 and q3 [rad/m].
    pub(super) fn rates(&self, q2: f64, q3: f64) -> (f64, f64, f64) {
        let theta2 = q2 / (FOOT2.distance * CRANK * self.sines[0]);
        let rho = -q3 / (FOOT3.distance * ROCKER * self.sines[1]);
        // (T - R) . (dT - dR) = 0 with dT = a2 left(upper) dtheta2 - tail left(forearm) dtheta3.
        let of_tail = self.rod.dot(&left(&self.forearm)) * TAIL;
        let by_upper = self.rod.dot(&left(&self.upper)) * A2 / of_tail;
        let by_rocker = -self.rod.dot(&left(&self.rocker)) * ROCKER / of_tail;
        (theta2, by_upper * theta2, by_rocker * rho)
    }

    /// The least sine of the angles at which the linkages drive their links; below 0 in another assembly.
    pub(super) fn transmission(&self) -> f64 {
        let sine = |a: &Vector2<f64>, b: &Vector2<f64>| (a.x * b.y - a.y * b.x) / ROD;
        let at_tail = sine(&self.rod, &self.forearm);
        let at_rocker = sine(&self.rod, &self.rocker);
        at_tail.abs().min(at_rocker).min(self.sines[0]).min(self.sines[1])
    }

    /// The actuators' lengths for elevations with the cosines and sines `upper`, `forearm`.
    ///
    /// # Errors
    /// The linkages cannot be assembled so, as they are built: they would have to go through a dead centre.
    #[inline]
    pub(super) fn lengths(upper: &Vector2<f64>, forearm: &Vector2<f64>) -> Result<(f64, f64), NoInverse> {
        let tail = upper * A2 - forearm * TAIL;
        // R on the circles about O and T; behind the line from O to T.
        let square = tail.norm_squared();
        let along = (square + ROCKER * ROCKER - ROD * ROD) / (2.0 * square);
        let across = ROCKER * ROCKER / square - along * along;
        if across.is_nan() || across < 0.0 {
            let length = square.sqrt();
            let actual = (length - ROD - ROCKER).max(ROD - ROCKER - length);
            let what = "distance beyond the linkage's dead centre";
            return Err(NoInverse::NotAttainable { what, actual, tolerance: 0.0, unit: "m" });
        }
        let rocker = (tail * along + left(&tail) * across.sqrt()) * (1.0 / ROCKER);
        let foot2 = Vector2::new(FOOT2.cosine, FOOT2.sine) * FOOT2.distance;
        let foot3 = Vector2::new(FOOT3.cosine, FOOT3.sine) * FOOT3.distance;
        let q2 = (upper * CRANK - foot2).norm();
        let q3 = (rocker * ROCKER - foot3).norm();
        // Assembled otherwise, the same lengths give another posture.
        let built = Self::of(q2, q3).ok_or(NoInverse::Singular { name: "dead centre of the linkage" })?;
        let off = (built.upper - upper).amax().max((built.forearm - forearm).amax());
        let tolerance = 1e-6;
        if off < tolerance {
            return Ok((q2, q3));
        }
        let what = "turn beyond the linkage's dead centre";
        Err(NoInverse::NotAttainable { what, actual: off, tolerance, unit: "rad" })
    }
}

/// Direction of a crank of length `crank` whose end lies `length` from a foot, on the side `turn` of it, and the sine of
/// the angle between them.
#[inline]
fn by_length(foot: Foot, crank: f64, length: f64, turn: f64) -> Option<(Vector2<f64>, f64)> {
    let Foot { distance, cosine: c, sine: s } = foot;
    let cosine = (distance * distance + crank * crank - length * length) * (1.0 / (2.0 * distance * crank));
    let square = 1.0 - cosine * cosine;
    if square.is_nan() || square < 0.0 || length < 0.0 {
        return None;
    }
    let sine = square.sqrt();
    Some((Vector2::new(c * cosine - turn * s * sine, s * cosine + turn * c * sine), sine))
}
