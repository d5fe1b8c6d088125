//! The chain from base to tip: which joints move, how far, and where their axes lie.

use mrroc::pose::Pose;
use mrroc::robot::{JointKind, MAX_JOINTS};
use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};

use super::body::{Body, Rigid};
use super::document::{Element, Joint, Tree, shown};
use super::error::UrdfError;
use super::places::{Follows, Moves, Place, axis, places};

/// A joint with a coordinate of its own.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mover {
    pub(super) name: String,
    pub(super) kind: JointKind,
    /// Position limits [rad or m].
    pub(super) range: (f64, f64),
    /// Largest speed [rad/s or m/s].
    pub(super) velocity: f64,
    /// Largest acceleration and jerk that the file states, if it does (URDF 1.2).
    pub(super) acceleration: Option<f64>,
    pub(super) jerk: Option<f64>,
    /// Largest effort that the file states, >= 0 [N m or N].
    pub(super) effort: Option<f64>,
    /// Damping [N m s or N s/m] and friction [N m or N], >= 0.
    pub(super) damping: f64,
    pub(super) friction: f64,
}

/// One joint that moves, with all that is fixed before it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)]
pub(super) struct Segment {
    /// Pose of the joint's frame, its z along the axis, in the frame of the joint before, where that stands at 0.
    pub(super) X_before: Pose,
    pub(super) kind: JointKind,
    /// The coordinate that moves it: `multiplier q[leader] + offset`, the multiplier not 0.
    pub(super) leader: usize,
    pub(super) multiplier: f64,
    pub(super) offset: f64,
}

/// What lies between base and tip.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub(super) struct Chain {
    pub(super) movers: Vec<Mover>,
    pub(super) segments: Vec<Segment>,
    /// What each segment moves, up to the next.
    pub(super) bodies: Vec<Body>,
    /// Pose of the tip in the frame of the last joint that moves.
    pub(super) X_tip: Pose,
}

/// A joint that moves, as it stands in the file.
#[allow(non_snake_case)]
struct Found<'a, 'i> {
    joint: Joint<'a, 'i>,
    X_before: Pose,
    moves: Moves<'a>,
    velocity: Option<f64>,
    acceleration: Option<f64>,
    jerk: Option<f64>,
    effort: Option<f64>,
    damping: f64,
    friction: f64,
}

impl Chain {
    /// The chain from `base` to `tip`, whose number of coordinates must be `asked` where a number is.
    ///
    /// # Errors
    /// See [`UrdfError`].
    pub(super) fn between(
        tree: &Tree<'_, '_>,
        base: &str,
        tip: &str,
        asked: Option<usize>,
    ) -> Result<Self, UrdfError> {
        let mut found: Vec<Found<'_, '_>> = Vec::new();
        let mut bodies: Vec<Rigid> = Vec::new();
        let mut fixed = Pose::identity();
        for Place { joint, X_PJ, moves } in places(tree, base, tip)? {
            fixed *= X_PJ;
            let child = joint.child;
            if let Some(moves) = moves {
                let to_axis = turn_of_z(axis(&joint)?);
                found.push(moving(joint, moves, fixed * to_axis)?);
                fixed = Pose::from_parts(Translation3::identity(), to_axis.inverse());
                bodies.push(Rigid::default());
            }
            // What is fixed to the base moves nothing.
            if let Some(body) = bodies.last_mut() {
                body.add(tree, child, &fixed)?;
            }
        }
        let leads = |one: &&Found<'_, '_>| one.moves.follows.is_none();
        let movers: Vec<&str> = found.iter().filter(leads).map(|one| one.joint.name).collect();
        if let Some(asked) = asked.filter(|asked| movers.len() != *asked) {
            return Err(wrong_count(base, tip, movers.into_iter().map(shown).collect(), asked));
        }
        let mut chain = Self {
            movers: found.iter().filter(leads).map(Found::mover).collect::<Result<_, _>>()?,
            segments: Vec::new(),
            bodies: bodies.into_iter().map(Rigid::body).collect::<Result<_, _>>()?,
            X_tip: fixed,
        };
        for one in &found {
            let itself = Follows { leader: one.joint.name, multiplier: 1.0, offset: 0.0 };
            let Follows { leader, multiplier, offset } = one.moves.follows.unwrap_or(itself);
            let leader = movers.iter().position(|name| *name == leader).unwrap_or_default();
            if one.moves.follows.is_some() {
                chain.movers[leader].also_keep(one, multiplier, offset)?;
            }
            let kind = one.moves.kind;
            chain.segments.push(Segment { X_before: one.X_before, kind, leader, multiplier, offset });
        }
        Ok(chain)
    }
}

fn wrong_count(base: &str, tip: &str, names: Vec<String>, asked: usize) -> UrdfError {
    let count = names.len();
    let help = match count {
        0 => "choose a tip beyond a joint that moves".to_owned(),
        1..=MAX_JOINTS => format!("write Serial<{count}>"),
        _ => format!("a robot has at most {MAX_JOINTS}, choose a shorter chain"),
    };
    let names = if count == 0 { "none".to_owned() } else { names.join(", ") };
    UrdfError::WrongCount { base: shown(base), tip: shown(tip), count, names, asked, help }
}

