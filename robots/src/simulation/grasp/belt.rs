//! A belt: a level surface that moves, with an end.
//!
//! ```text
//! u: along the belt, x of its base frame B;   v_b: its speed, the true one of the joint
//!
//! contact  as on a table (`contact.rs`), by the velocity of a point less v_b u
//! load     -sum f . u, over all points of bodies on it, through the transmission on the motor
//! ```

use mrroc::pose::Pose;
use nalgebra::Vector3;

use super::contact::Table;
use super::error::{WorldError, positive};
use super::motion::{Motion, Nanos, seconds};

/// The surface of a belt, in the base frame B of its conveyor: the plane z = 0, along x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Belt {
    from: f64,
    to: f64,
    half_width: f64,
    friction: f64,
    stiffness: f64,
    damping: f64,
}

impl Belt {
    /// A point that is deeper in the belt than this is not on it, but beside it or below \[m\].
    const DEEPEST: f64 = 0.01;
    /// A point that is not on the belt comes onto it from above, or less than this below its surface \[m\]: one that comes in from beside
    /// the belt, deeper, would be thrown up.
    const LIP: f64 = 1e-3;

    /// A belt from `from` to `to` along x of its base and this wide \[m\], of friction 0.5 and, at each point that touches it,
    /// 4e3 N/m and 12 N s/m, as of rubber (assumed).
    #[must_use]
    pub const fn new(from: f64, to: f64, width: f64) -> Self {
        Self { from, to, half_width: 0.5 * width, friction: 0.5, stiffness: 4e3, damping: 12.0 }
    }

    /// The same belt with this coefficient of friction, >= 0.
    #[must_use]
    pub const fn with_friction(self, friction: f64) -> Self {
        Self { friction, ..self }
    }

    /// The same belt with this stiffness [N/m], > 0, and damping [N s/m], >= 0, at each point.
    #[must_use]
    pub const fn with_stiffness(self, stiffness: f64, damping: f64) -> Self {
        Self { stiffness, damping, ..self }
    }

    fn check(&self) -> Result<(), WorldError> {
        positive("the belt's length", self.to - self.from, "m")?;
        positive("the belt's width", self.half_width, "m")?;
        Ok(())
    }
}

/// A belt, as the world keeps it.
#[derive(Clone, Debug)]
#[allow(non_snake_case)]
pub(super) struct BeltState {
    pub motion: Motion,
    pub table: Table,
    belt: Belt,
    X_WB: Pose,
    /// x of B, in the world.
    along: Vector3<f64>,
    /// Impulse on the belt along it since its last servo period [N s], and its length \[s\].
    impulse: f64,
    elapsed: f64,
    force: f64,
}

impl BeltState {
    #[allow(non_snake_case)]
    pub fn new(belt: Belt, X_WB: Pose, period: Nanos, now: Nanos, X_WF: Pose) -> Result<Self, WorldError> {
        belt.check()?;
        let leaning = (X_WB.rotation * Vector3::z() - Vector3::z()).norm();
        if leaning.is_nan() || leaning > 1e-9 {
            return Err(WorldError::Leaning(leaning));
        }
        let table = Table::at(X_WB.translation.z)
            .with_friction(belt.friction)
            .with_stiffness(belt.stiffness, belt.damping);
        table.check()?;
        let motion = Motion::new(period, now, X_WF);
        let along = X_WB.rotation * Vector3::x();
        Ok(Self { motion, table, belt, X_WB, along, impulse: 0.0, elapsed: 0.0, force: 0.0 })
    }

    /// Whether a point is over the belt or within `reach` \[m\] of it, and less than `reach` above it; `is_on` says whether it was on it before.
    pub fn is_near(&self, point: &Vector3<f64>, reach: f64, is_on: bool) -> bool {
        let deepest = if is_on { Belt::DEEPEST } else { Belt::LIP };
        let at = self.X_WB.rotation.inverse_transform_vector(&(point - self.X_WB.translation.vector));
        at.z < reach
            && at.z > -deepest
            && at.x >= self.belt.from
            && at.x <= self.belt.to
            && at.y.abs() <= self.belt.half_width
    }

    /// How far a place is from the nearer end or edge of the belt, > 0 on it \[m\].
    pub fn inside(&self, point: &Vector3<f64>) -> f64 {
        let at = self.X_WB.rotation.inverse_transform_vector(&(point - self.X_WB.translation.vector));
        (at.x - self.belt.from).min(self.belt.to - at.x).min(self.belt.half_width - at.y.abs())
    }

    /// Takes a force of a body on it for `h` \[s\].
    #[inline]
    pub fn push(&mut self, force: &Vector3<f64>, h: f64) {
        self.impulse += force.dot(&self.along) * h;
    }

    /// So much time has passed \[s\].
    pub fn pass(&mut self, duration: f64) {
        self.elapsed += duration;
    }

    /// Whether a period ended long ago whose load its drive has not taken.
    pub fn is_overdue(&self) -> bool {
        self.elapsed > 1.5 * seconds(self.motion.period)
    }

    /// The force of the bodies along it \[N\], mean since the last call.
    pub fn take_force(&mut self) -> f64 {
        if self.elapsed > 0.0 {
            self.force = self.impulse / self.elapsed;
            self.impulse = 0.0;
            self.elapsed = 0.0;
        }
        self.force
    }
}
