//! The joints from base to tip as a file says them: where they stand, which of them move, and what moves them.
//!
//! In: a tree of links. Out: the joints in their order. A joint that mimics another one does
//!
//! ```text
//! q = multiplier q[leader] + offset
//! ```
//!
//! where the leader may mimic another one itself. With multiplier 0 nothing moves it: it is a fixed joint, which stands at its offset.

use mrroc::pose::Pose;
use mrroc::robot::JointKind;
use nalgebra::Vector3;

use super::document::{Element, Joint, Tree, origin, shown};
use super::error::UrdfError;

/// The most joints that move in a chain, dependent ones included.
pub(super) const MOST_SEGMENTS: usize = 16;

/// Position limits of a continuous joint, in either direction \[rad\]: a thousand turns, where an angle still has twelve digits.
pub(super) const CONTINUOUS: f64 = 2000.0 * core::f64::consts::PI;

/// Length of an axis below which it has no direction.
const NO_AXIS: f64 = 1e-6;

/// A joint between base and tip.
#[allow(non_snake_case)]
pub(super) struct Place<'a, 'i> {
    pub(super) joint: Joint<'a, 'i>,
    /// Pose of its frame in its parent link; of its child, where it is fixed.
    pub(super) X_PJ: Pose,
    /// How it moves; `None` of one that is fixed.
    pub(super) moves: Option<Moves<'a>>,
}

/// How a joint moves.
#[derive(Clone, Copy)]
pub(super) struct Moves<'a> {
    pub(super) kind: JointKind,
    /// Position limits [rad or m].
    pub(super) range: (f64, f64),
    pub(super) follows: Option<Follows<'a>>,
}

/// What a joint follows: the joint `leader`, which moves by itself.
#[derive(Clone, Copy)]
pub(super) struct Follows<'a> {
    pub(super) leader: &'a str,
    /// Not 0, unless nothing is followed.
    pub(super) multiplier: f64,
    /// [rad or m].
    pub(super) offset: f64,
}

/// The joints from link `base` to link `tip`, in that order.
///
/// # Errors
/// See [`UrdfError`].
pub(super) fn places<'a, 'i>(
    tree: &Tree<'a, 'i>,
    base: &str,
    tip: &str,
) -> Result<Vec<Place<'a, 'i>>, UrdfError> {
    let mut places = Vec::new();
    let mut count = 0;
    #[allow(non_snake_case)]
    for joint in tree.path(base, tip)? {
        let X_PJ = origin(&joint.element, tree.has_quaternions)?;
        let moves = moves(&joint)?;
        count += usize::from(moves.is_some());
        if count > MOST_SEGMENTS {
            return Err(UrdfError::TooManyJoints {
                base: shown(base),
                tip: shown(tip),
                limit: MOST_SEGMENTS,
            });
        }
        places.push(Place { joint, X_PJ, moves });
    }
    let moving = places.iter().filter_map(|place| Some((place.joint.name, place.moves?.follows)));
    let all: Vec<_> = moving.collect();
    for Place { joint, X_PJ, moves } in &mut places {
        let Some(of) = moves else { continue };
        let Some(follows) = through(joint, &all)? else { continue };
        of.follows = Some(follows);
        if follows.multiplier != 0.0 {
            continue;
        }
        let (lower, upper) = of.range;
        let Follows { offset, .. } = follows;
        if !(lower..=upper).contains(&offset) {
            let (line, joint) = (joint.element.line(), shown(joint.name));
            return Err(UrdfError::MimicStands { line, joint, offset, lower, upper });
        }
        *X_PJ *= displaced(of.kind, axis(joint)? * offset);
        *moves = None;
    }
    Ok(places)
}

/// A displacement along or about an axis.
pub(super) fn displaced(kind: JointKind, by: Vector3<f64>) -> Pose {
    match kind {
        JointKind::Revolute => Pose::rotation(by),
        JointKind::Prismatic => Pose::translation(by.x, by.y, by.z),
    }
}

