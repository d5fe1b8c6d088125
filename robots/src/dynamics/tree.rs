//! An open tree of rigid bodies on a fixed base.

use mrroc::pose::Pose;
use mrroc::robot::{JointKind, Load};
use nalgebra::{Matrix3, Vector3};

use super::segment::Segment;

/// An open tree of rigid bodies with `N` coordinates, on a fixed base.
///
/// ```
/// use mrroc::pose::Pose;
/// use mrroc::robot::Load;
/// use mrroc_robots::dynamics::{Segment, Tree};
/// use nalgebra::{SVector, Vector3};
///
/// // A pendulum of 2 kg on a rod of 0.5 m, level at q = 0; positive motion raises it.
/// let rod = Segment::turning("rod", None, 0, Vector3::zeros(), -Vector3::y());
/// let bob = rod.carrying(Load::point(2.0, Vector3::x() * 0.5));
/// let pendulum = Tree::<1>::new(Pose::identity(), vec![bob], Pose::identity())?;
/// let rest = SVector::zeros();
/// let holding = pendulum.inverse_dynamics(&rest, &rest, &rest, None)[0];
/// assert!((holding - 2.0 * 9.80665 * 0.5).abs() < 1e-12);
/// # Ok::<(), mrroc_robots::dynamics::TreeError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Tree<const N: usize> {
    pub(super) X_WB: Pose,
    pub(super) segments: Vec<Segment>,
    pub(super) X_tip: Pose,
    /// [m/s²], in the world.
    pub(super) gravity: Vector3<f64>,
    pub(super) stages: Vec<Stage>,
}

/// A segment, ready to be computed with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stage {
    /// Index of the segment before; its own index where there is none.
    pub(super) parent: usize,
    pub(super) is_root: bool,
    pub(super) turned: Matrix3<f64>,
    pub(super) moved: Vector3<f64>,
    pub(super) kind: JointKind,
    pub(super) axis: Vector3<f64>,
    pub(super) coordinate: usize,
    pub(super) multiplier: f64,
    pub(super) offset: f64,
    pub(super) mass: f64,
    pub(super) centre: Vector3<f64>,
    pub(super) inertia: Matrix3<f64>,
}

/// What is wrong with a tree.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TreeError {
    /// It has no segment, or too many.
    #[error("a tree of {count} segments: it has 1 to {limit}")]
    Size {
        /// How many it has.
        count: usize,
        /// How many it may have.
        limit: usize,
    },
    /// Its segment is carried by one that does not stand before it.
    #[error("segment `{segment}` does not stand after the one that carries it")]
    Order {
        /// The segment's name.
        segment: String,
    },
    /// Its segment follows a coordinate that there is not.
    #[error("segment `{segment}` follows coordinate {coordinate}, of {count}")]
    Coordinate {
        /// The segment's name.
        segment: String,
        /// The coordinate, from 0.
        coordinate: usize,
        /// How many there are.
        count: usize,
    },
    /// The length of a joint's axis is not 1.
    #[error("the axis of segment `{segment}` has length {length}, not 1")]
    Axis {
        /// The segment's name.
        segment: String,
        /// The axis' length.
        length: f64,
    },
    /// A mass is negative, or a number is none.
    #[error("segment `{segment}` has a negative mass, or a number that is none")]
    Body {
        /// The segment's name.
        segment: String,
    },
}

impl<const N: usize> Tree<N> {
    /// The most segments of a tree.
    pub const MOST: usize = 16;

