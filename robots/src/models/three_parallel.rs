//! Arms of six revolute joints, the second, third and fourth parallel, in closed form: the arms of Universal Robots, and
//! most others that are called collaborative.
//!
//! The first axis is perpendicular to the second, the fourth to the fifth, the fifth to the sixth, and the last two meet
//! in C. After Hawkins: *Analytic inverse kinematics for the Universal Robots UR-5/UR-10 arms* (Georgia Tech, 2013), with
//! axis 2 beside axis 1 and axis 5 beside axis 4 where they are.
//!
//! ```text
//!            z_O ^      o---k---o axis 4        in the plane of the arm; C stands b beside it
//!                |   l /        |  v            l, k: upper arm and forearm, phi2 and phi3 from the vertical
//!                |    /         o  axis 5, C    v: from axis 4 to C, turned by theta234
//!                o===o  a1
//!                O  axis 2
//! R_OC = R_z(theta1) R_y(theta234) R_z(theta5) R_y(theta6)
//! p_OC = R_z(theta1) ((a1 + l sin phi2 + k sin phi3, b, l cos phi2 + k cos phi3) + R_y(theta234) v)
//! theta1 = q1 + o1, phi2 = q2 + o2, phi3 = q2 +- q3 + o3, theta234 = q2 +- q3 +- q4 + o4, theta5 = q5 + o5 ..
//! ```
//!
//! theta1 puts C as far beside the plane as it must be. In the plane's frame the middle row of the rotation of C is
//! `(s5 c6, c5, s5 s6)`, which gives theta5 and theta6, and its last column before theta6 `(s234, 0, c234)`. Two links
//! are left. theta234 and theta5 follow from the theta6 that was found: on the wrist's singularity (axis 6 parallel to
//! axis 4), where theta6 is not determined and stays as it was, the pose stays exact.

use mrroc::pose::Pose;
use mrroc::robot::NoInverse;
use nalgebra::{UnitQuaternion, Vector3};

use crate::models::kinematics::closest;
use crate::models::planar::{
    Direction, Elbow, Links, NEAR, ROUND_OFF, Shoulder, WRIST_SINGULAR, Wanted, distinct, elbows,
    nearer_first, shoulders,
};
use crate::models::sines::{atan2, sin_cos};

/// Joint positions \[rad\].
type Joints = [f64; 6];

/// An arm with three parallel axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)]
pub(crate) struct ThreeParallel {
    /// Pose of O in the world: z along axis 1, the origin level with axis 2.
    pub(crate) X_WO: Pose,
    /// Rotation of the flange in the wrist's frame C (y along axis 6) where all angles are 0.
    pub(crate) R_CF: UnitQuaternion<f64>,
    /// The flange's origin in the wrist's frame C \[m\].
    pub(crate) p_CF: Vector3<f64>,
    /// Distance of axis 2 from axis 1 \[m\], of either sign.
    pub(crate) a1: f64,
    /// How far C stands beside the plane through axis 1 perpendicular to axis 2 \[m\], of either sign.
    pub(crate) b: f64,
    /// From axis 2 to axis 3, and from there to axis 4.
    pub(crate) links: Links,
    /// From axis 4 to C in the plane of the arm where theta234 is 0: forwards and up \[m\].
    pub(crate) v: (f64, f64),
    /// From the joints to the angles, in their order \[rad\].
    pub(crate) offsets: [f64; 6],
    /// +1 or -1: how axes 3 and 4 are directed against axis 2.
    pub(crate) signs: (f64, f64),
}

/// One position of the wrist.
#[derive(Clone, Copy, PartialEq)]
struct Wrist {
    theta234: Direction,
    theta5: Direction,
    theta6: Direction,
}

/// What the seed says of the joints that may be undetermined.
struct Seed {
    theta1: Direction,
    phi2: Direction,
    theta6: Direction,
}

