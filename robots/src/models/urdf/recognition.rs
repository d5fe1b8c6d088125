//! Recognises chains that have a closed form, by their axes where all joints are at 0.

use mrroc::pose::Pose;
use mrroc::robot::JointKind;
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::chain::Segment;
use super::motion::{Axis, at_zero};
use crate::models::opw::OrthoParallel;
use crate::models::planar::Links;
use crate::models::spherical::Spherical;
use crate::models::three_parallel::ThreeParallel;

/// How far axes may be from perpendicular or parallel (cosine, sine) and from meeting \[m\]: round-off.
pub(super) const EXACT: f64 = 1e-12;

/// Length below which a link counts as missing \[m\].
const NO_LINK: f64 = 1e-6;

/// Axes of a chain in which every joint turns by its own coordinate.
#[allow(non_snake_case)]
pub(super) struct Axes {
    axes: Vec<Axis>,
    X_WF: Pose,
    /// How far axes may be from perpendicular or parallel \[rad\] and from meeting \[m\].
    tolerance: f64,
}

impl Axes {
    /// The axes of a chain of joints that all turn, none following another.
    #[allow(non_snake_case)]
    pub(super) fn of(segments: &[Segment], X_tip: &Pose, tolerance: f64) -> Option<Self> {
        let plain = |(i, segment): (usize, &Segment)| {
            segment.kind == JointKind::Revolute
                && segment.leader == i
                && segment.multiplier == 1.0
                && segment.offset == 0.0
        };
        if !segments.iter().enumerate().all(plain) {
            return None;
        }
        let (axes, X_WF) = at_zero(segments, X_tip);
        Some(Self { axes, X_WF, tolerance })
    }

    fn z(&self, i: usize) -> Vector3<f64> {
        self.axes[i].direction
    }

    fn perpendicular(&self, i: usize, j: usize) -> bool {
        self.z(i).dot(&self.z(j)).abs() < self.tolerance
    }

    fn parallel(&self, i: usize, j: usize) -> bool {
        self.z(i).cross(&self.z(j)).norm() < self.tolerance
    }

    /// +1 or -1: how one axis is directed against one that is parallel to it.
    fn sign(&self, i: usize, j: usize) -> f64 {
        self.z(i).dot(&self.z(j)).signum()
    }

    /// The point in which axis `i` meets `j`, perpendicular to it, if it does.
    fn meeting(&self, i: usize, j: usize) -> Option<Vector3<f64>> {
        let point = nearest(&self.axes[i], &self.axes[j].point);
        (off(&self.axes[j], &point) < self.tolerance).then_some(point)
    }

    /// Six joints, ortho-parallel, with a spherical wrist.
    #[allow(non_snake_case)]
    pub(super) fn ortho_parallel(&self) -> Option<OrthoParallel> {
        let axes = &self.axes;
        if axes.len() != 6 {
            return None;
        }
        let ortho_parallel = self.perpendicular(0, 1) && self.parallel(1, 2) && self.perpendicular(2, 3);
        if !ortho_parallel || !self.perpendicular(3, 4) || !self.perpendicular(4, 5) {
            return None;
        }
        let centre = self.meeting(4, 3).filter(|centre| off(&axes[5], centre) < self.tolerance)?;
        let plane = Plane::of(axes);
        let upper = plane.seen(axes[2].point - axes[1].point);
        let fore = plane.seen(centre - axes[2].point);
        let (l, k) = (upper.x.hypot(upper.z), fore.x.hypot(fore.z));
        if l < NO_LINK || k < NO_LINK {
            return None;
        }
        // Turn by turn to the frame of each wrist axis: z along axis 4, y along axis 5, z along axis 6.
        let fourth = plane.seen(self.z(3));
        let o23 = fourth.x.atan2(fourth.z);
        let R_W4 = plane.R_WA * about(Vector3::y_axis(), o23);
        let fifth = R_W4.inverse() * self.z(4);
        let o4 = (-fifth.x).atan2(fifth.y);
        let R_W5 = R_W4 * about(Vector3::z_axis(), o4);
        let sixth = R_W5.inverse() * self.z(5);
        let o5 = sixth.x.atan2(sixth.z);
        let R_WC = R_W5 * about(Vector3::y_axis(), o5);
        let delta = fore.x.atan2(fore.z) - o23;
        Some(OrthoParallel {
            X_WO: plane.X_WO,
            R_CF: R_WC.inverse() * self.X_WF.rotation,
            p_CF: R_WC.inverse() * (self.X_WF.translation.vector - centre),
            a1: plane.seen(axes[1].point - plane.X_WO.translation.vector).x,
            b: plane.seen(centre - plane.X_WO.translation.vector).y,
            l,
            k,
            offsets: [plane.o1, upper.x.atan2(upper.z), o23, o4, o5, 0.0],
            third: self.sign(1, 2),
            delta,
            delta_sin_cos: delta.sin_cos(),
        })
    }

