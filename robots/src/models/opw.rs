//! Arms of six revolute joints with an ortho-parallel base and a spherical wrist, in closed form.
//!
//! After Brandstötter, Angerer, Hofbaur: *An analytical solution of the inverse kinematics problem of industrial
//! serial manipulators with an ortho-parallel basis and a spherical wrist* (Austrian Robotics Workshop 2014):
//! the first axis is perpendicular to the second, the second parallel to the third, the third perpendicular to the
//! fourth; the last three meet in the wrist centre C, each perpendicular to the one before.
//!
//! ```text
//!            z_O ^      o----k----o C        in the plane of the arm, which stands b beside axis 1:
//!                |   l /              l: upper arm, phi2 from the vertical
//!                |    /               k: forearm from axis 3 to C, phi3 from the vertical
//!                o===o  a1
//!                O  axis 2
//! R_OC = R_z(theta1) R_y(theta23) R_z(theta4) R_y(theta5) R_z(theta6)
//! p_OC = R_z(theta1) (a1 + l sin phi2 + k sin phi3, b, l cos phi2 + k cos phi3)
//! theta1 = q1 + o1, phi2 = q2 + o2, theta23 = q2 +- q3 + o23, phi3 = theta23 + delta, theta4 = q4 + o4 ..
//! ```
//!
//! The lengths of the paper: `l = c2`, `k = hypot(a2, c3)`; `c1` lies in the pose of O, `c4` in that of the flange.
//! Unlike the paper, the elbow is solved without arc cosines (the arm may be stretched) and theta6 follows from the
//! theta4 that was found, so that on the wrist singularity, where theta4 is not determined, the pose stays exact.

use core::f64::consts::PI;

use mrroc::pose::Pose;
use mrroc::robot::NoInverse;
use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::models::kinematics::{closest, doubled};
use crate::models::planar::{
    self, Direction, Elbow, Links, NEAR, ROUND_OFF, Shoulder, WRIST_SINGULAR, Wanted, distinct, nearer_first,
};
use crate::models::sines::{atan2, sin_cos};

/// Joint positions \[rad\].
pub(crate) type Joints = [f64; 6];

/// An ortho-parallel arm with a spherical wrist.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)]
pub(crate) struct OrthoParallel {
    /// Pose of O in the world: z along axis 1, the origin level with axis 2.
    pub(crate) X_WO: Pose,
    /// Rotation of the flange in the wrist's frame C where all angles are 0.
    pub(crate) R_CF: UnitQuaternion<f64>,
    /// The flange's origin in the wrist's frame C \[m\].
    pub(crate) p_CF: Vector3<f64>,
    /// Distance of axis 2 from axis 1 \[m\], of either sign.
    pub(crate) a1: f64,
    /// How far C stands beside the plane through axis 1 perpendicular to axis 2 \[m\], of either sign.
    pub(crate) b: f64,
    /// Distance of axis 3 from axis 2 \[m\], > 0.
    pub(crate) l: f64,
    /// Distance of C from axis 3 \[m\], > 0.
    pub(crate) k: f64,
    /// From `q1` to `theta1`, `q2` to `phi2`, `q2 +- q3` to `theta23`, and `q4`, `q5`, `q6` to theta4, theta5, theta6 \[rad\].
    pub(crate) offsets: [f64; 6],
    /// +1 or -1: how axis 3 is directed against axis 2.
    pub(crate) third: f64,
    /// From `theta23` to `phi3` \[rad\].
    pub(crate) delta: f64,
    /// Sine and cosine of `delta`.
    pub(crate) delta_sin_cos: (f64, f64),
}

impl OrthoParallel {
    /// Pose of the flange at `q` \[rad\].
    #[inline]
    #[allow(non_snake_case)]
    pub(crate) fn forward(&self, q: &Joints) -> Pose {
        let [o1, o2, o23, o4, o5, o6] = self.offsets;
        let theta23 = q[1] + self.third * q[2] + o23;
        let theta4 = q[3] + o4;
        let theta6 = q[5] + o6;
        let [h1, h23, h5, plus, minus, (s2, c2)] = sin_cos([
            0.5 * (q[0] + o1),
            0.5 * theta23,
            0.5 * (q[4] + o5),
            0.5 * (theta4 + theta6),
            0.5 * (theta4 - theta6),
            q[1] + o2,
        ]);
        let ((s1, c1), (s23, c23)) = (doubled(h1), doubled(h23));
        let (sine, cosine) = self.delta_sin_cos;
        let s3 = s23 * cosine + c23 * sine;
        let c3 = c23 * cosine - s23 * sine;
        let forward = self.a1 + self.l * s2 + self.k * s3;
        let centre =
            Vector3::new(forward * c1 - self.b * s1, forward * s1 + self.b * c1, self.l * c2 + self.k * c3);
        // R_z(theta1) R_y(theta23), then R_z(theta4) R_y(theta5) R_z(theta6).
        let arm = Quaternion::new(h1.1 * h23.1, -h1.0 * h23.0, h1.1 * h23.0, h1.0 * h23.1);
        let wrist = Quaternion::new(h5.1 * plus.1, -h5.0 * minus.0, h5.0 * minus.1, h5.1 * plus.0);
        let R_OC = UnitQuaternion::new_unchecked(arm * wrist);
        let position = self.X_WO * nalgebra::Point3::from(centre + R_OC * self.p_CF);
        let rotation = self.X_WO.rotation * (R_OC * self.R_CF);
        Pose::from_parts(Translation3::from(position.coords), rotation)
    }