impl Seed {
    #[inline(always)]
    fn of(near: &Joints, offsets: &Joints) -> Self {
        let [first, second, sixth] =
            sin_cos([near[0] + offsets[0], near[1] + offsets[1], near[5] + offsets[5]])
                .map(|(sine, cosine)| Direction { sine, cosine });
        Self { theta1: first, phi2: second, theta6: sixth }
    }
}

impl ThreeParallel {
    /// The joint positions \[rad\] that put the flange at `X_WF`: of all solutions the one nearest to `near`, by the sum
    /// of the squares of the differences, every joint within pi of `near`.
    ///
    /// Where a joint is undetermined (theta1 with C on axis 1, theta6 where axes 4 and 6 are parallel, the upper arm with
    /// axis 4 on axis 2) it stays as in `near`. Where an arm that is nearly stretched or folded cannot follow on its branch, it
    /// is not sent to another one, which would be a jump of half a turn.
    ///
    /// # Errors
    /// [`NoInverse::OutOfReach`].
    #[inline]
    #[allow(non_snake_case)]
    pub(crate) fn inverse(&self, X_WF: &Pose, near: &Joints) -> Result<Joints, NoInverse> {
        let wanted = Wanted::of(X_WF, &self.X_WO, &self.R_CF, &self.p_CF);
        let seed = Seed::of(near, &self.offsets);
        let both = self.shoulders(&wanted, &seed).ok_or_else(|| self.out_of_reach(&wanted, &seed))?;
        let (shoulder, other_shoulder) = nearer_first(both, |shoulder| shoulder.theta1.along(seed.theta1));
        let (wrist, other_wrist) =
            nearer_first(wrists(&wanted, &shoulder, &seed), |wrist| wrist.theta6.along(seed.theta6));
        if let Some(both) = self.elbows(&wanted, &shoulder, &wrist, &seed) {
            let (elbow, other_elbow) = nearer_first(both, |elbow| elbow.phi2.along(seed.phi2));
            let found = self.joints(&shoulder, &wrist, &elbow, near);
            // cos x >= 1 - x^2/2: an angle whose cosine is less than this is alone off by more than all of `found`.
            let bound = 1.0 - 0.5 * off(&found, near) - ROUND_OFF;
            if other_shoulder.theta1.along(seed.theta1) < bound
                && other_wrist.theta6.along(seed.theta6) < bound
                && other_elbow.phi2.along(seed.phi2) < bound
            {
                return Ok(found);
            }
        } else if self.was_there(&shoulder, &wrist, &seed, near) {
            let (across, height) = self.fourth(&wanted, &shoulder, &wrist);
            return Err(self.beyond(across.hypot(height)));
        }
        self.nearest_of_all(&wanted, both, &seed, near)
    }

    /// Whether the seed was on this branch already, at the end of it: with the arm nearly stretched or folded.
    #[cold]
    fn was_there(&self, shoulder: &Shoulder, wrist: &Wrist, seed: &Seed, near: &Joints) -> bool {
        let [_, o2, o3, ..] = self.offsets;
        let bend = self.signs.0 * near[2] + o3 - o2;
        let close = |cosine: f64| cosine > 1.0 - 0.5 * NEAR * NEAR;
        bend.sin().abs() < NEAR
            && close(shoulder.theta1.along(seed.theta1))
            && close(wrist.theta6.along(seed.theta6))
    }

    /// The nearest solution, all of them computed.
    #[cold]
    fn nearest_of_all(
        &self,
        wanted: &Wanted,
        shoulders: [Shoulder; 2],
        seed: &Seed,
        near: &Joints,
    ) -> Result<Joints, NoInverse> {
        let mut best = (*near, f64::INFINITY);
        self.each(wanted, &shoulders, seed, near, |found| {
            let off = off(found, near);
            if off < best.1 {
                best = (*found, off);
            }
        });
        if best.1 < f64::INFINITY { Ok(best.0) } else { Err(self.out_of_reach(wanted, seed)) }
    }