    /// Six joints, the second, third and fourth parallel, the last two axes meeting.
    #[allow(non_snake_case)]
    pub(super) fn three_parallel(&self) -> Option<ThreeParallel> {
        let axes = &self.axes;
        if axes.len() != 6 {
            return None;
        }
        let parallel = self.perpendicular(0, 1) && self.parallel(1, 2) && self.parallel(1, 3);
        if !parallel || !self.perpendicular(3, 4) || !self.perpendicular(4, 5) {
            return None;
        }
        let centre = self.meeting(5, 4)?;
        let plane = Plane::of(axes);
        let upper = plane.seen(axes[2].point - axes[1].point);
        let fore = plane.seen(axes[3].point - axes[2].point);
        let links = Links { l: upper.x.hypot(upper.z), k: fore.x.hypot(fore.z) };
        if links.l < NO_LINK || links.k < NO_LINK {
            return None;
        }
        // Turn by turn to the frame of each wrist axis: z along axis 5, y along axis 6.
        let fifth = plane.seen(self.z(4));
        let o4 = fifth.x.atan2(fifth.z);
        let R_W4 = plane.R_WA * about(Vector3::y_axis(), o4);
        let sixth = R_W4.inverse() * self.z(5);
        let o5 = (-sixth.x).atan2(sixth.y);
        let R_WC = R_W4 * about(Vector3::z_axis(), o5);
        let v = R_W4.inverse() * (centre - axes[3].point);
        Some(ThreeParallel {
            X_WO: plane.X_WO,
            R_CF: R_WC.inverse() * self.X_WF.rotation,
            p_CF: R_WC.inverse() * (self.X_WF.translation.vector - centre),
            a1: plane.seen(axes[1].point - plane.X_WO.translation.vector).x,
            b: plane.seen(centre - plane.X_WO.translation.vector).y,
            links,
            v: (v.x, v.z),
            offsets: [plane.o1, upper.x.atan2(upper.z), fore.x.atan2(fore.z), o4, o5, 0.0],
            signs: (self.sign(1, 2), self.sign(1, 3)),
        })
    }

