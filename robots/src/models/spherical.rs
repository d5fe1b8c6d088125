//! Arms of seven revolute joints with a spherical shoulder and a spherical wrist, in closed form.
//!
//! The first three axes meet in S and the last three in W, each perpendicular to the one before; the elbow's axis has the
//! same nearest point E to both. So are the KUKA LBR iiwa, and the Barrett WAM with its offset elbow.
//!
//! ```text
//! R_OU = R_z(theta1) R_y(theta2) R_z(theta3)          U: upper arm; A: U turned to x along S E, y along axis 4
//! R_OB = R_OU R_UA R_y(theta4)                        B: x along E W, y along axis 4
//! R_OC = R_OB R_BF R_z(theta5) R_y(theta6) R_z(theta7)
//! p_SW = l x_A + k x_B = d w                          d^2 = l^2 + k^2 + 2 l k cos theta4
//! ```
//!
//! The pose gives W, and its distance d from S gives theta4. One freedom is left, the turn of the elbow about the line S W.
//! It is measured by the **arm angle** psi of axis 4 (whose direction n is perpendicular to S W):
//!
//! ```text
//! n = cos(psi) e1 + sin(psi) e2,    e1 = z x w / |z x w|,  e2 = w x e1        z: along axis 1
//! ```
//!
//! so at 0 the elbow lies in the plane through axis 1 and W, which is upright for an arm on the floor. After Shimizu et
//! al.: *Analytical inverse kinematic computation for 7-DOF redundant manipulators with joint limits and its application
//! to redundancy resolution* (IEEE T-RO 2008), with axis 4 in the place of the elbow's position, because the axis has a
//! direction when the arm is stretched, too. S W and n place the upper arm and the forearm; their Euler angles
//! are the other joints.

use core::f64::consts::PI;

use mrroc::pose::Pose;
use mrroc::robot::NoInverse;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::models::kinematics::closest;
use crate::models::planar::{
    CENTRE_SINGULAR, Direction, NEAR, ROUND_OFF, STRETCH, WRIST_SINGULAR, Wanted, distinct,
};
use crate::models::sines::{atan2, sin_cos};

/// Joint positions \[rad\].
pub(crate) type Joints = [f64; 7];

/// If all joints together are off by less than this \[rad²\], axis 4 is turned by less than a right angle: no joint turns it by
/// more than it turns itself, and three do.
const SAME_SIDE: f64 = PI * PI / 12.0 - ROUND_OFF;

/// Round-off of an entry of a rotation matrix that was multiplied from others.
const ROUND_OFF_OF_COLUMN: f64 = 2e-15;

/// A seven-axis arm with a spherical shoulder and a spherical wrist.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)]
pub(crate) struct Spherical {
    /// Pose of O in the world: the origin in S, z along axis 1, y along axis 2 where joint 1 is at 0.
    pub(crate) X_WO: Pose,
    /// Rotation of the flange in the wrist's frame C where all angles are 0.
    pub(crate) R_CF: UnitQuaternion<f64>,
    /// The flange's origin in the wrist's frame C \[m\].
    pub(crate) p_CF: Vector3<f64>,
    /// Rotation of A in U, and of the forearm's frame, z along axis 5, in B.
    pub(crate) R_UA: Matrix3<f64>,
    pub(crate) R_BF: Matrix3<f64>,
    /// Distances of E from S and of W from E \[m\], > 0.
    pub(crate) l: f64,
    pub(crate) k: f64,
    /// From `q2`, `q4`, `q6` to theta2, theta4, theta6 \[rad\]; of the other joints it is 0.
    pub(crate) offsets: [f64; 3],
}

/// The line S W and axis 4.
#[derive(Clone, Copy)]
struct Posture {
    /// From S to W \[m\].
    centre: Vector3<f64>,
    /// Distance of W from S, and from axis 1 \[m\].
    distance: f64,
    beside: f64,
    /// Direction of axis 4.
    normal: Vector3<f64>,
}

/// An upper arm or a wrist: three angles, of which the first two are one of two pairs unless `singular`.
struct Turned {
    angles: [Direction; 3],
    singular: bool,
}

impl Spherical {
    /// The arm angle \[rad\] at `q` \[rad\], -pi to pi. Where W lies on axis 1, it is measured from axis 2 at joint 1 = 0.
    pub(crate) fn arm_angle(&self, q: &Joints) -> f64 {
        let at = self.posture(q).0;
        let [e1, e2] = basis(&at.centre, at.distance, at.beside);
        at.normal.dot(&e2).atan2(at.normal.dot(&e1))
    }

