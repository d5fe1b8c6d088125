//! A table: a level, compliant plane with Coulomb friction, which a body touches with points of its hull.
//!
//! ```text
//! delta = height - z > 0:   n = max(0, k delta - c dz/dt)                  never pulls
//!                           s = how far the point has crept since it touched, at most mu n / k long
//!                           t = -k s - beta c v_t,   |t| <= mu n           beta in 0..1: damping yields to friction
//! ```
//!
//! The stretch `s` is the static friction: a body at rest stays at rest under any force within the friction cone, and slides when
//! the force leaves it. No term creates energy: stretch beyond the cone is cut off, never put on.

use mrroc::pose::Wrench;
use nalgebra::{SVector, Vector2, Vector3};

use super::error::{WorldError, not_negative, positive};

/// A level table under the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table {
    height: f64,
    friction: f64,
    stiffness: f64,
    damping: f64,
}

impl Table {
    /// A table whose top lies at the height `z` [m, world], of friction 0.4 and, at each point that touches it, 2e4 N/m
    /// and 200 N s/m (assumed).
    #[must_use]
    pub fn at(z: f64) -> Self {
        Self { height: z, friction: 0.4, stiffness: 2e4, damping: 200.0 }
    }

    /// The same table with this coefficient of friction, >= 0.
    #[must_use]
    pub fn with_friction(self, friction: f64) -> Self {
        Self { friction, ..self }
    }

    /// The same table with this stiffness [N/m], > 0, and damping [N s/m], >= 0, at each point.
    #[must_use]
    pub fn with_stiffness(self, stiffness: f64, damping: f64) -> Self {
        Self { stiffness, damping, ..self }
    }

    pub(super) fn check(&self) -> Result<(), WorldError> {
        if !self.height.is_finite() {
            return Err(WorldError::NotFinite("the table's height"));
        }
        not_negative("the table's friction", self.friction, "")?;
        positive("the table's stiffness", self.stiffness, "N/m")?;
        not_negative("the table's damping", self.damping, "N s/m")?;
        Ok(())
    }

    /// Whether a point at the height `z` \[m\] that moves by less than `reach` \[m\] may touch.
    pub(super) fn is_near(&self, z: f64, reach: f64) -> bool {
        z < self.height + reach
    }

    /// Its coefficient of friction.
    pub(super) fn friction(&self) -> f64 {
        self.friction
    }

    /// Stiffness [N/m] and damping [N s/m] of one point.
    pub(super) fn compliance(&self) -> (f64, f64) {
        (self.stiffness, self.damping)
    }

    /// Energy stored at a point at the height `z` \[m\] with the stretch `stretch` \[J\].
    pub(super) fn energy(&self, z: f64, stretch: &Vector2<f64>) -> f64 {
        let depth = (self.height - z).max(0.0);
        0.5 * self.stiffness * (depth * depth + stretch.norm_squared())
    }

    /// The force on a point at the height `z` \[m\] moving at `velocity` [m/s], after `h` \[s\] at that velocity.
    #[inline]
    pub(super) fn force(
        &self,
        z: f64,
        velocity: &Vector3<f64>,
        h: f64,
        stretch: &mut Vector2<f64>,
    ) -> Vector3<f64> {
        let depth = self.height - z;
        if depth <= 0.0 {
            *stretch = Vector2::zeros();
            return Vector3::zeros();
        }
        let normal = (self.stiffness * depth - self.damping * velocity.z).max(0.0);
        let sliding = velocity.xy();
        let cone = self.friction * normal;
        *stretch += sliding * h;
        let pull = self.stiffness * stretch.norm();
        if pull > cone {
            *stretch *= cone / pull;
        }
        let elastic = -self.stiffness * *stretch;
        let viscous = -self.damping * sliding;
        let tangential = elastic + viscous * within(&elastic, &viscous, cone);
        Vector3::new(tangential.x, tangential.y, normal)
    }
}

/// The largest share of `b`, 0 to 1, with which `a + share b` is at most `cone` long; `a` alone is.
#[inline]
pub(super) fn within<const N: usize>(a: &SVector<f64, N>, b: &SVector<f64, N>, cone: f64) -> f64 {
    if (a + b).norm_squared() <= cone * cone {
        return 1.0;
    }
    // |a|^2 + 2 share a.b + share^2 |b|^2 = cone^2, of which the positive root is taken.
    let bb = b.norm_squared();
    let ab = a.dot(b);
    let room = (cone * cone - a.norm_squared()).max(0.0);
    let root = (ab * ab + bb * room).sqrt();
    // Without cancellation: (root - ab) / bb = room / (root + ab).
    let share = if ab > 0.0 { room / (root + ab) } else { (root - ab) / bb };
    share.clamp(0.0, 1.0)
}

/// A point of the hull.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// \[m, in B\].
    pub at: Vector3<f64>,
    /// How it yields to a force [1/kg].
    pub yielding: f64,
    /// How far it has crept from where it stuck \[m\].
    pub stretch: Vector2<f64>,
    /// The force on it \[N\], kept to be looked up.
    pub force: Vector3<f64>,
    /// The belt that it may touch; else it may touch the table.
    pub on: Option<usize>,
}

/// A force at the lever `lever` \[m\] as a wrench about the centre of mass.
#[inline]
pub(super) fn at_lever(force: Vector3<f64>, lever: &Vector3<f64>) -> Wrench {
    Wrench::new(force, lever.cross(&force))
}