    /// Seven joints, the first three axes meeting, the last three likewise, and both points level with the elbow.
    #[allow(non_snake_case)]
    pub(super) fn spherical(&self) -> Option<Spherical> {
        let axes = &self.axes;
        if axes.len() != 7
            || ![(0, 1), (1, 2), (4, 5), (5, 6)].iter().all(|(i, j)| self.perpendicular(*i, *j))
        {
            return None;
        }
        let shoulder = self.meeting(1, 0).filter(|point| off(&axes[2], point) < self.tolerance)?;
        let wrist = self.meeting(5, 4).filter(|point| off(&axes[6], point) < self.tolerance)?;
        let elbow = nearest(&axes[3], &shoulder);
        let upper = elbow - shoulder;
        let fore = wrist - elbow;
        let (l, k) = (upper.norm(), fore.norm());
        if (nearest(&axes[3], &wrist) - elbow).norm() > self.tolerance || l < NO_LINK || k < NO_LINK {
            return None;
        }
        // y and z along the axes given, perpendicular to each other, or nearly.
        let along = |y: Vector3<f64>, z: Vector3<f64>| {
            let x = y.cross(&z);
            if self.tolerance == EXACT {
                return Matrix3::from_columns(&[x, y, z]);
            }
            let x = x.normalize();
            Matrix3::from_columns(&[x, y, x.cross(&y)])
        };
        let R_WO = along(self.z(1), self.z(0));
        let third = R_WO.transpose() * self.z(2);
        let o2 = third.x.atan2(third.z);
        let R_WU = along(self.z(1), self.z(2));
        // x along a link, y along axis 4.
        let beside = |link: Vector3<f64>| {
            let y = self.z(3);
            let across = if self.tolerance == EXACT { link } else { link - y * y.dot(&link) };
            let x = across.normalize();
            Matrix3::from_columns(&[x, self.z(3), x.cross(&self.z(3))])
        };
        let R_WA = beside(upper);
        let R_WB = beside(fore);
        let forward = R_WA.transpose() * fore;
        let R_W5 = along(self.z(5), self.z(4));
        let seventh = R_W5.transpose() * self.z(6);
        let o6 = seventh.x.atan2(seventh.z);
        let R_CW = along(self.z(5), self.z(6)).transpose();
        Some(Spherical {
            X_WO: Pose::from_parts(Translation3::from(shoulder), quaternion(R_WO)),
            R_CF: quaternion(R_CW) * self.X_WF.rotation,
            p_CF: R_CW * (self.X_WF.translation.vector - wrist),
            R_UA: R_WU.transpose() * R_WA,
            R_BF: R_WB.transpose() * R_W5,
            l,
            k,
            offsets: [o2, (-forward.z).atan2(forward.x), o6],
        })
    }
}

/// The plane of an arm whose second axis is perpendicular to the first, with all joints at 0.
#[allow(non_snake_case)]
struct Plane {
    /// O, on axis 1, level with axis 2.
    X_WO: Pose,
    /// y along axis 2, z along axis 1.
    R_WA: UnitQuaternion<f64>,
    /// The turn about axis 1 from O to A \[rad\].
    o1: f64,
}

impl Plane {
    #[allow(non_snake_case)]
    fn of(axes: &[Axis]) -> Self {
        let up = axes[0].direction;
        let p_WO = axes[0].point + up * up.dot(&(axes[1].point - axes[0].point));
        // With z up already, O keeps the directions of the world.
        let R_WO = UnitQuaternion::rotation_between(&Vector3::z(), &up)
            .unwrap_or_else(|| about(Vector3::x_axis(), core::f64::consts::PI));
        let second = R_WO.inverse() * axes[1].direction;
        let o1 = (-second.x).atan2(second.y);
        let R_WA = R_WO * about(Vector3::z_axis(), o1);
        Self { X_WO: Pose::from_parts(Translation3::from(p_WO), R_WO), R_WA, o1 }
    }

    fn seen(&self, v: Vector3<f64>) -> Vector3<f64> {
        self.R_WA.inverse() * v
    }
}

fn about(axis: nalgebra::Unit<Vector3<f64>>, angle: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&axis, angle)
}

fn quaternion(matrix: Matrix3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
}

/// The point of `line` nearest to `point`.
fn nearest(line: &Axis, point: &Vector3<f64>) -> Vector3<f64> {
    line.point + line.direction * line.direction.dot(&(point - line.point))
}

/// Distance of a point from an axis \[m\].
fn off(axis: &Axis, point: &Vector3<f64>) -> f64 {
    axis.direction.cross(&(point - axis.point)).norm()
}