    /// Calls `visit` with every solution once, at most eight, every joint within pi of `near`.
    ///
    /// # Errors
    /// As [`ThreeParallel::inverse`].
    #[allow(non_snake_case)]
    pub(crate) fn solutions(
        &self,
        X_WF: &Pose,
        near: &Joints,
        mut visit: impl FnMut(&Joints),
    ) -> Result<(), NoInverse> {
        let wanted = Wanted::of(X_WF, &self.X_WO, &self.R_CF, &self.p_CF);
        let seed = Seed::of(near, &self.offsets);
        let both = self.shoulders(&wanted, &seed).ok_or_else(|| self.out_of_reach(&wanted, &seed))?;
        let mut none = true;
        self.each(&wanted, &both, &seed, near, |joints| {
            if joints.iter().all(|q| q.is_finite()) {
                visit(joints);
                none = false;
            }
        });
        if none { Err(self.out_of_reach(&wanted, &seed)) } else { Ok(()) }
    }

    fn each(
        &self,
        wanted: &Wanted,
        shoulders: &[Shoulder; 2],
        seed: &Seed,
        near: &Joints,
        mut visit: impl FnMut(&Joints),
    ) {
        for shoulder in distinct(shoulders) {
            for wrist in distinct(&wrists(wanted, shoulder, seed)) {
                let Some(both) = self.elbows(wanted, shoulder, wrist, seed) else { continue };
                for elbow in distinct(&both) {
                    visit(&self.joints(shoulder, wrist, elbow, near));
                }
            }
        }
    }

    /// The singularity that `q` \[rad\] lies near, if any.
    pub(crate) fn near_singularity(&self, q: &Joints) -> Option<&'static str> {
        let [_, o2, o3, o4, o5, _] = self.offsets;
        let Links { l, k } = self.links;
        let phi2 = q[1] + o2;
        let phi3 = q[1] + self.signs.0 * q[2] + o3;
        let theta234 = q[1] + self.signs.0 * q[2] + self.signs.1 * q[3] + o4;
        let wrist = theta234.cos() * self.v.0 + theta234.sin() * self.v.1;
        let forward = self.a1 + l * phi2.sin() + k * phi3.sin() + wrist;
        if (q[4] + o5).sin().abs() < NEAR {
            Some("near the wrist singularity")
        } else if forward.abs() < NEAR * (l + k) {
            Some("near the shoulder singularity")
        } else if (phi3 - phi2).sin().abs() < NEAR {
            Some("near the elbow singularity")
        } else {
            None
        }
    }

    /// Both positions of the first joint; `None` where C is nearer to axis 1 than it stands beside the arm's plane.
    #[inline(always)]
    fn shoulders(&self, wanted: &Wanted, seed: &Seed) -> Option<[Shoulder; 2]> {
        shoulders(&wanted.centre, self.b, self.links.l + self.links.k, seed.theta1)
    }

    /// Where axis 4 must be, from axis 2: forwards and up \[m\].
    #[inline(always)]
    fn fourth(&self, wanted: &Wanted, shoulder: &Shoulder, wrist: &Wrist) -> (f64, f64) {
        let Direction { sine, cosine } = wrist.theta234;
        let (forward, up) = self.v;
        let across = shoulder.forward - self.a1 - (cosine * forward + sine * up);
        (across, wanted.centre.z - (cosine * up - sine * forward))
    }

    #[inline(always)]
    fn elbows(&self, wanted: &Wanted, shoulder: &Shoulder, wrist: &Wrist, seed: &Seed) -> Option<[Elbow; 2]> {
        let (across, height) = self.fourth(wanted, shoulder, wrist);
        elbows(self.links, across, height, seed.phi2)
    }

    #[inline(always)]
    fn joints(&self, shoulder: &Shoulder, wrist: &Wrist, elbow: &Elbow, near: &Joints) -> Joints {
        let [o1, o2, o3, o4, o5, o6] = self.offsets;
        let Wrist { theta234, theta5, theta6 } = wrist;
        let theta1 = shoulder.theta1;
        let [theta1, phi2, phi3, theta234, theta5, theta6] = atan2(
            [theta1.sine, elbow.phi2.sine, elbow.phi3.sine, theta234.sine, theta5.sine, theta6.sine],
            [
                theta1.cosine,
                elbow.phi2.cosine,
                elbow.phi3.cosine,
                theta234.cosine,
                theta5.cosine,
                theta6.cosine,
            ],
        );
        let q2 = phi2 - o2;
        let q23 = phi3 - o3;
        [
            closest(theta1 - o1, near[0]),
            closest(q2, near[1]),
            closest(self.signs.0 * (q23 - q2), near[2]),
            closest(self.signs.1 * (theta234 - o4 - q23), near[3]),
            closest(theta5 - o5, near[4]),
            closest(theta6 - o6, near[5]),
        ]
    }

    /// The error for a pose that cannot be reached: of the up to four places of axis 4 the one nearest to where it could be.
    #[cold]
    fn out_of_reach(&self, wanted: &Wanted, seed: &Seed) -> NoInverse {
        let Links { l, k } = self.links;
        let (min, max) = ((l - k).abs(), l + k);
        let Some(both) = self.shoulders(wanted, seed) else {
            let distance = wanted.centre.x.hypot(wanted.centre.y);
            let max = max + self.a1.abs() + self.v.0.hypot(self.v.1);
            return NoInverse::OutOfReach { distance, min: self.b.abs(), max };
        };
        let places = both.iter().flat_map(|shoulder| {
            wrists(wanted, shoulder, seed).map(|wrist| {
                let (across, height) = self.fourth(wanted, shoulder, &wrist);
                across.hypot(height)
            })
        });
        let beyond = |distance: &f64| (distance - max).max(min - distance);
        let nearest = places.min_by(|a, b| beyond(a).total_cmp(&beyond(b)));
        self.beyond(nearest.unwrap_or(f64::NAN))
    }

    /// The error for a place of axis 4 so far from axis 2 \[m\].
    fn beyond(&self, distance: f64) -> NoInverse {
        let Links { l, k } = self.links;
        NoInverse::OutOfReach { distance, min: (l - k).abs(), max: l + k }
    }
}