    /// The tree of these segments on a base at `X_WB` in the world, with gravity of 9.80665 m/s² along -z of the world. The
    /// tip, at `X_tip` in the frame of the last segment, is where wrenches act.
    ///
    /// # Errors
    /// [`TreeError`].
    #[allow(non_snake_case)]
    pub fn new(X_WB: Pose, segments: Vec<Segment>, X_tip: Pose) -> Result<Self, TreeError> {
        let count = segments.len();
        if count == 0 || count > Self::MOST {
            return Err(TreeError::Size { count, limit: Self::MOST });
        }
        for (i, one) in segments.iter().enumerate() {
            let segment = || one.name.clone();
            let length = one.axis.norm();
            if one.parent.is_some_and(|parent| parent >= i) {
                return Err(TreeError::Order { segment: segment() });
            }
            if one.coordinate >= N {
                let coordinate = one.coordinate;
                return Err(TreeError::Coordinate { segment: segment(), coordinate, count: N });
            }
            if length.is_nan() || (length - 1.0).abs() > 1e-12 {
                return Err(TreeError::Axis { segment: segment(), length });
            }
            let body = &one.body;
            let mut numbers =
                body.centre.iter().chain(body.inertia.iter()).chain([&one.multiplier, &one.offset]);
            if !(body.mass.is_finite() && body.mass >= 0.0 && numbers.all(|x| x.is_finite())) {
                return Err(TreeError::Body { segment: segment() });
            }
        }
        let gravity = Vector3::new(0.0, 0.0, -9.80665);
        let mut tree = Self { X_WB, segments, X_tip, gravity, stages: Vec::new() };
        tree.stages = tree.segments.iter().enumerate().map(|(i, segment)| tree.stage(i, segment)).collect();
        Ok(tree)
    }

    /// The same tree in another field of gravity [m/s²], along the axes of the world.
    #[must_use]
    pub fn with_gravity(self, gravity: Vector3<f64>) -> Self {
        Self { gravity, ..self }
    }

    /// The same tree with a load on its tip: mass, centre and inertia in the tip's frame. What it carried there before stays.
    #[must_use]
    pub fn with_load(mut self, load: &Load) -> Self {
        if let (Some(last), Some(stage)) = (self.segments.last_mut(), self.stages.last_mut()) {
            last.body = joined(&last.body, &moved(load, &self.X_tip));
            (stage.mass, stage.centre, stage.inertia) = (last.body.mass, last.body.centre, last.body.inertia);
        }
        self
    }

    fn stage(&self, i: usize, segment: &Segment) -> Stage {
        let turned = segment.X_PJ.rotation.to_rotation_matrix().into_inner();
        let moved = segment.X_PJ.translation.vector;
        // What stands on the base is told along the axes of the world.
        let base = match segment.parent {
            None => self.X_WB.rotation.to_rotation_matrix().into_inner(),
            Some(_) => Matrix3::identity(),
        };
        Stage {
            parent: segment.parent.unwrap_or(i),
            is_root: segment.parent.is_none(),
            turned: base * turned,
            moved: base * moved,
            kind: segment.kind,
            axis: segment.axis,
            coordinate: segment.coordinate,
            multiplier: segment.multiplier,
            offset: segment.offset,
            mass: segment.body.mass,
            centre: segment.body.centre,
            inertia: segment.body.inertia,
        }
    }

    /// The segments, from the base to the tip.
    #[must_use]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Pose of the base in the world.
    #[must_use]
    pub fn base(&self) -> &Pose {
        &self.X_WB
    }

    /// Pose of the tip in the frame of the last segment.
    #[must_use]
    pub fn tip(&self) -> &Pose {
        &self.X_tip
    }

    /// Mass of all bodies \[kg\].
    #[must_use]
    pub fn mass(&self) -> f64 {
        self.stages.iter().map(|stage| stage.mass).sum()
    }
}

/// A body as seen in a frame in which its own stands at `pose`.
pub(super) fn moved(body: &Load, pose: &Pose) -> Load {
    let turned = pose.rotation.to_rotation_matrix().into_inner();
    Load {
        mass: body.mass,
        centre: turned * body.centre + pose.translation.vector,
        inertia: turned * body.inertia * turned.transpose(),
    }
}

/// Two bodies as one.
pub(super) fn joined(a: &Load, b: &Load) -> Load {
    let mass = a.mass + b.mass;
    if mass == 0.0 {
        return Load { inertia: a.inertia + b.inertia, ..*a };
    }
    let centre = (a.centre * a.mass + b.centre * b.mass) / mass;
    let about = |body: &Load| body.inertia + steiner(body.mass, &(body.centre - centre));
    Load { mass, centre, inertia: about(a) + about(b) }
}

/// Inertia of a point of this mass at `r` about the origin [kg m²].
pub(super) fn steiner(mass: f64, r: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * (mass * r.norm_squared()) - r * r.transpose() * mass
}
