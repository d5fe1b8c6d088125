//! A footstep: one leg swings while the trunk goes on over the other three; then all stand for a while.
//!
//! In: how the machine stands, the gait, the ground as it is told to be. Out: where every foot is in the trunk at each time; or why the
//! footstep must not be made.
//!
//! ```text
//! L: the level at the footstep's begin, in the trunk's origin      X_LT(t): the trunk's motion, to the level at its end
//!
//! p_TF_i(t) = X_LT(t)^-1 p_LF_i      p_LF_i: constant for a foot that stands, a swing for the other
//! ```
//!
//! So the ground is a rigid body that the standing legs carry under the trunk, against its motion: two arms with a bar, upside down. The trunk
//! follows the ground: it comes to its height over the mean of the four feet, where the new one is expected.

use mrroc::pose::Pose;
use mrroc::robot::NoInverse;
use nalgebra::{UnitQuaternion, Vector2, Vector3};

use super::gait::{Gait, Part, soft};
use super::support::margin;
use super::swing::Swing;
use crate::ground::Ground;
use crate::leg::{Leg, Three};
use crate::places::NAMES;
use crate::plant::trunk;

/// The least static margin of a footstep \[m\].
pub const LEAST: f64 = 0.02;
/// Times at which a footstep is looked at beforehand.
const LOOKS: u32 = 16;

/// How the machine stands, as its legs and its inclinometer tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stance {
    /// Joint positions \[rad\].
    pub q: [Three; 4],
    /// The feet [m, T].
    pub feet: [Vector3<f64>; 4],
    /// The trunk's roll and pitch to the level \[rad\].
    pub lean: [f64; 2],
}

/// Why a footstep must not be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Refused {
    /// The machine would come too near to tipping over.
    #[error(
        "footstep of {leg} to x {x:.3} m is unstable: the centre of mass would come to {:.1} mm within the feet that stand, {:.0} mm are \
         needed: sway farther, or step shorter",
        1e3 * margin,
        1e3 * LEAST
    )]
    Unstable {
        /// The leg that is to swing.
        leg: &'static str,
        /// Where it is to step \[m\].
        x: f64,
        /// The least static margin \[m\].
        margin: f64,
    },
    /// A leg cannot be where it would have to be.
    #[error("footstep of {leg}: {other} cannot follow: {why}")]
    Unattainable {
        /// The leg that is to swing.
        leg: &'static str,
        /// The leg that cannot follow.
        other: &'static str,
        /// Why.
        why: NoInverse,
    },
    /// There is no place for the foot.
    #[error("footstep of {leg}: no place near x {x:.3} m is far enough from all edges")]
    NoFoothold {
        /// The leg that is to swing.
        leg: &'static str,
        /// Where it would step \[m\].
        x: f64,
    },
}

/// A footstep that may be made.
#[derive(Clone, Debug, PartialEq)]
pub struct Footstep {
    gait: Gait,
    /// When it begins in the gait \[s\].
    begins: f64,
    /// How long it lasts \[s\].
    lasts: f64,
    /// The leg and its swing; none while all stand.
    swing: Option<(usize, Swing)>,
    /// Where the feet are at its begin [m, L].
    feet: [Vector3<f64>; 4],
    /// The trunk's turn to the level at its begin, a rotation vector \[rad\].
    turn: Vector3<f64>,
    /// By how much the trunk rises \[m\].
    rise: f64,
    /// The least static margin \[m\].
    margin: f64,
}