/// Both positions of the wrist for one of the first joint; on its singularity, where theta6 is undetermined and stays as in
/// the seed, they are the same.
#[inline(always)]
fn wrists(wanted: &Wanted, shoulder: &Shoulder, seed: &Seed) -> [Wrist; 2] {
    let Direction { sine: s1, cosine: c1 } = shoulder.theta1;
    let [x, y, z] = &wanted.columns;
    let forward = |v: &Vector3<f64>| c1 * v.x + s1 * v.y;
    let aside = |v: &Vector3<f64>| c1 * v.y - s1 * v.x;
    let (x1, z1) = (aside(x), aside(z));
    let across = (x1 * x1 + z1 * z1).sqrt();
    let singular = across < WRIST_SINGULAR;
    let theta6 = if singular {
        seed.theta6
    } else {
        let inverse = 1.0 / across;
        Direction { sine: z1 * inverse, cosine: x1 * inverse }
    };
    let (s6, c6) = (theta6.sine, theta6.cosine);
    let wrist = Wrist {
        theta234: Direction { sine: c6 * forward(z) - s6 * forward(x), cosine: c6 * z.z - s6 * x.z },
        theta5: Direction { sine: c6 * x1 + s6 * z1, cosine: aside(y) },
        theta6,
    };
    if singular {
        return [wrist; 2];
    }
    let theta5 = Direction { sine: -wrist.theta5.sine, ..wrist.theta5 };
    [wrist, Wrist { theta234: wrist.theta234.reversed(), theta5, theta6: theta6.reversed() }]
}

/// The sum of the squares by which a solution is off \[rad²\].
#[inline(always)]
fn off(q: &Joints, near: &Joints) -> f64 {
    let square = |i: usize| (q[i] - near[i]) * (q[i] - near[i]);
    square(0) + square(1) + square(2) + square(3) + square(4) + square(5)
}