/// A rotation that takes z to the unit vector `axis`.
pub(super) fn turn_of_z(axis: Vector3<f64>) -> UnitQuaternion<f64> {
    // Half-way between z and the axis lies the axis of a half turn; below the horizon, x joins in to keep it sharp.
    if axis.z >= 0.0 {
        UnitQuaternion::new_normalize(Quaternion::new(1.0 + axis.z, -axis.y, axis.x, 0.0))
    } else {
        UnitQuaternion::new_normalize(Quaternion::new(-axis.y, 1.0 - axis.z, 0.0, axis.x))
    }
}

/// A joint that moves, with its limits.
fn moving<'a, 'i>(
    joint: Joint<'a, 'i>,
    moves: Moves<'a>,
    #[allow(non_snake_case)] X_before: Pose,
) -> Result<Found<'a, 'i>, UrdfError> {
    let element = &joint.element;
    let mut velocity = None;
    let mut acceleration = None;
    let mut jerk = None;
    let mut effort = None;
    if let Some(limit) = element.child("limit")? {
        velocity = above_zero(&limit, "velocity")?;
        let deceleration = above_zero(&limit, "deceleration")?.unwrap_or(f64::INFINITY);
        acceleration = above_zero(&limit, "acceleration")?.map(|a| a.min(deceleration));
        jerk = above_zero(&limit, "jerk")?;
        effort = not_below_zero(&limit, "effort")?;
    }
    let mut damping = 0.0;
    let mut friction = 0.0;
    if let Some(dynamics) = element.child("dynamics")? {
        damping = not_below_zero(&dynamics, "damping")?.unwrap_or(0.0);
        friction = not_below_zero(&dynamics, "friction")?.unwrap_or(0.0);
    }
    Ok(Found { joint, X_before, moves, velocity, acceleration, jerk, effort, damping, friction })
}

/// The number of an attribute that must not be below 0.
fn not_below_zero(element: &Element<'_, '_>, attribute: &'static str) -> Result<Option<f64>, UrdfError> {
    match element.number(attribute)? {
        Some(number) if number < 0.0 => Err(element.bad(attribute, "a finite number >= 0")),
        number => Ok(number),
    }
}

/// The number of an attribute that must be above 0.
fn above_zero(limit: &Element<'_, '_>, attribute: &'static str) -> Result<Option<f64>, UrdfError> {
    match limit.number(attribute)? {
        Some(number) if number <= 0.0 => Err(limit.bad(attribute, "a finite number above 0")),
        number => Ok(number),
    }
}

impl Found<'_, '_> {
    /// The coordinate of a joint that moves by itself.
    fn mover(&self) -> Result<Mover, UrdfError> {
        let element = &self.joint.element;
        let velocity = self.velocity.ok_or_else(|| match element.child("limit") {
            Ok(Some(limit)) => limit.missing("velocity", "velocity=\"..\" [rad/s or m/s]"),
            _ => UrdfError::MissingElement {
                line: element.line(),
                element: element.called.clone(),
                child: "limit",
                write: "<limit velocity=\"..\"/>",
            },
        })?;
        Ok(Mover {
            name: self.joint.name.to_owned(),
            kind: self.moves.kind,
            range: self.moves.range,
            velocity,
            acceleration: self.acceleration,
            jerk: self.jerk,
            effort: self.effort,
            damping: self.damping,
            friction: self.friction,
        })
    }
}

impl Mover {
    /// Narrows the limits to those that keep the limits of a joint that follows, with a multiplier that is not 0.
    fn also_keep(&mut self, one: &Found<'_, '_>, multiplier: f64, offset: f64) -> Result<(), UrdfError> {
        let nothing_left = || UrdfError::MimicLimits {
            line: one.joint.element.line(),
            joint: shown(one.joint.name),
            leader: shown(&self.name),
        };
        let (lower, upper) = one.moves.range;
        let a = (lower - offset) / multiplier;
        let b = (upper - offset) / multiplier;
        let range = (self.range.0.max(a.min(b)), self.range.1.min(a.max(b)));
        if range.0.is_nan() || range.1.is_nan() || range.0 >= range.1 {
            return Err(nothing_left());
        }
        let keep = |own: Option<f64>, follower: Option<f64>| {
            let follower = follower.map(|limit| limit / multiplier.abs());
            own.into_iter().chain(follower).reduce(f64::min)
        };
        self.range = range;
        self.velocity = keep(Some(self.velocity), one.velocity).unwrap_or(self.velocity);
        self.acceleration = keep(self.acceleration, one.acceleration);
        self.jerk = keep(self.jerk, one.jerk);
        // The friction of what follows is overcome by what leads.
        self.damping += one.damping * multiplier * multiplier;
        self.friction += one.friction * multiplier.abs();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn z_turns_to_every_axis() {
        for x in -2..=2 {
            for y in -2..=2 {
                for z in -2..=2 {
                    let axis = Vector3::new(f64::from(x), f64::from(y), f64::from(z));
                    let axes = [axis, axis + Vector3::new(1e-9, -1e-12, 0.0)];
                    for axis in axes.into_iter().filter_map(|axis| axis.try_normalize(0.1)) {
                        assert!((turn_of_z(axis) * Vector3::z() - axis).amax() < 1e-15, "{axis}");
                    }
                }
            }
        }
    }
}
