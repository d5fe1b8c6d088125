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

use mrroc::{NoInverse, Pose};
use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::sines::{atan2, closest, sin_cos};

/// Distance of the wrist centre from axis 1, or from axis 2, below which these joints are undetermined \[m\].
const CENTRE_SINGULAR: f64 = 1e-9;

/// Sine of theta5 below which theta4 is undetermined; the pose then errs by no more than this \[rad\].
const WRIST_SINGULAR: f64 = 1e-10;

/// How far beyond its reach an arm may be asked to stretch, as a part of its length: round-off.
const STRETCH: f64 = 1e-13;

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
    /// `q1` to `theta1`, `q2` to `phi2`, `q2 +- q3` to `theta23`, `q4`, `q5`, `q6` to theta4 .. theta6 \[rad\].
    pub(crate) offsets: [f64; 6],
    /// +1 or -1: how axis 3 is directed against axis 2.
    pub(crate) third: f64,
    /// `theta23` to `phi3` \[rad\]..
    pub(crate) delta: f64,
    /// .. and its sine and cosine.
    pub(crate) delta_sin_cos: (f64, f64),
}

/// One position of the first three joints that puts the wrist centre in place.
#[derive(Clone, Copy)]
struct Elbow {
    q: [f64; 3],
    /// Sine and cosine of theta23.
    arm: (f64, f64),
}

/// What is asked of the arm, in O.
struct Wanted {
    /// The wrist centre \[m\].
    centre: Vector3<f64>,
    /// The columns of the rotation matrix of C.
    columns: [Vector3<f64>; 3],
}

