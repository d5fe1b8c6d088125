//! How a base follows a path: on time, within its limits, and corrected by where it stands.
//!
//! ```text
//! plan         s(t): the fastest motion along the path within SHARE of the wheels' limits, and those of bends
//! wheels       q = q(s) + sum of d dt
//! correction   (v, w) = (-k_x e_x, -v (e_y / l^2 + 2 e_h / l)),  d follows wheels(v, w) by no more than RESERVE of the acceleration limit,
//!              and is never more than RESERVE of the velocity limit
//! ```
//!
//! So each wheel keeps its limits by construction: `SHARE + RESERVE <= 0.9`, and a tenth is left to the operator's feed rate. The errors `e`
//! compare where the base stands with where it should have been when that was measured: a cell carries a demand out a step or two later. Kanayama et al.,
//! *A Stable Tracking Control Method for an Autonomous Mobile Robot* (1990), with gains by length instead of by time.

use mrroc::fault::Fault;
use mrroc::robot::Robot as _;
use mrroc_generators::curve::{Parametric, SplinePoint};
use mrroc_generators::profile::ProfileCursor;
use mrroc_generators::timing::{LinearLimit, PathLimits, TimeOptimal, grid};

use crate::model::{DiffDrive, Two};
use crate::path::Path;
use crate::sensing::Planar;

/// Limits of a base on a path, beside those of its wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseLimits {
    /// Speed ahead [m/s], > 0.
    pub speed: f64,
    /// Acceleration to the side in bends [m/s²], > 0: what tyres hold without sliding much.
    pub lateral: f64,
    /// How fast it may turn [rad/s], > 0.
    pub turning: f64,
    /// How far it may be off its path \[m\], > 0: farther off is a fault.
    pub off: f64,
}

/// The plan takes this share of the wheels' limits ..
const SHARE: f64 = 0.6;
/// .. and corrections as much as this one.
const RESERVE: f64 = 0.3;
/// Length within which a base comes back onto its path \[m\].
const BACK: f64 = 0.06;
/// Rate at which it makes up for a lag along its path [1/s].
const ALONG: f64 = 4.0;
/// Rate at which it corrects its heading where it does not roll [1/s].
const TURNED: f64 = 8.0;
/// A base is turned right if its heading is off by no more than this \[rad\] ..
const RIGHT: f64 = 4e-3;
/// .. for which it gets so much path time at the end \[s\].
const SETTLING: f64 = 0.4;
/// How many steps of references are kept.
const KEPT: usize = 8;

/// A base on its path.
#[derive(Debug)]
pub struct Follower {
    path: Path,
    limits: BaseLimits,
    delay: f64,
    plan: Option<ProfileCursor<TimeOptimal>>,
    /// References of the last steps, the newest first.
    references: [Planar; KEPT],
    correction: Two,
    corrected: Two,
    s: f64,
    settled: f64,
    ends: bool,
}

impl Follower {
    /// On `path`, within `limits`; what is measured is so many steps behind what is demanded, 0 to 6.
    #[must_use]
    pub fn on(path: Path, limits: BaseLimits, delay: f64) -> Self {
        let start = path.at(0.0).pose;
        Self {
            path,
            limits,
            delay: delay.clamp(0.0, KEPT as f64 - 2.0),
            plan: None,
            references: [start; KEPT],
            correction: Two::zeros(),
            corrected: Two::zeros(),
            s: 0.0,
            settled: 0.0,
            ends: false,
        }
    }

    /// Where it should be.
    #[must_use]
    pub const fn reference(&self) -> &Planar {
        &self.references[0]
    }

