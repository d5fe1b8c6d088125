//! Motor angles of the IRp-6 from its joint angles and back.
//!
//! ```text
//! column        m1 = s1 + g1 (theta1 - o1)
//! lower, upper  l = sqrt(L + mu cos(theta) - nu sin(theta)) \[mm\],   m = s + (2 pi / 5) (l - l0)
//! T             m4 = s4 + g4 theta4
//! V             m5 = s5 + g5 (theta5 - o5) + (m4 - s4)
//! N             m6 = s6 + g6 (theta6 - o6)
//! ```
//!
//! with the *absolute* link angles `theta2 = q2`, `theta3 = q2 + q3 + pi/2`, `theta4 = theta3 + q4`: every
//! link is driven from the base or through a parallelogram. V rides on T, so its motor turns with it; no
//! motor angle is wrapped. Source: public facts of MRROC++. A rod joins the nut of a screw to its link at a
//! fixed distance, hence the square root (law of cosines); `L`, `mu`, `nu` are in mm², `l0` in mm.

use core::f64::consts::{FRAC_PI_2, PI};

use crate::models::vectors::Six;

/// Turn of a ball screw per length: 5 mm lead [rad/mm].
const SCREW: f64 = 2.0 * PI / 5.0;

/// A geared axis, turning or sliding: `m = synchro + gear (theta - offset)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    /// Motor angle at `theta = offset` \[rad\].
    pub synchro: f64,
    /// Motor angle per joint position [rad/rad or rad/m], signed, not 0.
    pub gear: f64,
    /// Joint position at the synchronisation position [rad or m].
    pub offset: f64,
}

impl Linear {
    /// The motor angle \[rad\] at the joint position `theta` [rad or m].
    #[must_use]
    pub fn motor(&self, theta: f64) -> f64 {
        self.synchro + self.gear * (theta - self.offset)
    }

    /// The joint position [rad or m] at a motor angle \[rad\].
    #[must_use]
    pub fn joint(&self, motor: f64) -> f64 {
        (motor - self.synchro) / self.gear + self.offset
    }
}

/// A link driven by a ball screw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screw {
    /// Motor angle at the screw length `reference` \[rad\].
    pub synchro: f64,
    /// Constant term of the squared length \[mm²\].
    pub square: f64,
    /// Cosine term of the squared length \[mm²\].
    pub mu: f64,
    /// Negative sine term of the squared length \[mm²\].
    pub nu: f64,
    /// Screw length at synchronisation \[mm\].
    pub reference: f64,
}

/// A screw-driven link as its motor angle determines it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkState {
    /// Absolute link angle \[rad\].
    pub angle: f64,
    /// Its cosine.
    pub cosine: f64,
    /// Motor angle per link angle [rad/rad], > 0.
    pub ratio: f64,
}

/// A screw-driven link, all but its angle.
#[derive(Clone, Copy)]
pub(crate) struct Lever {
    /// Sine of the absolute link angle.
    pub sine: f64,
    /// Its cosine.
    pub cosine: f64,
    /// Motor angle per link angle [rad/rad], > 0.
    pub ratio: f64,
}

impl Screw {
    /// The motor angle \[rad\] at the absolute link angle \[rad\].
    #[must_use]
    pub fn motor(&self, angle: f64) -> f64 {
        let (sine, cosine) = angle.sin_cos();
        let length = (self.square + self.mu * cosine - self.nu * sine).sqrt();
        self.synchro + SCREW * (length - self.reference)
    }

    /// The link at a motor angle \[rad\]; NaN where the linkage cannot be closed (far outside the motor limits).
    #[must_use]
    pub fn link(&self, motor: f64) -> LinkState {
        let Lever { sine, cosine, ratio } = self.lever(motor);
        LinkState { angle: sine.atan2(cosine), cosine, ratio }
    }

    /// The same without the angle itself.
    pub(crate) fn lever(&self, motor: f64) -> Lever {
        let length = (motor - self.synchro) / SCREW + self.reference;
        let c = length * length - self.square;
        let m = self.mu * self.mu + self.nu * self.nu;
        let d = (m - c * c).sqrt();
        let cosine = (self.mu * c - self.nu * d) / m;
        let sine = -(self.nu * c + self.mu * d) / m;
        Lever { sine, cosine, ratio: SCREW * d / (2.0 * length) }
    }
}

/// The six drives of an IRp-6.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmission {
    /// Column.
    pub column: Linear,
    /// Lower arm (link of length a2).
    pub lower: Screw,
    /// Upper arm (link of length a3).
    pub upper: Screw,
    /// Wrist pitch T, on the absolute angle theta4.
    pub t: Linear,
    /// Wrist roll V, whose motor also turns with T.
    pub v: Linear,
    /// Flange turn N.
    pub n: Linear,
}

impl Transmission {
    /// Motor angles \[rad\] of the joint angles `q` \[rad\].
    #[must_use]
    pub fn motors(&self, q: &Six) -> Six {
        let theta3 = q[1] + q[2] + FRAC_PI_2;
        let t = self.t.motor(theta3 + q[3]);
        Six::new(
            self.column.motor(q[0]),
            self.lower.motor(q[1]),
            self.upper.motor(theta3),
            t,
            self.v.motor(q[4]) + (t - self.t.synchro),
            self.n.motor(q[5]),
        )
    }

    /// Motor angles at the synchronisation position \[rad\] (MRROC++).
    #[must_use]
    pub fn marks(&self) -> Six {
        Six::new(
            self.column.synchro,
            self.lower.synchro,
            self.upper.synchro,
            self.t.synchro,
            self.v.synchro,
            self.n.synchro,
        )
    }

    /// Joint angles \[rad\] of the motor angles `m` \[rad\]; NaN where a screw's linkage cannot be closed.
    #[must_use]
    pub fn joints(&self, m: &Six) -> Six {
        self.assemble(m, &self.lower.link(m[1]), &self.upper.link(m[2]))
    }

    /// Joint angles from motor angles, for links that are already known.
    pub(crate) fn assemble(&self, m: &Six, lower: &LinkState, upper: &LinkState) -> Six {
        Six::new(
            self.column.joint(m[0]),
            lower.angle,
            upper.angle - lower.angle - FRAC_PI_2,
            self.t.joint(m[3]) - upper.angle,
            self.v.joint(m[4] - (m[3] - self.t.synchro)),
            self.n.joint(m[5]),
        )
    }

    /// Joint speeds [rad/s] of the motor speeds `speeds` [rad/s].
    pub(crate) fn joint_rates(&self, speeds: &Six, lower: &LinkState, upper: &LinkState) -> Six {
        let theta2 = speeds[1] / lower.ratio;
        let theta3 = speeds[2] / upper.ratio;
        Six::new(
            speeds[0] / self.column.gear,
            theta2,
            theta3 - theta2,
            speeds[3] / self.t.gear - theta3,
            (speeds[4] - speeds[3]) / self.v.gear,
            speeds[5] / self.n.gear,
        )
    }
}
