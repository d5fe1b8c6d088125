//! The shape of a robot, and how its joints move it.

use std::sync::Arc;

use mrroc::pose::Pose;
use mrroc::robot::Robot;
use nalgebra::Vector3;

use super::capsule::Capsule;
use super::chain::Chain;

/// One capsule of a robot: which link it belongs to and what moves it.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// The link's name, for messages.
    pub name: Arc<str>,
    /// Its place in the chain: links whose ranks differ by less than 2 touch at their joint and are not checked against
    /// one another.
    pub rank: u32,
    /// Which of the [`Motion`]s move it: bit `i` for the `i`th.
    pub moved_by: u32,
}

impl Link {
    /// A link that the first `motions` motions move.
    #[must_use]
    pub fn new(name: &str, rank: u32, motions: u32) -> Self {
        Self { name: name.into(), rank, moved_by: Self::first(motions) }
    }

    /// The first `motions` motions, as bits of [`Link::moved_by`].
    #[must_use]
    pub const fn first(motions: u32) -> u32 {
        if motions < 32 { (1 << motions) - 1 } else { u32::MAX }
    }
}

/// How far a joint may move within a stop, and about which axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// A turn about an axis that stands still, or is moved by the motions before it.
    Turn {
        /// A point on the axis \[m\], in the world.
        point: Vector3<f64>,
        /// The axis, of length 1; `None` where only the point is known.
        axis: Option<Vector3<f64>>,
        /// Largest angle, in either direction \[rad\], >= 0.
        bound: f64,
    },
    /// A shift along a line.
    Slide {
        /// Largest shift, in either direction \[m\], >= 0.
        bound: f64,
    },
}

impl Motion {
    /// How far a body in a capsule may get by this motion \[m\], when the motions behind it may have moved it by `moved`.
    ///
    /// A turn by `bound` moves a point at the distance `d` from the axis by at most `bound d`. The distance from an axis is
    /// convex, so no point of the segment is farther from it than the farther end; the radius is added.
    pub(crate) fn travel(&self, capsule: &Capsule, moved: f64) -> f64 {
        match self {
            Motion::Slide { bound } => *bound,
            Motion::Turn { point, axis, bound } => {
                let arm = |end: &Vector3<f64>| match axis {
                    Some(axis) => (end - point).cross(axis).norm_squared(),
                    None => (end - point).norm_squared(),
                };
                let [a, b] = &capsule.ends;
                // The chord of the arc; of a short one there is no need to know it. One that is no number must stay so.
                let chord =
                    if *bound > 0.5 { 2.0 * (0.5 * bound.min(core::f64::consts::PI)).sin() } else { *bound };
                chord * (arm(a).max(arm(b)).sqrt() + capsule.radius + moved)
            }
        }
    }
}

/// A robot as capsules.
///
/// **Example**: a link that turns about the world's z axis, 0.5 m long.
///
/// ```
/// # use mrroc::prelude::*;
/// # use mrroc::robot::{Limits, NoInverse};
/// use mrroc_robots::clearance::{Capsule, Link, Motion, Outline};
/// use mrroc_robots::One;
/// use nalgebra::Vector3;
/// # #[derive(Clone)]
/// # struct Turntable(Limits<One>);
/// # impl Robot for Turntable {
/// #     const KIND: &'static str = "turntable";
/// #     type Joints = One;
/// #     fn limits(&self) -> &Limits<One> { &self.0 }
/// #     fn forward(&self, q: &One) -> Pose { Pose::rotation(Vector3::z() * q[0]) }
/// #     fn inverse(&self, _: &Pose, near: &One) -> Result<One, NoInverse> { Ok(*near) }
/// # }
///
/// impl Outline for Turntable {
///     type Robot = Self;
///
///     fn robot(&self) -> &Self {
///         self
///     }
///
///     fn links(&self) -> Vec<Link> {
///         vec![Link::new("arm", 0, 1)]
///     }
///
///     fn capsules(&self, q: &One, visit: &mut dyn FnMut(Capsule)) {
///         let end = Vector3::new(0.5 * q[0].cos(), 0.5 * q[0].sin(), 0.0);
///         visit(Capsule::new(Vector3::zeros(), end, 0.05));
///     }
///
///     fn motions(&self, _q: &One, distances: &One, visit: &mut dyn FnMut(Motion)) {
///         visit(Motion::Turn { point: Vector3::zeros(), axis: Some(Vector3::z()), bound: distances[0] });
///     }
/// }
/// ```
pub trait Outline: Send + Sync + 'static {
    /// The robot whose shape it is.
    type Robot: Robot;

    /// The robot.
    fn robot(&self) -> &Self::Robot;

    /// The capsules' links, in the order in which [`capsules`](Outline::capsules) visits them.
    fn links(&self) -> Vec<Link>;

    /// Visits the capsules at `q` [rad or m], in the world; fewer than there are links where the robot cannot stand so.
    fn capsules(&self, q: &<Self::Robot as Robot>::Joints, visit: &mut dyn FnMut(Capsule));

    /// The same capsules where they are many and stand still in frames that the joints move: each in its frame, the number of which among those
    /// of [`link_frames`](Outline::link_frames) comes first. Then only those that matter are placed. `None` unless an outline says otherwise.
    fn rigid(&self) -> Option<Vec<(usize, Capsule)>> {
        None
    }

    /// Visits the poses of these frames at `q` [rad or m], in the world; fewer where the robot cannot stand so.
    fn link_frames(&self, _q: &<Self::Robot as Robot>::Joints, _visit: &mut dyn FnMut(&Pose)) {}

    /// Visits the motions that moving every joint from `q` by at most `distances` [rad or m, >= 0] in either direction consists of, from
    /// base to flange; at most 17.
    fn motions(
        &self,
        q: &<Self::Robot as Robot>::Joints,
        distances: &<Self::Robot as Robot>::Joints,
        visit: &mut dyn FnMut(Motion),
    );

    /// Which of the motions move the flange, and what it carries: bit `i` for the `i`th; all unless an outline says otherwise.
    fn flange_motions(&self) -> u32 {
        u32::MAX
    }

    /// The same shape as a serial chain of rigid bodies, if it is one: for kinematics of many postures at once. Its capsules are
    /// those of [`capsules`](Outline::capsules), in that order, up to round-off. `None` unless an outline says otherwise.
    fn chain(&self) -> Option<Chain> {
        None
    }
}