    /// The joint positions \[rad\] that put the flange at `X_WF` at the arm angle of `near` or half a turn from it: of the up
    /// to sixteen the ones nearest to `near`, by the sum of the squares of the differences, every joint within pi of it.
    ///
    /// Where W lies on axis 1, now or in `near`, the arm angle is not determined: axis 4 then stays as it is in `near` as
    /// nearly as it can. Where theta1 or theta5 is undetermined (theta2 or theta6 is 0) it stays as in `near`.
    ///
    /// # Errors
    /// [`NoInverse::OutOfReach`].
    #[inline]
    #[allow(non_snake_case)]
    pub(crate) fn inverse(&self, X_WF: &Pose, near: &Joints) -> Result<Joints, NoInverse> {
        let wanted = Wanted::of(X_WF, &self.X_WO, &self.R_CF, &self.p_CF);
        let (at, theta4) = self.posture(near);
        let [one, other] = self.elbows(&wanted, theta4)?;
        let normal = kept(&wanted, &at);
        let found = self.nearest(&wanted, &normal, one, near);
        // cos x >= 1 - x^2/2: an angle whose cosine is less than this is alone off by more than all of `found`.
        if found.1 < SAME_SIDE && other.along(theta4) < 1.0 - 0.5 * found.1 - ROUND_OFF {
            return Ok(found.0);
        }
        let rest = [(normal, other), (-normal, one), (-normal, other)];
        Ok(self.nearest_of(&wanted, rest, near, found))
    }

    /// As [`Spherical::inverse`], at this arm angle \[rad\].
    #[allow(non_snake_case)]
    pub(crate) fn inverse_at(&self, X_WF: &Pose, psi: f64, near: &Joints) -> Result<Joints, NoInverse> {
        let wanted = Wanted::of(X_WF, &self.X_WO, &self.R_CF, &self.p_CF);
        let (_, theta4) = self.posture(near);
        let [one, other] = self.elbows(&wanted, theta4)?;
        let Direction { sine, cosine } = Direction::of(psi);
        let centre = &wanted.centre;
        let [e1, e2] = basis(centre, centre.norm(), centre.x.hypot(centre.y));
        let normal = e1 * cosine + e2 * sine;
        let found = self.nearest(&wanted, &normal, one, near);
        let found = self.nearest_of(&wanted, [(normal, other)], near, found);
        let finite = found.iter().all(|q| q.is_finite());
        if finite { Ok(found) } else { Err(self.out_of_reach(f64::NAN)) }
    }

    /// Calls `visit` with every solution at the arm angle of `near`, and half a turn from it, once: at most sixteen, every
    /// joint within pi of `near`.
    ///
    /// # Errors
    /// As [`Spherical::inverse`].
    #[allow(non_snake_case)]
    pub(crate) fn solutions(
        &self,
        X_WF: &Pose,
        near: &Joints,
        mut visit: impl FnMut(&Joints),
    ) -> Result<(), NoInverse> {
        let wanted = Wanted::of(X_WF, &self.X_WO, &self.R_CF, &self.p_CF);
        let (at, theta4) = self.posture(near);
        let elbows = self.elbows(&wanted, theta4)?;
        let normal = kept(&wanted, &at);
        let mut none = true;
        for normal in [normal, -normal] {
            for elbow in &elbows[..if elbows[0] == elbows[1] { 1 } else { 2 }] {
                let (q4, arms, wrists) = self.joints(&wanted, &normal, *elbow, near);
                for arm in distinct(&arms) {
                    for wrist in distinct(&wrists) {
                        let q = with(q4, arm, wrist);
                        if q.iter().all(|q| q.is_finite()) {
                            visit(&q);
                            none = false;
                        }
                    }
                }
            }
        }
        if none { Err(self.out_of_reach(f64::NAN)) } else { Ok(()) }
    }