impl OrthoParallel {
    /// Pose of the flange at `q` \[rad\].
    #[inline]
    #[allow(non_snake_case)]
    pub(crate) fn forward(&self, q: &Joints) -> Pose {
        let [o1, o2, o23, o4, o5, o6] = self.offsets;
        let theta23 = q[1] + self.third * q[2] + o23;
        let (theta4, theta6) = (q[3] + o4, q[5] + o6);
        let (s, c) = sin_cos([
            0.5 * (q[0] + o1),
            0.5 * theta23,
            0.5 * (q[4] + o5),
            0.5 * (theta4 + theta6),
            0.5 * (theta4 - theta6),
            q[1] + o2,
        ]);
        let (s1, c1) = doubled(s[0], c[0]);
        let (s23, c23) = doubled(s[1], c[1]);
        let (sine, cosine) = self.delta_sin_cos;
        let (s3, c3) = (s23 * cosine + c23 * sine, c23 * cosine - s23 * sine);
        let forward = self.a1 + self.l * s[5] + self.k * s3;
        let centre =
            Vector3::new(forward * c1 - self.b * s1, forward * s1 + self.b * c1, self.l * c[5] + self.k * c3);
        // R_z(theta1) R_y(theta23), then R_z(theta4) R_y(theta5) R_z(theta6).
        let arm = Quaternion::new(c[0] * c[1], -s[0] * s[1], c[0] * s[1], s[0] * c[1]);
        let wrist = Quaternion::new(c[2] * c[3], -s[2] * s[4], s[2] * c[4], c[2] * s[3]);
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
        let (shoulders, radius) = self.shoulders(&wanted.centre, near)?;
        let turn = |shoulder: &Shoulder| square(shoulder.q1 - near[0]);
        let nearer_first = usize::from(turn(&shoulders[1]) < turn(&shoulders[0]));
        let mut best = (f64::INFINITY, *near);
        for shoulder in [&shoulders[nearer_first], &shoulders[1 - nearer_first]] {
            // What the first joint alone is off by is never made good: branches that cannot win are left out.
            if turn(shoulder) >= best.0 {
                continue;
            }
            let Some(elbows) = self.elbows(shoulder, wanted.centre.z, near) else { continue };
            let bend = |elbow: &Elbow| (0..3).map(|i| square(elbow.q[i] - near[i])).sum::<f64>();
            let nearer_first = usize::from(bend(&elbows[1]) < bend(&elbows[0]));
            for elbow in [&elbows[nearer_first], &elbows[1 - nearer_first]] {
                let off = bend(elbow);
                if off >= best.0 {
                    break;
                }
                let (wrists, _) = self.wrists(&wanted, shoulder, elbow, near);
                for wrist in wrists {
                    let off = off + (0..3).map(|i| square(wrist[i] - near[i + 3])).sum::<f64>();
                    if off < best.0 {
                        best = (off, joined(elbow, &wrist));
                    }
                }
            }
        }
        if best.0 < f64::INFINITY { Ok(best.1) } else { Err(self.out_of_reach(radius, wanted.centre.z)) }
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
        let (shoulders, radius) = self.shoulders(&wanted.centre, near)?;
        let mut none = true;
        let both = if shoulders[0].q1 == shoulders[1].q1 { 1 } else { 2 };
        for shoulder in &shoulders[..both] {
            let Some(elbows) = self.elbows(shoulder, wanted.centre.z, near) else { continue };
            let both = if elbows[0].q == elbows[1].q { 1 } else { 2 };
            for elbow in &elbows[..both] {
                let (wrists, count) = self.wrists(&wanted, shoulder, elbow, near);
                for wrist in &wrists[..count] {
                    let joints = joined(elbow, wrist);
                    if joints.iter().all(|q| q.is_finite()) {
                        visit(&joints);
                        none = false;
                    }
                }
            }
        }
        if none { Err(self.out_of_reach(radius, wanted.centre.z)) } else { Ok(()) }
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

    /// The pose of the wrist's frame that puts the flange at `X_WF`, in O.
    #[inline(always)]
    #[allow(non_snake_case)]
    fn wanted(&self, X_WF: &Pose) -> Wanted {
        let R_OW = self.X_WO.rotation.inverse();
        let R_OC = R_OW * X_WF.rotation * self.R_CF.inverse();
        let p_OF = R_OW * (X_WF.translation.vector - self.X_WO.translation.vector);
        let matrix = R_OC.to_rotation_matrix().into_inner();
        let columns = [0, 1, 2].map(|i| Vector3::new(matrix[(0, i)], matrix[(1, i)], matrix[(2, i)]));
        Wanted { centre: p_OF - matrix * self.p_CF, columns }
    }

    /// Both positions of the first joint, and the distance of the wrist centre from axis 1.
    #[inline(always)]
    fn shoulders(&self, centre: &Vector3<f64>, near: &Joints) -> Result<([Shoulder; 2], f64), NoInverse> {
        let (x, y, b, o1) = (centre.x, centre.y, self.b, self.offsets[0]);
        let square = x * x + y * y;
        let radius = square.sqrt();
        let under_root = (radius - b.abs()) * (radius + b.abs());
        if under_root.is_nan() || under_root < -STRETCH * self.l * b.abs() {
            return Err(NoInverse::OutOfReach {
                distance: radius,
                min: b.abs(),
                max: self.l + self.k + self.a1.abs(),
            });
        }
        if radius < CENTRE_SINGULAR {
            // On axis 1: every position serves, so the first joint stays.
            let ([s1], [c1]) = sin_cos([near[0] + o1]);
            let shoulder = Shoulder { q1: near[0], sine: s1, cosine: c1, forward: x * c1 + y * s1 };
            return Ok(([shoulder; 2], radius));
        }
        let root = under_root.max(0.0).sqrt();
        let inverse = 1.0 / square;
        let of = |forward: f64| ((forward * y - b * x) * inverse, (forward * x + b * y) * inverse);
        let (front, back) = (of(root), of(-root));
        let theta = atan2([front.0, back.0], [front.1, back.1]);
        let shoulder = |i: usize, (sine, cosine): (f64, f64), forward: f64| Shoulder {
            q1: closest(theta[i] - o1, near[0]),
            sine,
            cosine,
            forward,
        };
        Ok(([shoulder(0, front, root), shoulder(1, back, -root)], radius))
    }

    /// Both positions of the upper arm and the forearm; `None` out of reach.
    #[inline(always)]
    fn elbows(&self, shoulder: &Shoulder, height: f64, near: &Joints) -> Option<[Elbow; 2]> {
        let Self { l, k, a1, third, .. } = *self;
        let [_, o2, o23, ..] = self.offsets;
        let across = shoulder.forward - a1;
        let square = across * across + height * height;
        let distance = square.sqrt();
        // Heron: 16 times the square of the area between upper arm, forearm and their span.
        let heron = (l + k - distance) * (l + k + distance) * (distance - l + k) * (distance + l - k);
        if heron.is_nan() || heron < -STRETCH * (l + k).powi(2) * (l * k).max(square) {
            return None;
        }
        let upper = if distance < CENTRE_SINGULAR {
            // The forearm lies on the upper arm: every position serves, so the upper arm stays.
            let ([s2], [c2]) = sin_cos([near[1] + o2]);
            [(s2, c2); 2]
        } else {
            let (along, root) = (0.5 * (square + (l - k) * (l + k)) / l, 0.5 * heron.max(0.0).sqrt() / l);
            let inverse = 1.0 / square;
            [root, -root].map(|root| {
                ((along * across - root * height) * inverse, (along * height + root * across) * inverse)
            })
        };
        let inverse = 1.0 / k;
        let fore = upper.map(|(s2, c2)| ((across - l * s2) * inverse, (height - l * c2) * inverse));
        let phi = atan2(
            [upper[0].0, upper[1].0, fore[0].0, fore[1].0],
            [upper[0].1, upper[1].1, fore[0].1, fore[1].1],
        );
        let (sine, cosine) = self.delta_sin_cos;
        Some([0, 1].map(|i| {
            let (s3, c3) = fore[i];
            let q2 = phi[i] - o2;
            let q3 = third * (phi[i + 2] - self.delta - o23 - q2);
            Elbow {
                q: [shoulder.q1, closest(q2, near[1]), closest(q3, near[2])],
                arm: (s3 * cosine - c3 * sine, c3 * cosine + s3 * sine),
            }
        }))
    }

    /// Both positions of the wrist, and how many of them differ.
    #[inline(always)]
    fn wrists(
        &self,
        wanted: &Wanted,
        shoulder: &Shoulder,
        elbow: &Elbow,
        near: &Joints,
    ) -> ([[f64; 3]; 2], usize) {
        let [.., o4, o5, o6] = self.offsets;
        let (s1, c1) = (shoulder.sine, shoulder.cosine);
        let (s23, c23) = elbow.arm;
        // Columns of R_z(theta4) R_y(theta5) R_z(theta6).
        let [x, y, z] = wanted.columns.map(|v| {
            let (forward, aside) = (c1 * v.x + s1 * v.y, c1 * v.y - s1 * v.x);
            [c23 * forward - s23 * v.z, aside, s23 * forward + c23 * v.z]
        });
        let sine = (z[0] * z[0] + z[1] * z[1]).sqrt();
        let singular = sine < WRIST_SINGULAR;
        let (s4, c4) = if singular {
            let ([s4], [c4]) = sin_cos([near[3] + o4]);
            (s4, c4)
        } else {
            (z[1] / sine, z[0] / sine)
        };
        let theta = atan2(
            [s4, c4 * z[0] + s4 * z[1], c4 * x[1] - s4 * x[0], 0.0],
            [c4, z[2], c4 * y[1] - s4 * y[0], 1.0],
        );
        let of = |theta4: f64, theta5: f64, theta6: f64| {
            [closest(theta4 - o4, near[3]), closest(theta5 - o5, near[4]), closest(theta6 - o6, near[5])]
        };
        let first = of(theta[0], theta[1], theta[2]);
        if singular { ([first; 2], 1) } else { ([first, of(theta[0] + PI, -theta[1], theta[2] + PI)], 2) }
    }

    /// The error for a wrist centre at this distance from axis 1 and this height above axis 2 \[m\].
    #[cold]
    fn out_of_reach(&self, radius: f64, height: f64) -> NoInverse {
        let forward = ((radius - self.b) * (radius + self.b)).max(0.0).sqrt();
        let distance = (forward - self.a1).hypot(height);
        NoInverse::OutOfReach { distance, min: (self.l - self.k).abs(), max: self.l + self.k }
    }
}

/// Sine of an angle, or part of the arm's length, below which a singularity counts as near.
const NEAR: f64 = 0.1;

/// One position of the first joint.
#[derive(Clone, Copy)]
struct Shoulder {
    q1: f64,
    sine: f64,
    cosine: f64,
    /// How far the wrist centre lies in front of axis 1 in the plane of the arm \[m\], of either sign.
    forward: f64,
}

fn joined(elbow: &Elbow, wrist: &[f64; 3]) -> Joints {
    [elbow.q[0], elbow.q[1], elbow.q[2], wrist[0], wrist[1], wrist[2]]
}

fn square(x: f64) -> f64 {
    x * x
}

/// Sine and cosine of an angle from those of its half.
fn doubled(sine: f64, cosine: f64) -> (f64, f64) {
    (2.0 * sine * cosine, (cosine - sine) * (cosine + sine))
}
