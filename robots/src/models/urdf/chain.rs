//! The chain from base to tip: which joints move, how far, and where their axes lie.

use core::f64::consts::PI;

use mrroc::pose::Pose;
use mrroc::robot::{JointKind, MAX_JOINTS};
use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};

use super::body::Body;
use super::document::{Element, Joint, Tree, origin, shown};
use super::error::UrdfError;

/// The most joints that move in a chain, dependent ones included.
pub(super) const MOST_SEGMENTS: usize = 16;

/// Position limits of a continuous joint, either way \[rad\]: a thousand turns, where an angle still has twelve digits.
pub(super) const CONTINUOUS: f64 = 2000.0 * PI;

/// Length of an axis below which it has no direction.
const NO_AXIS: f64 = 1e-6;

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
    /// The coordinate that moves it: `multiplier q[leader] + offset`.
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
    kind: JointKind,
    range: (f64, f64),
    velocity: Option<f64>,
    acceleration: Option<f64>,
    jerk: Option<f64>,
    effort: Option<f64>,
    damping: f64,
    friction: f64,
    /// The joint that it follows, with multiplier and offset.
    mimic: Option<(&'a str, f64, f64)>,
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
        let mut bodies: Vec<Body> = Vec::new();
        let mut fixed = Pose::identity();
        for joint in tree.path(base, tip)? {
            fixed *= origin(&joint.element, tree.has_quaternions)?;
            let Some((kind, limited)) = kind(&joint)? else {
                // What is fixed to the base moves nothing.
                if let Some(body) = bodies.last_mut() {
                    *body = body.with_link(tree, joint.child, &fixed)?;
                }
                continue;
            };
            if found.len() == MOST_SEGMENTS {
                let (base, tip) = (shown(base), shown(tip));
                return Err(UrdfError::TooManyJoints { base, tip, limit: MOST_SEGMENTS });
            }
            let to_axis = turn_of_z(axis(&joint)?);
            let child = joint.child;
            found.push(moving(joint, kind, limited, fixed * to_axis)?);
            fixed = Pose::from_parts(Translation3::identity(), to_axis.inverse());
            bodies.push(Body::default().with_link(tree, child, &fixed)?);
        }
        let movers: Vec<usize> = (0..found.len()).filter(|i| found[*i].mimic.is_none()).collect();
        if let Some(asked) = asked.filter(|asked| movers.len() != *asked) {
            let names = movers.iter().map(|i| shown(found[*i].joint.name)).collect();
            return Err(wrong_count(base, tip, names, asked));
        }
        let mut chain = Self {
            movers: movers.iter().map(|i| found[*i].mover()).collect::<Result<_, _>>()?,
            segments: Vec::new(),
            bodies,
            X_tip: fixed,
        };
        for one in &found {
            let (leader, multiplier, offset) = leader(one, &found)?;
            let leader = movers.iter().position(|i| *i == leader).unwrap_or_default();
            if one.mimic.is_some() {
                chain.movers[leader].also_keep(one, multiplier, offset)?;
            }
            chain.segments.push(Segment {
                X_before: one.X_before,
                kind: one.kind,
                leader,
                multiplier,
                offset,
            });
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

/// How a joint moves, and whether between limits; `None` for a fixed joint.
pub(super) fn kind(joint: &Joint<'_, '_>) -> Result<Option<(JointKind, bool)>, UrdfError> {
    let kinds = "type=\"revolute\", \"continuous\", \"prismatic\" or \"fixed\"";
    match joint.element.required_text("type", kinds)? {
        "fixed" => Ok(None),
        "revolute" => Ok(Some((JointKind::Revolute, true))),
        "continuous" => Ok(Some((JointKind::Revolute, false))),
        "prismatic" => Ok(Some((JointKind::Prismatic, true))),
        other => Err(UrdfError::UnsupportedJoint {
            line: joint.element.line(),
            joint: shown(joint.name),
            kind: shown(other),
        }),
    }
}

/// The unit vector of a joint's axis: `<axis>`, by definition x where it is not written.
pub(super) fn axis(joint: &Joint<'_, '_>) -> Result<Vector3<f64>, UrdfError> {
    let Some(axis) = joint.element.child("axis")? else { return Ok(Vector3::x()) };
    axis.only(&["xyz"])?;
    let direction = axis.numbers::<3>("xyz")?.ok_or_else(|| axis.missing("xyz", "xyz=\"0 0 1\""))?;
    let direction = Vector3::from(direction);
    direction.try_normalize(NO_AXIS).ok_or_else(|| axis.bad("xyz", "an axis: it has no direction"))
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

/// Limits and mimicry of a joint that moves.
fn moving<'a, 'i>(
    joint: Joint<'a, 'i>,
    kind: JointKind,
    limited: bool,
    #[allow(non_snake_case)] X_before: Pose,
) -> Result<Found<'a, 'i>, UrdfError> {
    let write = "<limit lower=\"..\" upper=\"..\" velocity=\"..\"/>";
    let element = &joint.element;
    let limit = if limited { Some(element.required("limit", write)?) } else { element.child("limit")? };
    let mimic = element.child("mimic")?.map(|mimic| followed(&mimic)).transpose()?;
    let mut range = (-CONTINUOUS, CONTINUOUS);
    let mut velocity = None;
    let mut acceleration = None;
    let mut jerk = None;
    let mut effort = None;
    if let Some(limit) = limit {
        limit.only(&["lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"])?;
        if limited {
            let lower = limit.number("lower")?.ok_or_else(|| limit.missing("lower", "lower=\"..\""))?;
            let upper = limit.number("upper")?.ok_or_else(|| limit.missing("upper", "upper=\"..\""))?;
            if lower >= upper {
                let line = limit.line();
                return Err(UrdfError::EmptyRange { line, joint: shown(joint.name), lower, upper });
            }
            range = (lower, upper);
        }
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
    Ok(Found { joint, X_before, kind, range, velocity, acceleration, jerk, effort, damping, friction, mimic })
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

/// Which joint a `<mimic>` follows, with multiplier (1 where it is not written) and offset (0 likewise).
fn followed<'a>(mimic: &Element<'a, '_>) -> Result<(&'a str, f64, f64), UrdfError> {
    mimic.only(&["joint", "multiplier", "offset"])?;
    let leader = mimic.required_text("joint", "<mimic joint=\"..\" multiplier=\"1\" offset=\"0\"/>")?;
    Ok((leader, mimic.number("multiplier")?.unwrap_or(1.0), mimic.number("offset")?.unwrap_or(0.0)))
}

/// The joint that moves by itself and moves this one: its index, multiplier, and offset.
fn leader(one: &Found<'_, '_>, all: &[Found<'_, '_>]) -> Result<(usize, f64, f64), UrdfError> {
    let line = one.joint.element.line();
    let joint = shown(one.joint.name);
    let mut at = one;
    let mut multiplier = 1.0;
    let mut offset = 0.0;
    for _ in 0..=all.len() {
        let Some((name, factor, shift)) = at.mimic else {
            let index = all.iter().position(|other| core::ptr::eq(other, at)).unwrap_or_default();
            return Ok((index, multiplier, offset));
        };
        // With the multiplier that there was until now.
        offset += multiplier * shift;
        multiplier *= factor;
        at = all.iter().find(|other| other.joint.name == name).ok_or_else(|| UrdfError::MimicOutside {
            line,
            joint: joint.clone(),
            leader: shown(name),
        })?;
    }
    Err(UrdfError::MimicLoop { line, joint, through: shown(at.joint.name) })
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
            kind: self.kind,
            range: self.range,
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
    /// Narrows the limits to those that keep the limits of a joint that follows.
    fn also_keep(&mut self, one: &Found<'_, '_>, multiplier: f64, offset: f64) -> Result<(), UrdfError> {
        let nothing_left = || UrdfError::MimicLimits {
            line: one.joint.element.line(),
            joint: shown(one.joint.name),
            leader: shown(&self.name),
        };
        let (lower, upper) = one.range;
        if multiplier == 0.0 {
            return if (lower..=upper).contains(&offset) { Ok(()) } else { Err(nothing_left()) };
        }
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