/// What a joint follows, through those that follow another one themselves; `None` of one that moves by itself. `all` are those that
/// move, each with what it names. With multiplier 0 it does not matter what is named beyond that.
fn through<'a>(
    joint: &Joint<'a, '_>,
    all: &[(&'a str, Option<Follows<'a>>)],
) -> Result<Option<Follows<'a>>, UrdfError> {
    let line = joint.element.line();
    let mut so_far = Follows { leader: joint.name, multiplier: 1.0, offset: 0.0 };
    for passed in 0..=all.len() {
        let named = all.iter().find(|(name, _)| *name == so_far.leader);
        let (_, follows) = named.ok_or_else(|| UrdfError::MimicOutside {
            line,
            joint: shown(joint.name),
            leader: shown(so_far.leader),
        })?;
        let Some(next) = follows else { return Ok((passed > 0).then_some(so_far)) };
        // With the multiplier that there was until now.
        so_far.offset += so_far.multiplier * next.offset;
        so_far.multiplier *= next.multiplier;
        so_far.leader = next.leader;
        if so_far.multiplier == 0.0 {
            return Ok(Some(so_far));
        }
    }
    Err(UrdfError::MimicLoop { line, joint: shown(joint.name), through: shown(so_far.leader) })
}

/// How a joint moves, and which joint it names in `<mimic>`; `None` of a fixed joint.
pub(super) fn moves<'a>(joint: &Joint<'a, '_>) -> Result<Option<Moves<'a>>, UrdfError> {
    let kinds = "type=\"revolute\", \"continuous\", \"prismatic\" or \"fixed\"";
    let (kind, is_limited) = match joint.element.required_text("type", kinds)? {
        "fixed" => return Ok(None),
        "revolute" => (JointKind::Revolute, true),
        "continuous" => (JointKind::Revolute, false),
        "prismatic" => (JointKind::Prismatic, true),
        other => {
            return Err(UrdfError::UnsupportedJoint {
                line: joint.element.line(),
                joint: shown(joint.name),
                kind: shown(other),
            });
        }
    };
    if let Some(limit) = joint.element.child("limit")? {
        limit.only(&["lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"])?;
    }
    let follows = joint.element.child("mimic")?.map(|mimic| followed(&mimic)).transpose()?;
    let range = if is_limited { range(joint)? } else { (-CONTINUOUS, CONTINUOUS) };
    Ok(Some(Moves { kind, range, follows }))
}

/// The unit vector of a joint's axis: `<axis>`, by definition x where it is not written.
pub(super) fn axis(joint: &Joint<'_, '_>) -> Result<Vector3<f64>, UrdfError> {
    let Some(axis) = joint.element.child("axis")? else { return Ok(Vector3::x()) };
    axis.only(&["xyz"])?;
    let direction = axis.numbers::<3>("xyz")?.ok_or_else(|| axis.missing("xyz", "xyz=\"0 0 1\""))?;
    let direction = Vector3::from(direction);
    direction.try_normalize(NO_AXIS).ok_or_else(|| axis.bad("xyz", "an axis: it has no direction"))
}

/// The position limits of a joint that has some.
fn range(joint: &Joint<'_, '_>) -> Result<(f64, f64), UrdfError> {
    let limit = joint.element.required("limit", "<limit lower=\"..\" upper=\"..\" velocity=\"..\"/>")?;
    let lower = limit.number("lower")?.ok_or_else(|| limit.missing("lower", "lower=\"..\""))?;
    let upper = limit.number("upper")?.ok_or_else(|| limit.missing("upper", "upper=\"..\""))?;
    if lower >= upper {
        let line = limit.line();
        return Err(UrdfError::EmptyRange { line, joint: shown(joint.name), lower, upper });
    }
    Ok((lower, upper))
}

/// What a `<mimic>` names, with multiplier (1 where it is not written) and offset (0 likewise).
fn followed<'a>(mimic: &Element<'a, '_>) -> Result<Follows<'a>, UrdfError> {
    mimic.only(&["joint", "multiplier", "offset"])?;
    let leader = mimic.required_text("joint", "<mimic joint=\"..\" multiplier=\"1\" offset=\"0\"/>")?;
    let multiplier = mimic.number("multiplier")?.unwrap_or(1.0);
    Ok(Follows { leader, multiplier, offset: mimic.number("offset")?.unwrap_or(0.0) })
}