    /// The singularity that `q` \[rad\] lies near, if any: of the arm, or of the arm angle.
    pub(crate) fn near_singularity(&self, q: &Joints) -> Option<&'static str> {
        let [o2, o4, o6] = self.offsets;
        if (q[5] + o6).sin().abs() < NEAR {
            Some("near the wrist singularity")
        } else if (q[1] + o2).sin().abs() < NEAR || self.posture(q).0.beside < NEAR * (self.l + self.k) {
            Some("near the shoulder singularity")
        } else if (q[3] + o4).sin().abs() < NEAR {
            Some("near the elbow singularity")
        } else {
            None
        }
    }

    /// S W and axis 4 at `q`, and theta4.
    #[inline(always)]
    fn posture(&self, q: &Joints) -> (Posture, Direction) {
        let [o2, o4, _] = self.offsets;
        let [(s1, c1), (s2, c2), (s3, c3), (s4, c4)] = sin_cos([q[0], q[1] + o2, q[2], q[3] + o4]);
        let in_o = |v: Vector3<f64>| {
            let (x, y) = (c3 * v.x - s3 * v.y, s3 * v.x + c3 * v.y);
            let (x, z) = (c2 * x + s2 * v.z, c2 * v.z - s2 * x);
            Vector3::new(c1 * x - s1 * y, s1 * x + c1 * y, z)
        };
        let centre = in_o(self.R_UA * Vector3::new(self.l + self.k * c4, 0.0, -self.k * s4));
        let normal = in_o(self.R_UA.column(1).into_owned());
        let beside = (centre.x * centre.x + centre.y * centre.y).sqrt();
        let posture = Posture { centre, distance: centre.norm(), beside, normal };
        (posture, Direction { sine: s4, cosine: c4 })
    }

    /// Both angles of the elbow, the one nearer to `at` first.
    #[inline(always)]
    fn elbows(&self, wanted: &Wanted, at: Direction) -> Result<[Direction; 2], NoInverse> {
        let Self { l, k, .. } = *self;
        let square = wanted.centre.norm_squared();
        let d = square.sqrt();
        // Heron: 16 times the square of the area between upper arm, forearm and their span.
        let heron = (l + k - d) * (l + k + d) * (d - l + k) * (d + l - k);
        if heron.is_nan() || heron < -STRETCH * (l + k).powi(4) {
            return Err(self.out_of_reach(d));
        }
        let inverse = 0.5 / (l * k);
        let sine = (heron.max(0.0).sqrt() * inverse).copysign(at.sine);
        let cosine = (square - l * l - k * k) * inverse;
        Ok([Direction { sine, cosine }, Direction { sine: -sine, cosine }])
    }

    /// The joint of the elbow, and both solutions of the arm before and of the wrist after it.
    #[inline(always)]
    fn joints(
        &self,
        wanted: &Wanted,
        normal: &Vector3<f64>,
        theta4: Direction,
        near: &Joints,
    ) -> (f64, [[f64; 3]; 2], [[f64; 3]; 2]) {
        let [o2, o4, o6] = self.offsets;
        let [first, fifth] = sin_cos([near[0], near[4]]).map(|(sine, cosine)| Direction { sine, cosine });
        let d = wanted.centre.norm();
        // The angle of S E before S W; with W on S the elbow is folded.
        let (sa, ca, w) = if d < CENTRE_SINGULAR {
            (1.0, 0.0, any_across(normal))
        } else {
            let inverse = 1.0 / d;
            (
                self.k * theta4.sine * inverse,
                (self.l + self.k * theta4.cosine) * inverse,
                wanted.centre * inverse,
            )
        };
        let m = w.cross(normal);
        let (sb, cb) = (theta4.sine * ca - theta4.cosine * sa, theta4.cosine * ca + theta4.sine * sa);
        let upper = Matrix3::from_columns(&[w * ca + m * sa, *normal, m * ca - w * sa]);
        let fore = Matrix3::from_columns(&[w * cb - m * sb, *normal, w * sb + m * cb]);
        let upper = upper * self.R_UA.transpose();
        let fore = (fore * self.R_BF).transpose();
        let of = |i: usize| upper.column(i).into_owned();
        let arm = turned([of(0), of(1), of(2)], first);
        let [x, y, z] = &wanted.columns;
        let wrist = turned([fore * x, fore * y, fore * z], fifth);
        let [a, b, c] = arm.angles;
        let [e, f, g] = wrist.angles;
        let [a, b, c, theta4, e, f, g] = atan2(
            [a.sine, b.sine, c.sine, theta4.sine, e.sine, f.sine, g.sine],
            [a.cosine, b.cosine, c.cosine, theta4.cosine, e.cosine, f.cosine, g.cosine],
        );
        let both = |first: usize, [a, b, c]: [f64; 3], offset: f64, singular: bool| {
            let near = |a: f64, b: f64, c: f64| {
                [closest(a, near[first]), closest(b - offset, near[first + 1]), closest(c, near[first + 2])]
            };
            let one = near(a, b, c);
            [one, if singular { one } else { near(a + PI, -b, c + PI) }]
        };
        let arms = both(0, [a, b, c], o2, arm.singular);
        let wrists = both(4, [e, f, g], o6, wrist.singular);
        (closest(theta4 - o4, near[3]), arms, wrists)
    }

    /// The nearest of the up to four solutions for one axis 4 and one elbow, and the sum of the squares by which it is off.
    #[inline(always)]
    fn nearest(
        &self,
        wanted: &Wanted,
        normal: &Vector3<f64>,
        theta4: Direction,
        near: &Joints,
    ) -> (Joints, f64) {
        let (q4, arms, wrists) = self.joints(wanted, normal, theta4, near);
        let (arm, off_arm) = nearer(&arms, [near[0], near[1], near[2]]);
        let (wrist, off_wrist) = nearer(&wrists, [near[4], near[5], near[6]]);
        let off = (q4 - near[3]) * (q4 - near[3]);
        (with(q4, arm, wrist), off + off_arm + off_wrist)
    }

    /// The nearest of `found` and the solutions for each axis 4 and elbow.
    #[cold]
    fn nearest_of<const M: usize>(
        &self,
        wanted: &Wanted,
        rest: [(Vector3<f64>, Direction); M],
        near: &Joints,
        found: (Joints, f64),
    ) -> Joints {
        let mut best = found;
        for (normal, theta4) in &rest {
            let found = self.nearest(wanted, normal, *theta4, near);
            if found.1 < best.1 {
                best = found;
            }
        }
        best.0
    }

    /// The error for a wrist that cannot be put so far from the shoulder.
    #[cold]
    fn out_of_reach(&self, distance: f64) -> NoInverse {
        NoInverse::OutOfReach { distance, min: (self.l - self.k).abs(), max: self.l + self.k }
    }
}