    /// Plans from these angles of the wheels on \[rad\].
    ///
    /// # Errors
    /// A limit that is not positive.
    pub fn begin(&mut self, wheels: Two) -> Result<(), Fault> {
        let BaseLimits { speed, lateral, turning, off } = self.limits;
        if !(lateral > 0.0 && turning > 0.0 && off > 0.0) {
            return Err(Fault::thrown("the limits of a base on its path must be > 0"));
        }
        self.path = self.path.clone().with_wheels(wheels);
        let of = *DiffDrive::new().limits();
        let limits =
            PathLimits { velocity: of.velocity * SHARE, acceleration: of.acceleration * SHARE, speed };
        let spot = self.path.is_turn();
        let path = &self.path;
        let bends = |point: &SplinePoint<Two>, more: &mut Vec<LinearLimit>| {
            let (_, bend) = DiffDrive::rolled(&point.first);
            let side = if spot { 0.0 } else { bend };
            more.push(LinearLimit { a: 0.0, b: side, low: -lateral, high: lateral });
            more.push(LinearLimit { a: 0.0, b: bend * bend, low: -1.0, high: turning * turning });
        };
        let cells = (path.length() / 0.005).ceil().clamp(20.0, 2000.0) as usize;
        let plan = TimeOptimal::with_linear_limits(path, &grid(path, cells), &limits, [0.0; 2], bends);
        self.plan = Some(ProfileCursor::new(plan.map_err(|error| Fault::thrown(&error.to_string()))?));
        Ok(())
    }

    /// The next angles of the wheels \[rad\], from where the base stands if that is known; `None` at the end.
    ///
    /// # Errors
    /// It is farther off its path than it may be.
    pub fn advance(&mut self, standing: Option<&Planar>, dt: f64) -> Result<Option<Two>, Fault> {
        let Some(plan) = &mut self.plan else { return Ok(None) };
        if let Some(point) = plan.advance(dt) {
            self.s = point.s;
            self.settled = 0.0;
            self.correct(standing, point.v, dt)?;
        } else if self.ends {
            // The correction itself comes to rest before the motion is over.
            let most = self.slope() * dt;
            self.correction = self.correction.map(|x| x - x.clamp(-most, most));
            if self.correction == Two::zeros() {
                return Ok(None);
            }
        } else {
            self.settled += dt;
            let off = self.correct(standing, 0.0, dt)?;
            let is_right = off.is_none_or(|heading| heading.abs() < RIGHT) || self.settled > SETTLING;
            self.ends = is_right && self.settled > KEPT as f64 * dt;
        }
        self.corrected += self.correction * dt;
        Ok(Some(Parametric::at(&self.path, self.s).value + self.corrected))
    }

    /// How fast a correction may change [rad/s²].
    fn slope(&self) -> f64 {
        RESERVE * DiffDrive::new().limits().acceleration[0]
    }

    /// Corrects by where the base stands, at this speed along the path; how far its heading is off \[rad\].
    fn correct(&mut self, standing: Option<&Planar>, speed: f64, dt: f64) -> Result<Option<f64>, Fault> {
        let reference = self.path.at(self.s).pose;
        let was = {
            // Between the references of two steps.
            let (whole, part) = (self.delay.floor(), self.delay.fract());
            let before = |i: usize| if i == 0 { reference } else { self.references[i - 1] };
            let (a, b) = (before(whole as usize), before(whole as usize + 1));
            Planar {
                x: a.x + part * (b.x - a.x),
                y: a.y + part * (b.y - a.y),
                heading: a.heading + part * (b.heading - a.heading),
            }
        };
        self.references.rotate_right(1);
        self.references[0] = reference;
        let Some(standing) = standing else { return Ok(None) };
        let off = was.seen(&standing.at());
        let heading = standing.turned_from(&was);
        if off.norm().is_nan() || off.norm() > self.limits.off {
            return Err(Fault::thrown(
                "the base is farther off its path than it may be: it slips, or something stops it",
            )
            .exceeds(off.norm(), self.limits.off, "m"));
        }
        let spot = self.path.is_turn();
        let speed = if spot { 0.0 } else { speed };
        let ahead = if spot { 0.0 } else { -ALONG * off.x };
        let turn = -speed * off.y / (BACK * BACK) - (2.0 * speed / BACK).max(TURNED) * heading;
        let limits = *DiffDrive::new().limits();
        let (wanted, most) = (DiffDrive::wheels(ahead, turn), self.slope() * dt);
        for i in 0..2 {
            let top = RESERVE * limits.velocity[i];
            let wanted = wanted[i].clamp(-top, top);
            self.correction[i] += (wanted - self.correction[i]).clamp(-most, most);
        }
        Ok(Some(heading))
    }
}