    /// The joint positions \[rad\] that put the flange at `X_WF`: of all solutions the one nearest to `near`, by the sum
    /// of the squares of the differences, every joint within pi of `near`.
    ///
    /// Where a joint is undetermined (theta1 with the wrist centre on axis 1, theta4 where axes 4 and 6 are one line,
    /// the upper arm where the wrist centre lies on axis 2) it stays as in `near`.
    ///
    /// # Errors
    /// [`NoInverse::OutOfReach`].
    #[inline]
    #[allow(non_snake_case)]
    pub(crate) fn inverse(&self, X_WF: &Pose, near: &Joints) -> Result<Joints, NoInverse> {
        let wanted = self.wanted(X_WF);
        let [(s1, c1), (s2, c2)] = sin_cos([near[0] + self.offsets[0], near[1] + self.offsets[1]]);
        let at1 = Direction { sine: s1, cosine: c1 };
        let at2 = Direction { sine: s2, cosine: c2 };
        let shoulders =
            self.shoulders(&wanted.centre, at1).ok_or_else(|| self.out_of_reach(&wanted.centre))?;
        let (shoulder, other_shoulder) = nearer_first(shoulders, |shoulder| shoulder.theta1.along(at1));
        if let Some(elbows) = self.elbows(&shoulder, wanted.centre.z, at2) {
            let (elbow, other_elbow) = nearer_first(elbows, |elbow| elbow.phi2.along(at2));
            let (found, off) = nearest(self.joints(&wanted, &shoulder, &elbow, near), near);
            // cos x >= 1 - x^2/2: an angle whose cosine is less than this is alone off by more than all of `found`.
            let bound = 1.0 - 0.5 * off - ROUND_OFF;
            if other_shoulder.theta1.along(at1) < bound && other_elbow.phi2.along(at2) < bound {
                return Ok(found);
            }
        }
        self.nearest_of_all(&wanted, shoulders, at2, near)
    }

    /// The nearest solution, all of them computed.
    #[cold]
    fn nearest_of_all(
        &self,
        wanted: &Wanted,
        shoulders: [Shoulder; 2],
        at2: Direction,
        near: &Joints,
    ) -> Result<Joints, NoInverse> {
        let mut best = (*near, f64::INFINITY);
        for shoulder in shoulders {
            for elbow in self.elbows(&shoulder, wanted.centre.z, at2).into_iter().flatten() {
                let found = nearest(self.joints(wanted, &shoulder, &elbow, near), near);
                if found.1 < best.1 {
                    best = found;
                }
            }
        }
        if best.1 < f64::INFINITY { Ok(best.0) } else { Err(self.out_of_reach(&wanted.centre)) }
    }

    /// Calls `visit` with every solution once, at most eight, every joint within pi of `near`.
    ///
    /// # Errors
    /// As [`OrthoParallel::inverse`].
    #[allow(non_snake_case)]
    pub(crate) fn solutions(
        &self,
        X_WF: &Pose,
        near: &Joints,
        mut visit: impl FnMut(&Joints),
    ) -> Result<(), NoInverse> {
        let wanted = self.wanted(X_WF);
        let refused = || self.out_of_reach(&wanted.centre);
        let at1 = Direction::of(near[0] + self.offsets[0]);
        let at2 = Direction::of(near[1] + self.offsets[1]);
        let mut none = true;
        for shoulder in distinct(&self.shoulders(&wanted.centre, at1).ok_or_else(refused)?) {
            let Some(elbows) = self.elbows(shoulder, wanted.centre.z, at2) else { continue };
            for elbow in distinct(&elbows) {
                for joints in distinct(&self.joints(&wanted, shoulder, elbow, near)) {
                    if joints.iter().all(|q| q.is_finite()) {
                        visit(joints);
                        none = false;
                    }
                }
            }
        }
        if none { Err(refused()) } else { Ok(()) }
    }