/// The directions from which the arm angle is measured, for W so far from S and from axis 1.
#[inline(always)]
fn basis(centre: &Vector3<f64>, distance: f64, beside: f64) -> [Vector3<f64>; 2] {
    if beside < CENTRE_SINGULAR {
        return [Vector3::y(), Vector3::x() * (-1.0_f64).copysign(centre.z)];
    }
    let inverse = 1.0 / beside;
    let (x, y) = (centre.x * inverse, centre.y * inverse);
    let along = 1.0 / distance;
    let (up, level) = (centre.z * along, beside * along);
    [Vector3::new(-y, x, 0.0), Vector3::new(-up * x, -up * y, level)]
}

/// Axis 4 at the arm angle of `at`, or half a turn from it: on the side where it was.
#[inline(always)]
fn kept(wanted: &Wanted, at: &Posture) -> Vector3<f64> {
    let centre = &wanted.centre;
    let distance = centre.norm();
    let beside = (centre.x * centre.x + centre.y * centre.y).sqrt();
    if beside.min(at.beside) < CENTRE_SINGULAR {
        return across(&at.normal, centre, distance);
    }
    let [e1, e2] = basis(&at.centre, at.distance, at.beside);
    let (cosine, sine) = (at.normal.dot(&e1), at.normal.dot(&e2));
    let [e1, e2] = basis(centre, distance, beside);
    let normal = e1 * cosine + e2 * sine;
    if normal.dot(&at.normal) < 0.0 { -normal } else { normal }
}

/// The direction across S W that is nearest to `normal`.
#[cold]
fn across(normal: &Vector3<f64>, centre: &Vector3<f64>, distance: f64) -> Vector3<f64> {
    if distance < CENTRE_SINGULAR {
        return *normal;
    }
    let w = centre / distance;
    (normal - w * w.dot(normal)).try_normalize(1e-6).unwrap_or_else(|| any_across(&w))
}

/// Some direction perpendicular to a unit vector.
#[cold]
fn any_across(v: &Vector3<f64>) -> Vector3<f64> {
    let least = if v.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    v.cross(&least).normalize()
}

/// The angles of `R_z R_y R_z` whose columns these are, with the middle sine >= 0; where it is 0, the first is `at`.
///
/// The arm as a whole is not singular there, because its elbow can yield: also beside it, where round-off makes the first
/// angle uncertain, it is `at` if it may be.
#[inline(always)]
fn turned([x, y, z]: [Vector3<f64>; 3], at: Direction) -> Turned {
    let across = (z.x * z.x + z.y * z.y).sqrt();
    let singular = across < WRIST_SINGULAR;
    let first = if singular {
        at
    } else if (z.y * at.cosine - z.x * at.sine).abs() < ROUND_OFF_OF_COLUMN {
        if z.x * at.cosine + z.y * at.sine < 0.0 { at.reversed() } else { at }
    } else {
        let inverse = 1.0 / across;
        Direction { sine: z.y * inverse, cosine: z.x * inverse }
    };
    let (s, c) = (first.sine, first.cosine);
    let second = Direction { sine: c * z.x + s * z.y, cosine: z.z };
    let third = Direction { sine: c * x.y - s * x.x, cosine: c * y.y - s * y.x };
    Turned { angles: [first, second, third], singular }
}

/// The nearer of two solutions, and the sum of the squares by which it is off.
#[inline(always)]
fn nearer([a, b]: &[[f64; 3]; 2], near: [f64; 3]) -> (&[f64; 3], f64) {
    let off = |q: &[f64; 3]| {
        let square = |i: usize| (q[i] - near[i]) * (q[i] - near[i]);
        square(0) + square(1) + square(2)
    };
    let (off_a, off_b) = (off(a), off(b));
    if off_b < off_a { (b, off_b) } else { (a, off_a) }
}

#[inline(always)]
fn with(q4: f64, arm: &[f64; 3], wrist: &[f64; 3]) -> Joints {
    [arm[0], arm[1], arm[2], q4, wrist[0], wrist[1], wrist[2]]
}
