//! A joint and the body that it moves.

use mrroc::pose::Pose;
use mrroc::robot::{JointKind, Load};
use nalgebra::{Translation3, Vector3};

/// A joint of a [`Tree`](super::Tree) with the body that it moves.
///
/// Its frame J turns or slides with the body. At position 0 it stands at `X_PJ` in the frame of the segment before, or in the
/// base.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Segment {
    /// Its name, one for each segment of a tree.
    pub name: String,
    /// The segment that carries it, which stands before it in the tree; `None`: the base.
    pub parent: Option<usize>,
    /// Pose of J in the frame of the parent, or in the base, where the joint stands at 0 \[m\].
    pub X_PJ: Pose,
    /// About or along its axis.
    pub kind: JointKind,
    /// The joint's axis in J, of length 1.
    pub axis: Vector3<f64>,
    /// The coordinate that moves it: the joint stands at `multiplier q[coordinate] + offset`.
    pub coordinate: usize,
    /// By how much it moves with its coordinate: 1 for a joint that moves by itself.
    pub multiplier: f64,
    /// Where it stands with its coordinate at 0 [rad or m].
    pub offset: f64,
    /// The body: mass \[kg\], centre of mass in J \[m\], inertia about the centre in the axes of J [kg m²].
    pub body: Load,
}

impl Segment {
    /// A joint about `axis`, of length 1, with a coordinate of its own; J is `at` in the frame of the segment before, whose axes
    /// it has where it stands at 0. Its body has no mass.
    #[must_use]
    pub fn turning(
        name: &str,
        parent: Option<usize>,
        coordinate: usize,
        at: Vector3<f64>,
        axis: Vector3<f64>,
    ) -> Self {
        Self {
            name: name.to_owned(),
            parent,
            X_PJ: Pose::from_parts(Translation3::from(at), nalgebra::UnitQuaternion::identity()),
            kind: JointKind::Revolute,
            axis,
            coordinate,
            multiplier: 1.0,
            offset: 0.0,
            body: Load::NONE,
        }
    }

    /// The same along `axis`.
    #[must_use]
    pub fn sliding(
        name: &str,
        parent: Option<usize>,
        coordinate: usize,
        at: Vector3<f64>,
        axis: Vector3<f64>,
    ) -> Self {
        Self { kind: JointKind::Prismatic, ..Self::turning(name, parent, coordinate, at, axis) }
    }

    /// The same joint, following its coordinate by a multiplier.
    #[must_use]
    pub fn following(self, multiplier: f64) -> Self {
        Self { multiplier, ..self }
    }

    /// The same joint with a body.
    #[must_use]
    pub fn carrying(self, body: Load) -> Self {
        Self { body, ..self }
    }
}