impl Footstep {
    /// A part of the gait: all feet stand, but for the leg that is to step to `hold` [m, W].
    ///
    /// # Errors
    /// [`Refused`].
    pub fn plan(
        gait: &Gait,
        part: Part,
        hold: Option<(usize, Vector2<f64>)>,
        legs: &[Leg; 4],
        ground: &Ground,
        stance: &Stance,
    ) -> Result<Self, Refused> {
        let [roll, pitch] = stance.lean;
        let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), pitch)
            * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), roll);
        let (begins, lasts) = gait.when(part);
        let still = Self {
            gait: *gait,
            begins,
            lasts,
            swing: None,
            feet: stance.feet.map(|foot| turn * foot),
            turn: turn.scaled_axis(),
            rise: 0.0,
            margin: f64::INFINITY,
        };
        let Some((leg, hold)) = hold else { return still.rising(None).checked(legs, stance) };
        let at = hold - Vector2::new(gait.advance(begins), gait.aside(begins));
        still.stepping(leg, &at, ground).checked(legs, stance)
    }

    /// With this leg stepping there [m, along L].
    fn stepping(self, leg: usize, at: &Vector2<f64>, ground: &Ground) -> Self {
        let x = self.gait.advance(self.begins);
        let left = self.gait.aside(self.begins);
        let lane = |foot: &Vector2<f64>| ground.lane(foot.y + left);
        // How high the ground's zero is, by the feet that stand on it.
        let standing = (0..4).filter(|i| *i != leg);
        let zero: f64 = standing
            .map(|i| (self.feet[i].z - lane(&self.feet[i].xy()).height(x + self.feet[i].x)) / 3.0)
            .sum();
        let from = self.feet[leg];
        let to = Vector3::new(at.x, at.y, zero + lane(at).height(x + at.x));
        let over = 0.03;
        let highest = lane(at).highest(x + from.x - over, x + at.x + over);
        let top = (zero + highest).max(from.z).max(to.z) + self.gait.clearance;
        let swing = Swing::new(from, to, top, self.gait.swing);
        Self { swing: Some((leg, swing)), ..self }.rising(Some((leg, to.z)))
    }

    /// With the rise to the height over the feet, of which one will be at another height.
    fn rising(self, new: Option<(usize, f64)>) -> Self {
        let height = |i: usize| match new {
            Some((leg, z)) if leg == i => z,
            Some(_) | None => self.feet[i].z,
        };
        let mean = (0..4).map(height).sum::<f64>() / 4.0;
        Self { rise: mean + self.gait.height, ..self }
    }

    /// With its margin, or refused.
    fn checked(self, legs: &[Leg; 4], stance: &Stance) -> Result<Self, Refused> {
        let name = self.leg().map_or("none", |leg| NAMES[leg]);
        let mut q = stance.q;
        let mut least = f64::INFINITY;
        let lasts = self.lasts;
        for look in 0..=LOOKS {
            let t = lasts * f64::from(look) / f64::from(LOOKS);
            let feet = self.feet(t);
            for i in 0..4 {
                q[i] = legs[i].reach_for(&feet[i], &q[i]).map_err(|why| Refused::Unattainable {
                    leg: name,
                    other: NAMES[i],
                    why,
                })?;
            }
            let centre = centre_of_mass(legs, &q);
            let level = self.trunk(t).transform_point(&centre.into()).coords.xy();
            let swings = self.leg().filter(|_| t <= self.gait.swing);
            least = least.min(self.margin_without(swings, &level));
        }
        if least < LEAST {
            let x = self.swing.as_ref().map_or(0.0, |(_, swing)| swing.to().x);
            return Err(Refused::Unstable {
                leg: name,
                x: self.gait.advance(self.begins) + x,
                margin: least,
            });
        }
        Ok(Self { margin: least, ..self })
    }

    /// The static margin at a place of the centre of mass [m, L], over the feet but one, the swinging one where it lands.
    fn margin_without(&self, lifted: Option<usize>, centre: &Vector2<f64>) -> f64 {
        let mut standing = [Vector2::zeros(); 4];
        let mut count = 0;
        for i in (0..4).filter(|i| Some(*i) != lifted) {
            standing[count] = match &self.swing {
                Some((leg, swing)) if *leg == i => swing.to().xy(),
                Some(_) | None => self.feet[i].xy(),
            };
            count += 1;
        }
        margin(&standing[..count], centre)
    }

    /// How long it lasts \[s\].
    #[must_use]
    pub const fn lasts(&self) -> f64 {
        self.lasts
    }

    /// The leg that swings.
    #[must_use]
    pub fn leg(&self) -> Option<usize> {
        self.swing.as_ref().map(|(leg, _)| *leg)
    }

    /// The least static margin that it was planned with \[m\].
    #[must_use]
    pub const fn margin(&self) -> f64 {
        self.margin
    }

    /// Its swing.
    pub const fn swing_mut(&mut self) -> Option<&mut (usize, Swing)> {
        self.swing.as_mut()
    }

    /// `X_LT`, the trunk at a time from its begin \[s\].
    #[must_use]
    pub fn trunk(&self, t: f64) -> Pose {
        let s = soft(t / self.lasts);
        let at = |t: f64| Vector2::new(self.gait.advance(self.begins + t), self.gait.aside(self.begins + t));
        let moved = at(t) - at(0.0);
        let turn = UnitQuaternion::from_scaled_axis(self.turn * (1.0 - s));
        Pose::from_parts(Vector3::new(moved.x, moved.y, self.rise * s).into(), turn)
    }

    /// Where the feet are in the trunk at a time from its begin [m, T].
    #[must_use]
    #[allow(non_snake_case)]
    pub fn feet(&self, t: f64) -> [Vector3<f64>; 4] {
        let X_TL = self.trunk(t).inverse();
        core::array::from_fn(|i| {
            let at = match &self.swing {
                Some((leg, swing)) if *leg == i => swing.at(t),
                Some(_) | None => self.feet[i],
            };
            X_TL.transform_point(&at.into()).coords
        })
    }
}

/// Centre of mass of the machine [m, T].
#[must_use]
pub fn centre_of_mass(legs: &[Leg; 4], q: &[Three; 4]) -> Vector3<f64> {
    let mass = trunk::MASS + 4.0 * Leg::MASSES.iter().sum::<f64>();
    legs.iter().zip(q).map(|(leg, q)| leg.moment(q)).sum::<Vector3<f64>>() / mass
}