    /// The singularity that `q` \[rad\] lies near, if any.
    pub(crate) fn near_singularity(&self, q: &Joints) -> Option<&'static str> {
        let [_, o2, o23, _, o5, _] = self.offsets;
        let phi2 = q[1] + o2;
        let phi3 = q[1] + self.third * q[2] + o23 + self.delta;
        let forward = self.a1 + self.l * phi2.sin() + self.k * phi3.sin();
        if (q[4] + o5).sin().abs() < NEAR {
            Some("near the wrist singularity")
        } else if forward.abs() < NEAR * (self.l + self.k) {
            Some("near the shoulder singularity")
        } else if (phi3 - phi2).sin().abs() < NEAR {
            Some("near the elbow singularity")
        } else {
            None
        }
    }

    #[inline(always)]
    #[allow(non_snake_case)]
    fn wanted(&self, X_WF: &Pose) -> Wanted {
        Wanted::of(X_WF, &self.X_WO, &self.R_CF, &self.p_CF)
    }

    /// Both positions of the first joint, which is undetermined on axis 1 and then stays at `at`.
    #[inline(always)]
    fn shoulders(&self, centre: &Vector3<f64>, at: Direction) -> Option<[Shoulder; 2]> {
        planar::shoulders(centre, self.b, self.l + self.k, at)
    }

    /// Both positions of the upper arm and the forearm.
    #[inline(always)]
    fn elbows(&self, shoulder: &Shoulder, height: f64, at: Direction) -> Option<[Elbow; 2]> {
        planar::elbows(Links { l: self.l, k: self.k }, shoulder.forward - self.a1, height, at)
    }

    /// Both solutions for one position of shoulder and elbow, which differ in the wrist; on its singularity, where
    /// theta4 is undetermined and stays as in `near`, they are the same.
    #[inline(always)]
    fn joints(&self, wanted: &Wanted, shoulder: &Shoulder, elbow: &Elbow, near: &Joints) -> [Joints; 2] {
        let [o1, o2, o23, o4, o5, o6] = self.offsets;
        let theta1 = shoulder.theta1;
        let phi3 = elbow.phi3;
        let (sine, cosine) = self.delta_sin_cos;
        let s23 = phi3.sine * cosine - phi3.cosine * sine;
        let c23 = phi3.cosine * cosine + phi3.sine * sine;
        // Columns of R_z(theta4) R_y(theta5) R_z(theta6).
        let [x, y, z] = &wanted.columns;
        let forward = |v: &Vector3<f64>| theta1.cosine * v.x + theta1.sine * v.y;
        let aside = |v: &Vector3<f64>| theta1.cosine * v.y - theta1.sine * v.x;
        let first = |v: &Vector3<f64>| c23 * forward(v) - s23 * v.z;
        let z0 = first(z);
        let z1 = aside(z);
        let z2 = s23 * forward(z) + c23 * z.z;
        let across = (z0 * z0 + z1 * z1).sqrt();
        let singular = across < WRIST_SINGULAR;
        let theta4 = if singular {
            Direction::of(near[3] + o4)
        } else {
            let inverse = 1.0 / across;
            Direction { sine: z1 * inverse, cosine: z0 * inverse }
        };
        let (s4, c4) = (theta4.sine, theta4.cosine);
        let [q1, phi2, phi3, theta4, theta5, theta6] = atan2(
            [theta1.sine, elbow.phi2.sine, phi3.sine, s4, c4 * z0 + s4 * z1, c4 * aside(x) - s4 * first(x)],
            [theta1.cosine, elbow.phi2.cosine, phi3.cosine, c4, z2, c4 * aside(y) - s4 * first(y)],
        );
        let q2 = phi2 - o2;
        let q3 = self.third * (phi3 - self.delta - o23 - q2);
        let q4 = theta4 - o4;
        let q5 = theta5 - o5;
        let q6 = theta6 - o6;
        let arm = [closest(q1 - o1, near[0]), closest(q2, near[1]), closest(q3, near[2])];
        let with = |q4, q5, q6| {
            let wrist = [closest(q4, near[3]), closest(q5, near[4]), closest(q6, near[5])];
            [arm[0], arm[1], arm[2], wrist[0], wrist[1], wrist[2]]
        };
        let found = with(q4, q5, q6);
        [found, if singular { found } else { with(q4 + PI, -theta5 - o5, q6 + PI) }]
    }

    /// The error for a wrist centre that cannot be reached.
    #[cold]
    fn out_of_reach(&self, centre: &Vector3<f64>) -> NoInverse {
        let radius = centre.x.hypot(centre.y);
        if radius < self.b.abs() {
            let max = self.l + self.k + self.a1.abs();
            return NoInverse::OutOfReach { distance: radius, min: self.b.abs(), max };
        }
        let forward = ((radius - self.b) * (radius + self.b)).sqrt();
        let distance = (forward - self.a1).hypot(centre.z);
        NoInverse::OutOfReach { distance, min: (self.l - self.k).abs(), max: self.l + self.k }
    }
}

/// The nearer of two solutions, and the sum of the squares by which it is off \[rad²\].
#[inline(always)]
fn nearest([a, b]: [Joints; 2], near: &Joints) -> (Joints, f64) {
    let off = |q: &Joints| {
        let square = |i: usize| (q[i] - near[i]) * (q[i] - near[i]);
        square(0) + square(1) + square(2) + square(3) + square(4) + square(5)
    };
    let off_a = off(&a);
    let off_b = off(&b);
    if off_b < off_a { (b, off_b) } else { (a, off_a) }
}
